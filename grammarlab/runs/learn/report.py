"""Page about a learned density: how far it is from a preference, its cost, and samples before and after."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from PIL import Image

from grammarlab.density.targets.rejection import RejectionSampler
from grammarlab.files import atomic_file, write_text
from grammarlab.learning.targets.divergence import Measured
from grammarlab.learning.targets.writers import Learned
from grammarlab.runs.sample.contact_sheet import PAPER, draw_page, draw_tiles, lay_out
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.runs.work.run_folder import only_run_in
from grammarlab.scene import Scene, triangles
from grammarlab.tables import markdown_table

WIDTH = 900
"""Approximate width of the samples of one density in pixels."""
SIDES = (4, 10)
"""Models along each side of the grids."""
_PAGE = "report.md"
_MARGIN = 12
"""Distance between the samples in pixels."""


class Sampled(Protocol):
    """A density that can be drawn."""

    def scene(self, num: int, seed: int, /) -> Scene:
        """Samples, as meshes."""
        ...


@dataclass(frozen=True, slots=True)
class Choice:
    """A choice that matters, as one model without it and the same with it."""

    text: str
    """The choice in words."""
    without: float
    """Mean predicted score of models without it, 0 to 100."""
    having: float
    """Mean predicted score of models with it, 0 to 100."""
    scene: Scene
    """The two models."""


@dataclass(frozen=True, slots=True)
class Report:
    """Content of a page."""

    title: str
    origin: str
    """A sentence about the source."""
    compared: tuple[tuple[str, str, str], ...]
    """Rows: the quantity, its value for the original grammar, and for the learned density."""
    facts: tuple[tuple[str, str], ...]
    """Rows: a quantity and its value."""
    sections: tuple[tuple[str, str], ...]
    """Heading and Markdown of the part below the pictures."""
    findings: tuple[str, ...]
    before: Sampled
    after: Sampled
    choices: Callable[[], tuple[Choice, ...]] = tuple
    """Choices that matter, each as two models that differ in it alone; derived when the page is written."""
    words: tuple[str, ...] = ()
    """What was learned, in sentences."""


def write_report(report: Report, folder: Path, *, seed: int, executor: AbstractExecutor) -> Path:
    """Write ``report.md`` and its pictures: ``before-after-4x4.png`` and so on, ``choice-1.png`` and so on.

    Args:
        report: the content.
        folder: made if missing.
        seed: seed of the models on the pictures.
        executor: draws the pictures, which do not depend on it.

    Returns:
        The page.

    Raises:
        UsageError: If another run is writing into the folder.
    """
    densities = [("before", report.before), ("after", report.after)]
    page = folder / _PAGE
    with only_run_in(folder):
        for side in SIDES:
            draw_side_by_side(densities, folder / _picture_name(side), side=side, seed=seed, executor=executor)
        choices = report.choices()
        for number, choice in enumerate(choices, 1):
            _draw_choice(choice, folder / _choice_name(number), executor)
        write_text(page, report_text(report, choices))
    return page


def draw_side_by_side(
    densities: Sequence[tuple[str, Sampled]], file: Path, *, side: int, seed: int, executor: AbstractExecutor
) -> None:
    """Draw samples of densities side by side; each model fills its picture.

    Args:
        densities: headings and densities.
        file: the picture.
        side: number of models along each side of a grid.
        seed: seed of the models.
        executor: draws the picture, which does not depend on it.
    """
    number = side * side
    batches = [triangles(sampler.scene(number, seed)) for _, sampler in densities]
    models = [batch.model(index) for batch in batches for index in range(number)]
    tiles = draw_tiles(models, (WIDTH // side) ** 2, executor)
    layout = lay_out(number, side, tiles.width, tiles.height)
    pages = []
    for column, (name, _) in enumerate(densities):
        pictures = tiles.pictures[column * number :][:number]
        pages.append(draw_page(layout, pictures, [("", "")] * number, (name, f"{number} samples")))
    gap = np.full((pages[0].shape[0], _MARGIN, 3), PAPER, np.uint8)
    joined = [part for page in pages for part in (page, gap)][:-1]
    with atomic_file(file) as part:
        Image.fromarray(np.concatenate(joined, axis=1)).save(part, format="PNG")


def _draw_choice(choice: Choice, file: Path, executor: AbstractExecutor) -> None:
    """Draw a model without and with a choice, side by side and to one scale."""
    batch = triangles(choice.scene)
    tiles = draw_tiles([batch.model(index) for index in range(2)], (WIDTH // 2) ** 2, executor, same_scale=True)
    captions = [(f"without: {choice.without:.0f}", ""), (f"with: {choice.having:.0f}", "")]
    page = draw_page(lay_out(2, 2, tiles.width, tiles.height), tiles.pictures, captions, (choice.text, ""))
    with atomic_file(file) as part:
        Image.fromarray(page).save(part, format="PNG")


def report_text(report: Report, choices: Sequence[Choice] = ()) -> str:
    """The page as Markdown."""
    pictures = [
        f"![{side * side} samples before and {side * side} after, drawn at random]({_picture_name(side)})\n"
        for side in SIDES
    ]
    parts = [
        f"# {report.title}\n",
        *(f"{sentence}\n" for sentence in report.words),
        f"{report.origin} Distances are from 0 % (the same models, as often) to 100 % (no model in common).\n",
        markdown_table(("", "before", "after"), report.compared),
        markdown_table(("", ""), report.facts),
        *pictures,
        *(f"## {heading}\n\n{text.rstrip()}\n" for heading, text in report.sections),
        *_choice_lines(choices),
        *(f"Note: {finding}.\n" for finding in report.findings),
    ]
    return "\n".join(parts)


def _choice_lines(choices: Sequence[Choice]) -> list[str]:
    if not choices:
        return []
    head = (
        "## Choices that matter\n\nOne model without and with each; numbers are mean predictions for all such models.\n"
    )
    return [head, *(f"![{choice.text}]({_choice_name(number)})\n" for number, choice in enumerate(choices, 1))]


def compared_rows(target: str, measured: Measured) -> tuple[tuple[str, str, str], ...]:
    """Rows comparing two densities with a target density.

    Args:
        target: name of the target density.
        measured: the comparison.
    """
    before, after = measured.before, measured.after
    return (
        (f"distance from {target}", distance(before.js), distance(after.js)),
        (f"correlation with {target}", f"{before.correlation:.3f}", f"{after.correlation:.3f}"),
    )


def distance(js: float) -> str:
    """A Jensen-Shannon divergence in nats as a share of the largest one, that of densities without a common model."""
    return _percent(js / math.log(2.0))


def cost_facts(learned: Learned[Any], measured: Measured) -> tuple[tuple[str, str], ...]:
    """Rows about how rare what is liked is, and what rejection makes of it."""
    effective = (f"effective models of the {measured.num_models:,} looked at", f"{measured.effective_models:,.0f}")
    if not isinstance(learned, RejectionSampler):
        return (effective, ("models that rejection would accept", _percent(measured.acceptance)))
    pilot = learned.pilot
    return (
        effective,
        ("models accepted", f"{_percent(pilot.rate)} of {pilot.proposals:,}"),
        ("bound", f"{pilot.bound:.4g}, " + ("known" if pilot.has_bound else "the largest one met")),
        ("share above the bound, cut off", _percent(pilot.truncated)),
    )


def _choice_name(number: int) -> str:
    """The file of a choice."""
    return f"choice-{number}.png"


def _picture_name(side: int) -> str:
    """The file of a grid."""
    return f"before-after-{side}x{side}.png"


def _percent(share: float) -> str:
    """A share with two significant digits."""
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.1f} %"
