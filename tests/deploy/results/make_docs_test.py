import importlib.util
import shutil
import unittest

from fixture import ROOT, ResultsTest, report

import runs
import tables


class MakeDocs(ResultsTest):
    def setUp(self):
        super().setUp()
        self.docs = self.folder / "docs"
        shutil.copytree(ROOT / "docs" / "templates", self.docs / "templates")
        (self.docs / "data").mkdir()
        for name in ("paper.json", "prototype.json"):
            shutil.copy(ROOT / "docs" / "data" / name, self.docs / "data")

    def add(self, path, value):
        runs.write_json(self.docs / "data" / path, value)

    def add_run(self, name, success, changes=None, **more):
        record = {"name": name, **runs.read_run(self.make_run(name, changes))}
        record["evaluation"] = report(success, record["scenario"], **more)
        self.add(f"runs/{name}.json", record)

    def make(self, *arguments):
        return self.call("make_docs", "--docs", self.docs, "--no-pictures", *arguments)

    def lines(self, name, start):
        return [line for line in (self.docs / f"{name}.md").read_text().splitlines() if line.startswith(start)]

    def test_missing_figures_are_said_to_be_missing(self):
        self.assertEqual(self.make()[0], 0)
        self.assertEqual(len(self.lines("results", "| **ours: DAD-RL** | not trained yet |")), 6)
        self.assertEqual(len(self.lines("benchmark", "| `rdm`: keeps its lane at 15 m/s, never yields | 0 | not run yet")), 5)
        self.assertIn("No run is recorded", (self.docs / "results.md").read_text())

    def test_every_row_shows_its_record(self):
        self.add("benchmark/left_turn-rdm.json", report(0.44, episodes=300, driver="rdm", version="dadrl 1"))
        self.add_run("lt-1", 0.96)
        self.add_run("lt-2", 0.98)
        self.add_run("lt-context", 0.7, {"stae: true": "stae: false"})
        self.add_run("lt-free", 0.9, {"context: true": "context: false"})
        self.assertEqual(self.make()[0], 0)
        self.assertEqual(self.lines("benchmark", "| `rdm`")[0],
                         "| `rdm`: keeps its lane at 15 m/s, never yields | 300 | 44.0 [42.0, 46.0] | 56.0 [54.0, 58.0] "
                         "| 0.0 | 0.0 | 180 | 0.250 | 0.750 |")
        self.assertEqual(self.lines("benchmark", "| Left Turn-T, `rdm`"),
                         ["| Left Turn-T, `rdm` | 300 | 168 | 168 crossing |"])
        rows = self.lines("results", "| **ours: DAD-RL**, seed 1 ")
        self.assertEqual(rows[0], "| **ours: DAD-RL**, seed 1 | 96.0 [94.0, 98.0] | 4.0 [2.0, 6.0] | 0.0 | 0.0 | 180 | 0.250 | 0.750 |")
        self.assertEqual(len(rows), 2)
        self.assertTrue(self.lines("results", "| **ours: DAD-RL** | 97 / 3 / 0 | not trained yet |"))
        self.assertTrue(self.lines("results", "| **ours: SAC with the context encoder only**, seed 1 | 70.0"))
        self.assertTrue(self.lines("results", "| **ours: without the context encoder**, seed 1 | 90.0"))
        self.assertIn("- `lt-free`: `model.context=false`", self.lines("results", "- `lt-free`"))
        self.assertIn("- `lt-1`: the defaults", self.lines("results", "- `lt-1`"))
        self.assertTrue(self.lines("results", "| `lt-1` | DAD-RL | 1 | 1.7 | 90,000 | 5,000 | the newest | 96.0"))
        self.assertTrue(self.lines("results", "| paper: DAD-RL | 98 | 0 | (2) | 0 |"))

    def test_says_which_of_how_many_policies_was_chosen(self):
        run = self.make_run("lt-1")
        self.choose(run, 4000)
        record = {"name": "lt-1", **runs.read_run(run), **runs.read_selection(run), "evaluation": report(0.96)}
        self.add("runs/lt-1.json", record)
        self.assertEqual(self.make("results")[0], 0)
        self.assertTrue(self.lines("results", "| `lt-1` | DAD-RL | 1 | 1.7 | 90,000 | 5,000 | 4,000: best of 3 | 96.0"))

    def test_one_policy_for_all_has_a_row_in_every_scenario(self):
        parts = [report(0.5 + 0.1 * i, name) for i, name in enumerate(tables.TITLES)]
        self.add_run("all-1", 0.7, {"scenario: left_turn": "scenario: all"}, per_scenario=parts)
        self.assertEqual(self.make("results")[0], 0)
        rows = self.lines("results", "| **ours: DAD-RL, one policy for all five**, seed 1 |")
        self.assertEqual([row.split("|")[2].split()[0] for row in rows], ["50.0", "60.0", "70.0", "80.0", "90.0"])

    def test_an_experiment_is_a_table_of_its_runs(self):
        (self.docs / "templates" / "experiments.md").write_text("# n-step\n\n{{experiment n_step}}\n")
        record = {"name": "n1", **runs.read_run(self.make_run("n1", {"n_step: 3": "n_step: 1"}))}
        self.add("experiments/n_step/n1.json", {**record, "evaluation": report(0.75, episodes=40, updates=5000)})
        self.assertEqual(self.make("experiments")[0], 0)
        self.assertEqual(self.lines("experiments", "| `n1`"),
                         ["| `n1` | left_turn | `algorithm.n_step=1` | 2.5k: 80.0 | 1 | 1.7 | 90,000 | 5,000 | 40 "
                          "| 75.0 [73.0, 77.0] | 25.0 | 180 |"])

    def test_check_tells_a_document_that_is_behind_its_figures(self):
        self.make()
        self.assertEqual(self.make("--check")[0], 0)
        self.add("benchmark/left_turn-rdm.json", report(0.44, driver="rdm"))
        code, _, err = self.make("--check")
        self.assertEqual(code, 1)
        self.assertIn("not up to date: benchmark.md, results.md", err)

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "python3-matplotlib is not installed")
    def test_draws_what_there_is_and_the_same_bytes_again(self):
        self.add_run("lt-1", 0.96)
        self.add_run("lt-context", 0.7, {"stae: true": "stae: false"})
        pictures = []
        for _ in range(2):
            self.assertEqual(self.call("make_docs", "--docs", self.docs)[0], 0)
            pictures.append({path.name: path.read_bytes() for path in (self.docs / "images").iterdir()})
        self.assertEqual(sorted(pictures[0]), ["humanness_error.svg", "learning_curves.svg", "overall_score.svg"])
        self.assertEqual(pictures[0], pictures[1])

    def test_names_the_file_that_is_damaged_or_wrong(self):
        self.assertEqual(self.make("bechmark")[0], 2)
        (self.docs / "templates" / "benchmark.md").write_text("{{benchmrk_tables}}\n")
        self.assertIn("docs/templates/benchmark.md: unknown placeholder {{benchmrk_tables}}", self.make("benchmark")[2])
        (self.docs / "templates" / "benchmark.md").write_text("see {{benchmark_tables}}\n")
        self.assertIn("must stand alone", self.make("benchmark")[2])
        (self.docs / "data" / "runs").mkdir()
        (self.docs / "data" / "runs" / "broken.json").write_text("[")
        code, _, err = self.make()
        self.assertEqual(code, 1)
        self.assertIn("broken.json: not JSON", err)


