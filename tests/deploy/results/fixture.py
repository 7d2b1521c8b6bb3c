"""A finished run directory and a stand-in for `dadrl`, in a temporary folder."""

import contextlib
import importlib
import io
import json
import pathlib
import struct
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "deploy" / "results"))


def report(success, scenario="left_turn", episodes=250, **more):
    """As `dadrl evaluate --json` prints it: `success` of `episodes`, the rest collisions."""
    collision = 1 - success
    return {"scenario": scenario, "policy": "p", "episodes": episodes, "success": success, "collision": collision,
            "off_road": 0.0, "stagnation": 0.0, "median_steps": 180.0, "humanness_error": 0.25, "overall_score": 0.75,
            "success_ci95": [success - 0.02, min(1.0, success + 0.02)],
            "collision_ci95": [max(0.0, collision - 0.02), collision + 0.02],
            "collision_kinds": {"crossing": round(collision * episodes)}, **more}


class ResultsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def make_run(self, name="run", changes=None, results=None):
        """`changes`: {"algorithm.gamma: 0.998": "algorithm.gamma: 0.99"} as lines without their section."""
        run = self.folder / name
        (run / "logs").mkdir(parents=True)
        (run / "checkpoints").mkdir()
        config = (ROOT / "deploy" / "config" / "default.yaml").read_text()
        for old, new in (changes or {}).items():
            assert old in config, old
            config = config.replace(old, new)
        (run / "config.yaml").write_text(config)
        content = {"scenario": "left_turn", "seed": 1, "commit": "abc", "machine": "two cores", "state": "finished",
                   "training_s": 100.0, "updates": 5000, "env_steps": 90000, "training_episodes": 400,
                   "evaluations": [{"elapsed_s": 50.0, "updates": 2500, **report(0.8, episodes=40)}],
                   "final": {"elapsed_s": 100.0, "updates": 5000, **report(0.9, episodes=40)}}
        content.update(results or {})
        (run / "results.json").write_text(json.dumps(content))
        # 80 episodes of 100 steps, one a second; the first half collide, the second half succeed.
        rows = [f"{1000 + i}.0,0,{i},7,{'collision' if i < 40 else 'success'},100" for i in range(1, 81)]
        (run / "episodes.csv").write_text("time_s,actor,episode,seed,outcome,steps\n" + "\n".join(rows) + "\n")
        (run / "logs" / "training.csv").write_text("wall_time_s,trained_s,updates\n1e9,20,0\n1e9,60,2000\n1e9,100,5000\n")
        (run / "checkpoints" / "latest").write_bytes(b"DADRLPOL" + struct.pack("<IIQ", 2, 9, 4950) + b"weights")
        return run

    def choose(self, run, updates, of=(4950, 4000, 3000)):
        """As `dadrl select` leaves it: the policy of `updates` is the best of those of `of`."""
        best = run / "checkpoints" / f"policy-{updates:09}.dadrl"
        best.write_bytes(b"DADRLPOL" + struct.pack("<IIQ", 2, 8, updates) + b"chosen weights")
        (run / "checkpoints" / "best").symlink_to(best.name)
        candidates = [{"file": f"policy-{each:09}.dadrl", "updates": each, "policy_version": 1, "lost_episodes": 0,
                       **report(0.97 if each == updates else 0.9, episodes=100)} for each in of]
        (run / "selection.json").write_text(json.dumps({
            "scenario": "left_turn", "chosen": best.name, "updates": updates, "first_seed": 2000000, "episodes": 100,
            "commit": "abc", "candidates": candidates}))

    def make_dadrl(self, answer, exit_code=0):
        """A `dadrl` that answers with this report, and keeps its arguments in `arguments`."""
        program = self.folder / "dadrl"
        (self.folder / "answer.json").write_text(json.dumps(answer))
        program.write_text(f'#!/bin/sh\necho "$@" > {self.folder}/arguments\ncat {self.folder}/answer.json\nexit {exit_code}\n')
        program.chmod(0o755)
        return program

    def call(self, module, *arguments):
        """Exit code, standard output, standard error of a script's main."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = importlib.import_module(module).main([str(argument) for argument in arguments])
            except SystemExit as exit_request:
                code = exit_request.code
        return code, out.getvalue(), err.getvalue()
