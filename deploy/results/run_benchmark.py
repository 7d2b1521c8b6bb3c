#!/usr/bin/env python3
"""Drives the scripted drivers through every scenario and keeps what `dadrl evaluate --json` says:

  deploy/results/run_benchmark.py [--scenario NAME]... [--driver NAME]...

300 unseen episodes each (5 seed groups of 60), into docs/data/benchmark/SCENARIO-DRIVER.json. About a quarter of an
hour on two cores. Then deploy/results/make_docs.py benchmark writes docs/benchmark.md."""

import argparse
import pathlib
import subprocess
import sys

import runs

EPISODES = 60
SEEDS = 5
SCENARIOS = ("left_turn", "roundabout_a", "roundabout_b", "roundabout_c", "double_merge")
# Driver: policy and options of `dadrl evaluate`.
DRIVERS = {
    "rdm": ("rdm", ()),
    "random": ("random", ()),
    "idm": ("idm", ("--impatience", "0")),
    "idm-impatient": ("idm", ("--impatience", "1")),
    "predictive": ("predictive", ()),
    "slow": ("slow", ()),
}


def version(dadrl):
    return subprocess.run([str(dadrl), "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def main(argv):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", action="append", choices=SCENARIOS, help="only this (repeatable)")
    parser.add_argument("--driver", action="append", choices=DRIVERS, help="only this (repeatable)")
    parser.add_argument("--dadrl", type=pathlib.Path, default=runs.ROOT / "build/release/bin/dadrl")
    arguments = parser.parse_args(argv)
    try:
        for scenario in arguments.scenario or SCENARIOS:
            for driver in arguments.driver or DRIVERS:
                policy, extra = DRIVERS[driver]
                report = runs.evaluate(arguments.dadrl, policy, scenario, EPISODES, SEEDS, extra)
                report["driver"] = driver
                report["version"] = version(arguments.dadrl)
                runs.write_json(runs.DATA / "benchmark" / f"{scenario}-{driver}.json", report)
                print(f"{scenario} {driver}: success {100 * report['success']:.1f} %", flush=True)
    except (runs.ResultsError, OSError, subprocess.CalledProcessError) as error:
        print(f"run_benchmark.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
