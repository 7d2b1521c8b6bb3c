#!/usr/bin/env python3
"""Writes docs/benchmark.md, docs/results.md and docs/experiments.md from docs/templates and the figures in docs/data:

  deploy/results/make_docs.py [benchmark|results|experiments]...     all without a name
  deploy/results/make_docs.py --check                                 exit code 1 when one is not up to date

Prose stands in the templates; `{{name}}` or `{{name argument}}` on a line of its own becomes a table or a picture.
Pictures need python3-matplotlib (Debian); without it the committed ones stay."""

import argparse
import pathlib
import re
import sys

import runs
import tables

DOCUMENTS = ("benchmark", "results", "experiments")
ABLATION_PICTURES = {
    "humanness_error": "Humanness error of the ablations",
    "overall_score": "Overall score of the ablations",
}
PLACEHOLDER = re.compile(r"^\{\{([a-z_]+)(?: ([a-z0-9_]+))?\}\}$", re.MULTILINE)


class Documents:
    """What a template can ask for: each public method is a placeholder's name."""

    def __init__(self, data):
        self.data = data
        self.paper = runs.read_json(data / "paper.json")
        self.prototype = runs.read_json(data / "prototype.json")
        self.reports = runs.load_records(data / "benchmark")
        self.records = runs.load_records(data / "runs")

    def benchmark_tables(self):
        return "\n\n".join(tables.benchmark_scenario(name, self.reports, self.paper) for name in tables.TITLES)

    def benchmark_collisions(self):
        rows = [(f"{tables.TITLES[report['scenario']]}, `{report['driver']}`", report)
                for scenario in tables.TITLES for report in self.reports.values()
                if report["scenario"] == scenario and report["collision"] > 0]
        return tables.collision_kinds(rows)

    def benchmark_expected(self):
        return tables.expectations(self.reports, self.prototype)

    def benchmark_creeping(self):
        return tables.creeping(self.reports)

    def benchmark_version(self):
        versions = sorted({report.get("version", "unknown") for report in self.reports.values()})
        return "Driven with " + (", ".join(versions) or "nothing yet") + "."

    def results_summary(self):
        return tables.results_summary(self.paper, self.reports, self.records)

    def results_tables(self):
        return "\n\n".join(tables.results_scenario(name, self.paper, self.reports, self.records)
                           for name in tables.TITLES)

    def results_collisions(self):
        rows = [(f"{tables.TITLES[scenario]}, `{name}`", report)
                for name, record in self.records.items() for scenario, report in tables.reports_of(record).items()
                if "collision_kinds" in report]
        return tables.collision_kinds(rows)

    def training_cost(self):
        return tables.training_cost(self.records)

    def configuration_changes(self):
        return tables.configuration_changes(self.records)

    def experiment(self, group):
        return tables.experiment(runs.load_records(self.data / "experiments" / group))

    def picture(self, name):
        """Nothing for an experiment without runs: its table says so."""
        if name == "learning_curves":
            there, title = self.records, "Success while training"
        elif name in ABLATION_PICTURES:
            there, title = tables.compared_scenarios(self.records), ABLATION_PICTURES[name]
        else:
            there, title = runs.load_records(self.data / "experiments" / name), f"Success while training: {name}"
        if not there:
            return "Not drawn yet: the runs are missing." if title in ABLATION_PICTURES.values() else ""
        return f"![{title}](images/{name}.svg)"


def render(template, documents, origin):
    def fill(match):
        name, argument = match.groups()
        method = getattr(documents, name, None) if not name.startswith("_") else None
        if not callable(method):
            raise runs.ResultsError(f"{origin}: unknown placeholder {match.group(0)}")
        return method(argument) if argument else method()

    text = PLACEHOLDER.sub(fill, template)
    if "{{" in text:
        raise runs.ResultsError(f"{origin}: a placeholder must stand alone on its line")
    head = f"<!-- Made by deploy/results/make_docs.py from {origin} and docs/data; edit those. -->\n"
    return head + text


def main(argv):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("documents", nargs="*", help=", ".join(DOCUMENTS))
    parser.add_argument("--check", action="store_true", help="compare only")
    parser.add_argument("--no-pictures", action="store_true", help="text only")
    parser.add_argument("--docs", type=pathlib.Path, default=runs.ROOT / "docs", help=argparse.SUPPRESS)
    arguments = parser.parse_args(argv)
    for name in arguments.documents:
        if name not in DOCUMENTS:
            parser.error(f"unknown document '{name}' (there are: {', '.join(DOCUMENTS)})")
    stale = []
    try:
        documents = Documents(arguments.docs / "data")
        for name in arguments.documents or DOCUMENTS:
            template = arguments.docs / "templates" / f"{name}.md"
            text = render(runs.read_text(template), documents, f"docs/templates/{name}.md")
            target = arguments.docs / f"{name}.md"
            if target.exists() and target.read_text() == text:
                continue
            stale.append(target.name)
            if not arguments.check:
                target.write_text(text)
        if not arguments.check and not arguments.no_pictures:
            draw(arguments.docs, documents)
    except runs.ResultsError as error:
        print(f"make_docs.py: {error}", file=sys.stderr)
        return 1
    if arguments.check and stale:
        print(f"not up to date: {', '.join(stale)}; run deploy/results/make_docs.py", file=sys.stderr)
        return 1
    return 0


def draw(docs, documents):
    try:
        import plots
    except ImportError:
        print("pictures stay as they are: python3-matplotlib is not installed", file=sys.stderr)
        return
    plots.draw_all(docs / "images", documents.records, docs / "data" / "experiments")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
