import json
import unittest

from fixture import ResultsTest, report


class RecordRun(ResultsTest):
    def record(self, run, *more, answer=None, exit_code=0):
        dadrl = self.make_dadrl(answer or report(0.96), exit_code)
        return self.call("record_run", run, "--data", self.folder / "data", "--policies", self.folder / "policies",
                         "--dadrl", dadrl, *more)

    def read(self, *path):
        return json.loads(self.folder.joinpath(*path).read_text())

    def test_evaluates_the_newest_policy_and_keeps_what_the_training_took(self):
        code, out, err = self.record(self.make_run(changes={"gamma: 0.998": "gamma: 0.99"}), "--name", "left-1")
        self.assertEqual((code, err), (0, ""))
        self.assertIn("success 96.0 % of 250 episodes", out)
        record = self.read("data", "runs", "left-1.json")
        self.assertEqual(record["evaluation"]["success"], 0.96)
        training = record["training"]
        self.assertEqual((training["seed"], training["updates"], training["env_steps"]), (1, 4950, 90000))
        self.assertEqual((training["commit"], training["machine"]), ("abc", "two cores"))
        self.assertEqual(training["configuration"]["algorithm.gamma"], "0.99")
        self.assertEqual(record["evaluations"][0]["success"], 0.8)
        arguments = (self.folder / "arguments").read_text()
        self.assertIn("--scenario left_turn --episodes 50 --seeds 5 --json", arguments)

    def test_curve_has_rates_with_steps_seconds_and_updates(self):
        self.record(self.make_run())
        curve = self.read("data", "runs", "run.json")["curve"]
        self.assertEqual(len(curve), 40)
        self.assertEqual(curve[0], {"env_steps": 200, "elapsed_s": 22.0, "episodes": 2, "updates": 0, "success": 0.0,
                                    "collision": 1.0, "off_road": 0.0, "stagnation": 0.0})
        self.assertEqual(curve[-1]["env_steps"], 8000)
        self.assertEqual((curve[-1]["elapsed_s"], curve[-1]["updates"], curve[-1]["success"]), (100.0, 5000, 1.0))

    def test_ships_the_very_file_it_evaluated(self):
        run = self.make_run()
        self.assertEqual(self.record(run, "--ship", "left_turn")[0], 0)
        self.assertEqual((self.folder / "policies" / "left_turn.dadrl").read_bytes(),
                         (run / "checkpoints" / "latest").read_bytes())
        self.assertEqual(self.read("policies", "left_turn.json"), self.read("data", "runs", "run.json"))
        self.assertIn(str(run / "checkpoints" / "latest"), (self.folder / "arguments").read_text())

    def test_takes_the_policy_that_the_run_chose_and_says_of_how_many_on_which_traffic(self):
        run = self.make_run()
        self.choose(run, 4000)
        self.assertEqual(self.record(run, "--ship", "left_turn")[0], 0)
        self.assertIn(str(run / "checkpoints" / "best"), (self.folder / "arguments").read_text())
        self.assertEqual((self.folder / "policies" / "left_turn.dadrl").read_bytes(),
                         (run / "checkpoints" / "policy-000004000.dadrl").read_bytes())
        record = self.read("data", "runs", "run.json")
        self.assertEqual(record["training"]["updates"], 4950)
        selection = record["selection"]
        self.assertEqual((selection["updates"], selection["first_seed"], selection["episodes"]), (4000, 2000000, 100))
        self.assertEqual([(each["updates"], each["success"]) for each in selection["candidates"]],
                         [(4950, 0.9), (4000, 0.97), (3000, 0.9)])

    def test_another_policy_is_recorded_without_the_choice(self):
        run = self.make_run()
        self.choose(run, 4000)
        self.record(run, "--policy", run / "checkpoints" / "latest")
        self.assertNotIn("selection", self.read("data", "runs", "run.json"))

    def test_refuses_the_record_of_another_choice(self):
        run = self.make_run()
        self.choose(run, 4000)
        (run / "checkpoints" / "best").unlink()
        (run / "checkpoints" / "best").symlink_to("latest")
        code, _, err = self.record(run)
        self.assertEqual(code, 1)
        self.assertIn(f"choose again: dadrl select --run-dir {run}", err)
        self.assertFalse((self.folder / "data" / "runs").exists())

    def test_an_experiment_takes_the_evaluation_that_ended_the_run(self):
        self.assertEqual(self.record(self.make_run(), "--experiment", "n_step")[0], 0)
        self.assertFalse((self.folder / "arguments").exists())
        record = self.read("data", "experiments", "n_step", "run.json")
        self.assertEqual((record["evaluation"]["success"], record["evaluation"]["episodes"]), (0.9, 40))

    def test_says_what_is_missing_or_broken(self):
        code, _, err = self.call("record_run", self.folder / "nowhere")
        self.assertEqual(code, 1)
        self.assertIn("nowhere/results.json: No such file", err)
        run = self.make_run()
        self.assertIn("exit code 3", self.record(run, exit_code=3)[2])
        (run / "checkpoints" / "latest").write_text("not a policy at all, just text")
        self.assertIn("not a policy file", self.record(run)[2])
        (run / "results.json").write_text("{half")
        self.assertIn("results.json: not JSON", self.record(run)[2])
        (run / "results.json").write_text("{}")
        self.assertIn("no final evaluation", self.record(run, "--experiment", "x")[2])
        self.assertEqual(self.record(run, "--experiment", "x", "--ship", "y")[0], 2)
        self.assertFalse((self.folder / "data").exists())


if __name__ == "__main__":
    unittest.main()
