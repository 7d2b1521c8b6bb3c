"""Reads run directories of `dadrl train` into records: small JSON objects that documents are made from.

Python's standard library only. Errors are ResultsError with a sentence for the user."""

import csv
import json
import pathlib
import struct
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "docs" / "data"
CURVE_POINTS = 40
RATES = ("success", "collision", "off_road", "stagnation")


class ResultsError(Exception):
    pass


def read_text(path):
    try:
        return pathlib.Path(path).read_text()
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror}") from error


def read_json(path):
    try:
        value = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise ResultsError(f"{path}: not JSON: {error}") from error
    if not isinstance(value, dict):
        raise ResultsError(f"{path}: not a JSON object")
    return value


def write_json(path, value):
    """Beside, then renamed: a reader sees the old file or the new one."""
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps(value, indent=1) + "\n")
    temporary.replace(path)


def flat_configuration(text, origin):
    """{"algorithm.gamma": "0.998", ...} of the YAML that `dadrl config` writes: nested `key: value` lines."""
    values, sections = {}, []
    for number, line in enumerate(text.splitlines(), 1):
        content = line.split("#", 1)[0].rstrip()
        if not content:
            continue
        key, colon, value = content.strip().partition(":")
        depth = (len(content) - len(content.lstrip())) // 2
        if not colon or depth > len(sections):
            raise ResultsError(f"{origin}:{number}: not a 'key: value' line: {line}")
        sections = sections[:depth] + [key]
        if value:
            values[".".join(sections)] = value.strip()
    return values


def default_configuration():
    path = ROOT / "deploy" / "config" / "default.yaml"
    return flat_configuration(read_text(path), path)


def changed_keys(configuration, reference):
    """What `configuration` sets differently, without what names a run or its machine."""
    aside = ("scenario", "seed", "minutes", "cluster.", "telemetry.", "learner.max_updates", "evaluation.")
    # The same class under two names, which differ in keys of their own; the older records know only this one.
    same = {"algorithm.name": "sac"}
    return {
        key: value
        for key, value in configuration.items()
        if reference.get(key) != value and same.get(key) != value and not key.startswith(aside)
    }


def evaluate(dadrl, policy, scenario, episodes, seeds, extra=()):
    """The JSON object of `dadrl evaluate`, with the command that made it."""
    arguments = ["evaluate", "--policy", str(policy), "--scenario", scenario, "--episodes", str(episodes)]
    arguments += ["--seeds", str(seeds), *extra]
    try:
        done = subprocess.run([str(dadrl), *arguments, "--json"], stdout=subprocess.PIPE, check=False)
    except OSError as error:
        raise ResultsError(f"{dadrl}: {error.strerror}; build first: cmake --build --preset release") from error
    if done.returncode != 0:
        raise ResultsError(f"dadrl {' '.join(arguments)}: exit code {done.returncode}")
    return json.loads(done.stdout)


def follow_link(path):
    """What a link of ours names where the file system has no symbolic links (common/io/link_file.h)."""
    path = pathlib.Path(path)
    with open(path, "rb") as file:
        mark, _, name = file.read(512).partition(b": ")
    return path.with_name(name.decode().strip()) if mark == b"dadrl link" else path


def policy_updates(path):
    """Training updates behind a policy file, from its head (common/model/policy_file.h)."""
    with open(follow_link(path), "rb") as file:
        head = file.read(24)
    if len(head) < 24 or head[:8] != b"DADRLPOL":
        raise ResultsError(f"{path}: not a policy file")
    return struct.unpack("<8sIIQ", head)[3]


def chosen_policy(run):
    """checkpoints/best of a run; None where nothing was chosen: runs of earlier versions, or training that goes on."""
    path = pathlib.Path(run) / "checkpoints" / "best"
    return path if path.exists() else None


def read_selection(run):
    """{"selection": how the run's policy was chosen}, from selection.json; {} when it is the newest unasked."""
    path = pathlib.Path(run) / "selection.json"
    if not path.exists():
        return {}
    selection = read_json(path)
    best = chosen_policy(run)
    if best is None or policy_updates(best) != selection.get("updates"):
        raise ResultsError(f"{path}: is not about {run}/checkpoints/best; choose again: dadrl select --run-dir {run}")
    kept = ("updates", "episodes", "lost_episodes", *RATES, "success_ci95", "median_steps")
    candidates = [{key: candidate[key] for key in kept} for candidate in selection["candidates"]]
    return {"selection": {**{key: selection[key] for key in ("updates", "first_seed", "episodes")},
                          "candidates": candidates}}


def _updates_by_time(run):
    """[(wall time, updates)] of logs/training.csv; empty without it."""
    path = run / "logs" / "training.csv"
    if not path.exists():
        return []
    with open(path, newline="") as file:
        return [(float(row["trained_s"]), int(row["updates"])) for row in csv.DictReader(file)]


def training_curve(run, training_s):
    """Rates of the training episodes in CURVE_POINTS pieces of equal length, with the environment steps, seconds and
    updates at the end of each. Episodes are counted by the launcher's clock, updates by the learner's."""
    path = run / "episodes.csv"
    if not path.exists():
        return []
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        return []
    updates = _updates_by_time(run)
    last_s = float(rows[-1]["time_s"])
    points, steps = [], 0
    for piece in range(CURVE_POINTS):
        part = rows[len(rows) * piece // CURVE_POINTS : len(rows) * (piece + 1) // CURVE_POINTS]
        if not part:
            continue
        steps += sum(int(row["steps"]) for row in part)
        elapsed_s = max(0.0, training_s - (last_s - float(part[-1]["time_s"])))
        point = {"env_steps": steps, "elapsed_s": round(elapsed_s, 1), "episodes": len(part)}
        point["updates"] = max((done for when, done in updates if when <= elapsed_s), default=0)
        for rate in RATES:
            point[rate] = round(sum(row["outcome"] == rate for row in part) / len(part), 4)
        points.append(point)
    return points


def read_run(run):
    """The record of a run directory, without name and final evaluation."""
    run = pathlib.Path(run)
    results = read_json(run / "results.json")
    configuration = flat_configuration(read_text(run / "config.yaml"), run / "config.yaml")
    kept = ("elapsed_s", "updates", "env_steps", "episodes", *RATES, "success_ci95", "median_steps")
    evaluations = [
        {key: evaluation[key] for key in kept if key in evaluation} for evaluation in results.get("evaluations", [])
    ]
    training_s = float(results.get("training_s", 0.0))
    return {
        "scenario": configuration["scenario"],
        "training": {
            "seed": int(configuration["seed"]),
            "commit": results.get("commit", "unknown"),
            "machine": results.get("machine", "unknown"),
            "state": results.get("state", "unknown"),
            "updates": results.get("updates", 0),
            "env_steps": results.get("env_steps", 0),
            "episodes": results.get("training_episodes", 0),
            "training_s": round(training_s, 1),
            "configuration": configuration,
        },
        "evaluations": evaluations,
        "curve": training_curve(run, training_s),
    }


def load_records(folder):
    """Every record of a folder by file name; an absent folder holds none."""
    return {path.stem: read_json(path) for path in sorted(pathlib.Path(folder).glob("*.json"))}
