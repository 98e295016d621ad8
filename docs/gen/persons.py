"""How many scores persons need: a chart and a page from the curves of an evaluation.

``python -m docs.gen.persons out/persons`` reads the folder of ``grammarlab evaluate … --person … -o out/persons``.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import median

import matplotlib as mpl

mpl.use("Agg")

from matplotlib.figure import Figure

from docs.gen.reference import DOCS
from grammarlab.runs.evaluate.curve_store import CurveRecord, curves_in

PAGE = DOCS / "evaluation" / "persons.md"
CHART = DOCS / "images" / "persons.png"
SCORES = (8, 16, 24, 32, 48, 64, 96, 128)
"""Numbers of scores of the chart."""
COLUMNS = (24, 64, 128)
"""Numbers of scores of the table."""
PERSONS = {
    "exact": "who says exactly what they think",
    "stars": "who gives five stars",
    "sd10": "who errs by 10 points",
    "blunders10": "of whose scores one in ten is random",
    "sd20": "who errs by 20 points",
}
TENTH = 0.1
"""Share of the first divergence at which a taste counts as learned."""
WORSE = 1.05
"""Ratio to the first divergence above which learning did harm."""

EXPLAINED = """
A taste is learned here from the number of scores on after which never more than a tenth of the divergence between the
grammar and the taste is left. Lines are medians over tastes, bands their middle halves; one simulated person each,
default questions in rounds of eight. The learner has been developed against these tastes;
[Ten fresh tastes](fresh.md) were not seen before they were measured, and [Results](results.md) and
[Earlier scenarios](once.md) have others.
The numbers are from shortly before held-out scores counted with a quarter of their likelihood again and lines of exact
scores started wide again, so a run of the command below may differ in single tastes.

Divergences in nats; *harmed*: tastes for which the learned density after 24 scores is farther than 1.05 times that of
the grammar as it was.
"""


def left(record: CurveRecord, scores: int) -> float:
    """Share of the first divergence that is left after a number of scores."""
    return divergence(record, scores) / record.js_original


def divergence(record: CurveRecord, scores: int) -> float:
    """Divergence after the last round within a number of scores, nats."""
    return [point.js for point in record.curve.points if point.labels <= scores][-1]


def needed(record: CurveRecord) -> float:
    """Number of scores from which at most a tenth of the first divergence is left; infinite if more is at the end."""
    stays = record.curve.labels_until_below(TENTH * record.js_original)
    return float("inf") if stays is None else stays


def sentence(person: str, records: Sequence[CurveRecord]) -> str:
    """How many scores a person needs, in words."""
    half, soon = median(map(needed, records)), sum(needed(record) <= COLUMNS[1] for record in records)
    until = "more than 128" if half > COLUMNS[-1] else f"{half:.0f}"
    return (
        f"- Somebody {PERSONS[person]} (`{person}`) needs {until} scores in the middle of {len(records)} tastes; "
        f"{soon} of them are learned after 64."
    )


def row(person: str, records: Sequence[CurveRecord]) -> str:
    """A row of the table."""
    cells = [f"{median(divergence(record, num) for record in records):.4f}" for num in COLUMNS]
    worst = max(records, key=lambda record: divergence(record, COLUMNS[-1]))
    harmed = sum(left(record, COLUMNS[0]) > WORSE for record in records)
    shown = [
        person,
        f"{median(record.js_original for record in records):.4f}",
        *cells,
        f"{divergence(worst, COLUMNS[-1]):.4f} ({worst.scenario})",
        f"{harmed} of {len(records)}",
    ]
    return f"| {' | '.join(shown)} |"


def chart(of_person: dict[str, list[CurveRecord]], path: Path) -> None:
    """Draw what is left of the first divergence, by the number of scores: medians and middle halves of tastes."""
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for person, records in of_person.items():
        shares = [sorted(left(record, num) for record in records) for num in SCORES]
        (line,) = axes.plot(SCORES, [100.0 * median(each) for each in shares], marker="o", markersize=3, label=person)
        low, high = ([100.0 * each[len(each) * part // 4] for each in shares] for part in (1, 3))
        axes.fill_between(SCORES, low, high, color=line.get_color(), alpha=0.08, linewidth=0)
    axes.axhline(100.0 * TENTH, color="0.5", linewidth=0.8, linestyle=":")
    axes.set(xlabel="scores", ylabel="% of the first divergence left", ylim=(0.0, 105.0), xticks=SCORES)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


def page(of_person: dict[str, list[CurveRecord]]) -> str:
    """The text of the page."""
    names = ",".join(sorted({record.scenario for records in of_person.values() for record in records}))
    header = ["person", "original", *(f"after {num}" for num in COLUMNS), f"worst after {COLUMNS[-1]}", "harmed"]
    return "\n".join(
        [
            "# How many scores do I need?",
            "",
            "![What is left of the first divergence, by the number of scores](../images/persons.png)",
            "",
            *[sentence(person, records) for person, records in of_person.items()],
            EXPLAINED,
            f"| {' | '.join(header)} |",
            f"|{'---|' * len(header)}",
            *[row(person, records) for person, records in of_person.items()],
            "",
            "```console",
            f"$ grammarlab evaluate {names} \\",
            f"    --person {','.join(of_person)} --seeds 1 --max-labels {COLUMNS[-1]} -o out/persons",
            "$ python -m docs.gen.persons out/persons",
            "```",
            "",
        ]
    )


def main(folder: Path) -> None:
    """Write the page and its chart."""
    records = list(curves_in(folder).all().values())
    of_person = {person: [record for record in records if record.person == person] for person in PERSONS}
    common = set.intersection(*({record.scenario for record in each} for each in of_person.values()))
    chosen = {person: [record for record in each if record.scenario in common] for person, each in of_person.items()}
    chart(chosen, CHART)
    PAGE.write_text(page(chosen))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