class Tables(unittest.TestCase):
    # Newcombe (1998), table I, method 3: 81 of 263 and 15 of 148.
    def test_wilson_agrees_with_the_published_examples(self):
        for hits, trials, low, high in ((81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605)):
            found = tables.wilson(hits, trials)
            self.assertAlmostEqual(found[0], low, places=4)
            self.assertAlmostEqual(found[1], high, places=4)

    def test_expectations_say_when_intervals_do_not_touch(self):
        prototype = {"scenarios": ["left_turn"], "rdm collision": [[56, 100]], "predictive success": [[10, 40]], "random success": [[1, 40]]}
        reports = {"left_turn-rdm": report(0.44), "left_turn-predictive": report(0.98)}
        lines = tables.expectations(reports, prototype).splitlines()
        self.assertTrue(lines[2].endswith("| 56.0 [54.0, 58.0] | agree |"), lines[2])
        self.assertTrue(lines[3].endswith("| 98.0 [96.0, 100.0] | apart |"), lines[3])
        self.assertTrue(lines[4].endswith("| not run yet |  |"), lines[4])


class FlatConfiguration(unittest.TestCase):
    def test_joins_sections_and_leaves_comments_out(self):
        text = "seed: 1\ntask:\n  # weights\n  reward:\n    goal: 3  # once\n  max_steps: 800\n"
        self.assertEqual(runs.flat_configuration(text, "x"),
                         {"seed": "1", "task.reward.goal": "3", "task.max_steps": "800"})

    def test_names_the_line_that_is_none(self):
        with self.assertRaisesRegex(runs.ResultsError, "x:2"):
            runs.flat_configuration("seed: 1\nwhat\n", "x")


if __name__ == "__main__":
    unittest.main()
