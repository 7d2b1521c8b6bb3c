#!/usr/bin/env python3
"""Turns a finished run of `dadrl train` into a record that the documents are made from, and into a shipped policy.

  deploy/results/record_run.py runs/left_turn-seed1 --name left_turn-seed1 --ship left_turn
      evaluates the policy that the run chose on 5 x 50 unseen episodes (of each scenario when it was trained on all), writes
      docs/data/runs/left_turn-seed1.json, and copies the policy with that record to deploy/policies/left_turn.*
  deploy/results/record_run.py runs/n_step_1 --experiment n_step
      a short controlled run: the evaluation that ended it is enough; writes docs/data/experiments/n_step/n_step_1.json

Then deploy/results/make_docs.py writes the tables and pictures."""

import argparse
import pathlib
import shutil
import sys

import runs


def parse(argv):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=pathlib.Path, help="run directory")
    parser.add_argument("--name", help="of the record (default: the directory's)")
    parser.add_argument("--policy", type=pathlib.Path, help="default: RUN/checkpoints/best, or latest where none was chosen")
    parser.add_argument("--ship", metavar="NAME", help="also ship the policy: pretrained:NAME")
    parser.add_argument("--experiment", metavar="GROUP", help="record as a run of this experiment, not evaluated again")
    parser.add_argument("--episodes", type=int, default=50, help="of each seed group (default 50)")
    parser.add_argument("--seeds", type=int, default=5, help="seed groups (default 5)")
    parser.add_argument("--commit", help="when the run's results.json does not say")
    parser.add_argument("--machine", help="likewise")
    parser.add_argument("--dadrl", type=pathlib.Path, default=runs.ROOT / "build/release/bin/dadrl")
    parser.add_argument("--data", type=pathlib.Path, default=runs.DATA, help=argparse.SUPPRESS)
    parser.add_argument("--policies", type=pathlib.Path, default=runs.ROOT / "deploy/policies", help=argparse.SUPPRESS)
    arguments = parser.parse_args(argv)
    if arguments.experiment and arguments.ship:
        parser.error("--experiment with --ship: only a run evaluated in full can ship")
    return arguments


def record_experiment(arguments, record):
    results = runs.read_json(arguments.run / "results.json")
    if "final" not in results:
        raise runs.ResultsError(f"{arguments.run}: no final evaluation in results.json; let the run end by itself")
    record["evaluation"] = results["final"]
    record.update(runs.read_selection(arguments.run))
    return arguments.data / "experiments" / arguments.experiment / f"{record['name']}.json"


def record_result(arguments, record):
    newest = arguments.run / "checkpoints" / "latest"
    policy = arguments.policy or runs.chosen_policy(arguments.run) or newest
    record["training"]["updates"] = runs.policy_updates(arguments.policy or newest)
    if not arguments.policy:
        record.update(runs.read_selection(arguments.run))
    record["evaluation"] = runs.evaluate(
        arguments.dadrl, policy, record["scenario"], arguments.episodes, arguments.seeds
    )
    record["evaluation"]["policy"] = record["name"]
    if arguments.ship:
        arguments.policies.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(runs.follow_link(policy), arguments.policies / f"{arguments.ship}.dadrl")
        runs.write_json(arguments.policies / f"{arguments.ship}.json", record)
    return arguments.data / "runs" / f"{record['name']}.json"


def main(argv):
    arguments = parse(argv)
    try:
        record = {"name": arguments.name or arguments.run.resolve().name, **runs.read_run(arguments.run)}
        for key in ("commit", "machine"):
            record["training"][key] = getattr(arguments, key) or record["training"][key]
        path = record_experiment(arguments, record) if arguments.experiment else record_result(arguments, record)
        runs.write_json(path, record)
    except (runs.ResultsError, OSError) as error:
        print(f"record_run.py: {error}", file=sys.stderr)
        return 1
    evaluation = record["evaluation"]
    print(f"{path}: success {100 * evaluation['success']:.1f} % of {evaluation['episodes']} episodes")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
