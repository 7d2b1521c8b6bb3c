"""Pictures of the documents (SVG), drawn by matplotlib: the same bytes from the same records and version."""

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  after the backend is chosen

import runs  # noqa: E402
import tables  # noqa: E402

ABLATION = {"context_only": "SAC (context)", "context_free": "context-free", "dad_rl": "DAD-RL"}
LINES = ("-", "--", ":")  # there are ten colours
COLOURS = {"context_only": "#b0b0b0", "context_free": "#6b9ac4", "dad_rl": "#1f4e79"}
plt.rcParams.update({"svg.hashsalt": "dadrl", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False})


def save(figure, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None}, bbox_inches="tight")
    plt.close(figure)


def ablation_values(records, field):
    """{method: {scenario: mean over seeds}} of the runs that are there."""
    found = {}
    for record in records.values():
        method = tables.method_of(record)
        if method in ABLATION:
            found.setdefault(method, {}).setdefault(record["scenario"], []).append(record["evaluation"][field])
    return {method: {scenario: sum(values) / len(values) for scenario, values in by_scenario.items()}
            for method, by_scenario in found.items()}


def draw_ablation(path, records, field, label):
    values = ablation_values(records, field)
    scenarios = tables.compared_scenarios(records)
    if not scenarios:
        return
    figure, axes = plt.subplots(figsize=(1.2 + 1.6 * len(scenarios), 2.8))
    for place, (method, title) in enumerate(ABLATION.items()):
        here = [(index, values.get(method, {}).get(name)) for index, name in enumerate(scenarios)]
        bars = axes.bar([index + 0.27 * (place - 1) for index, value in here if value is not None],
                        [value for _, value in here if value is not None], width=0.25, color=COLOURS[method], label=title)
        axes.bar_label(bars, fmt="%.2f", fontsize=7)
    axes.set_xticks(range(len(scenarios)), [tables.TITLES[name] for name in scenarios])
    axes.set_ylabel(label)
    axes.legend(frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    save(figure, path)


def draw_curves(path, records):
    """Training success (lines) and evaluations on unseen traffic (marks) against steps, updates and time."""
    drawable = {name: record for name, record in records.items() if record["curve"] or record["evaluations"]}
    if not drawable:
        return
    units = (("env_steps", 1e6, "environment steps, millions"), ("updates", 1e3, "updates, thousands"),
             ("elapsed_s", 60.0, "minutes"))
    figure, panels = plt.subplots(1, 3, figsize=(11, 3.2), sharey=True)
    for number, (name, record) in enumerate(drawable.items()):
        colour, style = f"C{number % 10}", LINES[number // 10 % len(LINES)]
        for axes, (key, scale, _) in zip(panels, units):
            axes.plot([point[key] / scale for point in record["curve"]],
                      [100 * point["success"] for point in record["curve"]], color=colour, linestyle=style,
                      linewidth=1.2, label=name)
            marks = [point for point in record["evaluations"] if key in point]
            axes.plot([point[key] / scale for point in marks], [100 * point["success"] for point in marks],
                      "o", markersize=4, color=colour)
    for axes, (_, _, label) in zip(panels, units):
        axes.set_xlabel(label)
        axes.set_ylim(0, 101)
        axes.grid(alpha=0.25)
    panels[0].set_ylabel("success %")
    panels[0].legend(frameon=False, fontsize=7)
    save(figure, path)


def draw_all(images, records, experiments):
    draw_ablation(images / "humanness_error.svg", records, "humanness_error", "humanness error (less is better)")
    draw_ablation(images / "overall_score.svg", records, "overall_score", "overall score (more is better)")
    whole = {name: record for name, record in records.items() if tables.method_of(record) in ("dad_rl", "all")}
    draw_curves(images / "learning_curves.svg", whole)
    for group in sorted(path for path in experiments.glob("*") if path.is_dir()):
        draw_curves(images / f"{group.name}.svg", runs.load_records(group))
