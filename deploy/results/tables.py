"""Markdown tables from records. A figure that is not there is said to be missing, never guessed."""

import runs

MISSING = "not trained yet"
TITLES = {
    "left_turn": "Left Turn-T",
    "roundabout_a": "Roundabout-A",
    "roundabout_b": "Roundabout-B",
    "roundabout_c": "Roundabout-C",
    "double_merge": "Double Merge",
}
# What `run_benchmark.py` calls the scripted drivers, and what the documents do.
DRIVER_TITLES = {
    "rdm": "`rdm`: keeps its lane at 15 m/s, never yields",
    "random": "`random`: an action held for 1 s",
    "idm": "`idm`: SUMO's careful driver (impatience 0)",
    "idm-impatient": "`idm`: SUMO's driver, impatience 1",
    "predictive": "`predictive`: our rules, predicts the others for 4 s",
    "slow": "`slow`: creeps at 4 m/s, never yields",
}
METHODS = {
    "context_only": "SAC with the context encoder only",
    "context_free": "without the context encoder",
    "dad_rl": "DAD-RL",
    "all": "DAD-RL, one policy for all five",
}


def table(header, rows, left=1):
    """The first `left` columns are text, the others numbers."""
    marks = ["---"] * left + ["---:"] * (len(header) - left)
    lines = [header, marks, *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def percent(rate):
    return f"{100 * rate:.1f}"


def with_interval(report, rate):
    low, high = report[f"{rate}_ci95"]
    return f"{percent(report[rate])} [{percent(low)}, {percent(high)}]"


def outcome_cells(report):
    cells = [with_interval(report, "success"), with_interval(report, "collision")]
    return cells + [percent(report["off_road"]), percent(report["stagnation"])]


def thousands(number):
    return f"{int(number):,}"


def minutes(seconds):
    return f"{seconds / 60:.1f}"


def method_of(record):
    """Which row of the paper's ablation a run is."""
    configuration = record["training"]["configuration"]
    if configuration.get("scenario") == "all":
        return "all"
    if configuration.get("model.stae") == "false":
        return "context_only"
    return "dad_rl" if configuration.get("model.context") == "true" else "context_free"


def compared_scenarios(records):
    """Scenarios in which at least two of the paper's three ablations were trained."""
    trained = {}
    for record in records.values():
        if method_of(record) != "all":
            trained.setdefault(record["scenario"], set()).add(method_of(record))
    return [scenario for scenario in TITLES if len(trained.get(scenario, ())) > 1]


def reports_of(record):
    """A record's evaluation by scenario."""
    evaluation = record["evaluation"]
    return {part["scenario"]: part for part in evaluation.get("per_scenario", [evaluation])}


def paper_cells(paper, row, scenario):
    success, collision, stagnation = paper["rows"][row][paper["scenarios"].index(scenario)]
    off_road = 100 - success - collision - stagnation
    return [str(success), str(collision), f"({off_road})", str(stagnation)]


def benchmark_scenario(scenario, reports, paper):
    rows = [["paper's RDM (SMARTS)", "50", *paper_cells(paper, "RDM", scenario), "", "", ""]]
    for driver, title in DRIVER_TITLES.items():
        report = reports.get(f"{scenario}-{driver}")
        if report is None:
            rows.append([title, "0", *["not run yet"] * 4, "", "", ""])
            continue
        figures = [f"{report['median_steps']:.0f}", f"{report['humanness_error']:.3f}", f"{report['overall_score']:.3f}"]
        rows.append([title, str(report["episodes"]), *outcome_cells(report), *figures])
    header = ["driver", "n", "success %", "collision %", "off-road %", "stagnation %", "steps", "humanness error", "score"]
    return f"### {TITLES[scenario]}\n\n" + table(header, rows)


def wilson(hits, trials):
    """95 % Wilson score interval, as proto/evaluation/wilson.h."""
    z = 1.959963984540054
    scale = 1 + z * z / trials
    centre = (hits / trials + z * z / (2 * trials)) / scale
    half = z / scale * (hits / trials * (1 - hits / trials) / trials + z * z / (4 * trials * trials)) ** 0.5
    return max(0.0, centre - half), min(1.0, centre + half)


def expectations(benchmark, prototype):
    """Each figure of the prototype beside ours; `apart` when the two intervals do not even touch."""
    rows = []
    for what in ("rdm collision", "predictive success", "random success"):
        driver, rate = what.split()
        for scenario, (hits, trials) in zip(prototype["scenarios"], prototype[what]):
            low, high = wilson(hits, trials)
            expected = f"{percent(hits / trials)} [{percent(low)}, {percent(high)}]"
            report = benchmark.get(f"{scenario}-{driver}")
            if report is None:
                rows.append([f"`{driver}` {rate}", TITLES[scenario], str(trials), expected, "not run yet", ""])
                continue
            ours_low, ours_high = report[f"{rate}_ci95"]
            verdict = "apart" if ours_low > high or ours_high < low else "agree"
            rows.append([f"`{driver}` {rate}", TITLES[scenario], str(trials), expected, with_interval(report, rate), verdict])
    return table(["%", "scenario", "n", "prototype", "here (n = 300)", ""], rows, left=2)


def creeping(benchmark):
    """What creeping gains and loses beside the driver that yields."""
    rows = []
    for scenario, title in TITLES.items():
        reports = [benchmark.get(f"{scenario}-{driver}") for driver in ("slow", "predictive")]
        if None in reports:
            rows.append([title, *["not run yet"] * 6])
            continue
        cells = [percent(report["success"]) for report in reports]
        cells += [f"{report['median_steps']:.0f}" for report in reports]
        cells += [f"{report['overall_score']:.3f}" for report in reports]
        rows.append([title, *cells])
    header = ["", "success %: `slow`", "`predictive`", "steps: `slow`", "`predictive`", "score: `slow`", "`predictive`"]
    return table(header, rows)


def kinds(report):
    found = sorted(report.get("collision_kinds", {}).items(), key=lambda item: -item[1])
    return ", ".join(f"{count} {kind}" for kind, count in found) or "none"


def collision_kinds(rows):
    """`rows`: (who, report)."""
    cells = [[who, str(report["episodes"]), str(round(report["collision"] * report["episodes"])), kinds(report)]
             for who, report in rows]
    return table(["driver", "n", "collisions", "of them"], cells)


def results_summary(paper, benchmark, records):
    """Success / collision / stagnation %, a column a scenario; seeds of one method are averaged."""
    def cell(reports):
        if not reports:
            return MISSING
        means = [sum(report[rate] for report in reports) / len(reports) for rate in ("success", "collision", "stagnation")]
        return " / ".join(f"{100 * mean:.0f}" for mean in means)

    rows = []
    for name in ("RDM", "SAC", "DAD-RL"):
        rows.append([f"paper: {name}"] + [" / ".join(map(str, figures)) for figures in paper["rows"][name]])
    for driver in ("rdm", "slow", "predictive"):
        reports = [benchmark.get(f"{scenario}-{driver}") for scenario in TITLES]
        rows.append([f"ours: `{driver}`"] + [cell([report]) if report else "not run yet" for report in reports])
    for method, title in METHODS.items():
        found = [reports_of(record) for record in records.values() if method_of(record) == method]
        rows.append([f"**ours: {title}**"]
                    + [cell([reports[scenario] for reports in found if scenario in reports]) for scenario in TITLES])
    return table(["", *TITLES.values()], rows)


def results_scenario(scenario, paper, benchmark, records):
    rows = []
    for name in paper["rows"]:
        rows.append([f"paper: {name}", *paper_cells(paper, name, scenario), "", "", ""])
    for driver in ("rdm", "slow", "predictive"):
        report = benchmark.get(f"{scenario}-{driver}")
        title = DRIVER_TITLES[driver].split(":")[0]
        rows.append(_result_row(f"ours: {title}", report, "not run yet"))
    for method, title in METHODS.items():
        found = [record for record in records.values()
                 if method_of(record) == method and scenario in reports_of(record)]
        for record in found:
            who = f"**ours: {title}**, seed {record['training']['seed']}"
            rows.append(_result_row(who, reports_of(record)[scenario], MISSING))
        if not found:
            rows.append(_result_row(f"**ours: {title}**", None, MISSING))
    header = ["", "success %", "collision %", "off-road %", "stagnation %", "steps", "humanness error", "score"]
    return f"### {TITLES[scenario]}\n\n" + table(header, rows)


def _result_row(who, report, missing):
    if report is None:
        return [who, missing, "", "", "", "", "", ""]
    figures = [f"{report['median_steps']:.0f}", f"{report['humanness_error']:.3f}", f"{report['overall_score']:.3f}"]
    return [who, *outcome_cells(report), *figures]


def chosen(record):
    """Which of a training's policies is shown."""
    selection = record.get("selection")
    if selection is None:
        return "the newest"
    return f"{thousands(selection['updates'])}: best of {len(selection['candidates'])}"


def training_cost(records):
    rows = []
    for name, record in records.items():
        training = record["training"]
        rows.append([f"`{name}`", METHODS[method_of(record)], str(training["seed"]), minutes(training["training_s"]),
                     thousands(training["env_steps"]), thousands(training["updates"]), chosen(record),
                     with_interval(record["evaluation"], "success"), training["machine"], training["commit"]])
    if not rows:
        return f"No run is recorded: {MISSING}."
    header = ["run", "method", "seed", "minutes", "environment steps", "updates", "policy", "success %", "machine", "commit"]
    return table(header, rows, left=2)


def configuration_changes(records):
    """One line a run: the keys in which it differs from deploy/config/default.yaml."""
    reference = runs.default_configuration()
    lines = []
    for name, record in records.items():
        changed = runs.changed_keys(record["training"]["configuration"], reference)
        text = ", ".join(f"`{key}={value}`" for key, value in changed.items()) or "the defaults"
        lines.append(f"- `{name}`: {text}")
    return "\n".join(lines) or f"No run is recorded: {MISSING}."


def experiment(records):
    """The runs of one controlled comparison."""
    if not records:
        return f"No run is recorded: {MISSING}."
    reference = runs.default_configuration()
    rows = []
    for name, record in records.items():
        training, evaluation = record["training"], record["evaluation"]
        changed = runs.changed_keys(training["configuration"], reference)
        interim = ", ".join(f"{point['updates'] / 1000:.1f}k: {percent(point['success'])}"
                            for point in record["evaluations"])
        rows.append([f"`{name}`", record["scenario"], "<br>".join(f"`{k}={v}`" for k, v in changed.items()) or "defaults",
                     interim or "none", str(training["seed"]), minutes(training["training_s"]),
                     thousands(training["env_steps"]), thousands(evaluation.get("updates", training["updates"])),
                     str(evaluation["episodes"]), with_interval(evaluation, "success"), percent(evaluation["collision"]),
                     f"{evaluation['median_steps']:.0f}"])
    header = ["run", "scenario", "differs from the defaults in", "success % on the way", "seed", "minutes",
              "environment steps", "updates", "n", "success %", "collision %", "steps"]
    return table(header, rows, left=4)
