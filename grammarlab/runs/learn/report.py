"""A page about a grammar that was learned from labels: how near, from what, and pictures before and after."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from grammarlab.derivation.derive import derive
from grammarlab.language.grammar import Grammar
from grammarlab.runs.atomic import atomic_file, write_text
from grammarlab.runs.learn.labels import LabelsResult
from grammarlab.runs.sheet_page import PAPER, draw_page, lay_out
from grammarlab.runs.tiles import draw_tiles
from grammarlab.scene import realize, triangles

SIDE = 4
"""Models along each side of a grid."""
TILE_AREA = 200 * 200
"""Pixels of the picture of one model."""
PICTURE = "before-after.png"
PAGE = "report.md"
_MARGIN = 12


def write_report(result: LabelsResult, folder: Path, *, seed: int, jobs: int) -> Path:
    """Writes ``report.md`` and its picture.

    Args:
        result: what was learned.
        folder: made when missing.
        seed: of the models on the picture.
        jobs: processes; the picture does not depend on it.

    Returns:
        The page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    assets = result.source.assets
    shown = [("before", result.learned.original, assets), ("after", result.learned.grammar, assets)]
    draw_side_by_side(shown, folder / PICTURE, seed=seed, jobs=jobs)
    page = folder / PAGE
    write_text(page, report_text(result))
    return page


def report_text(result: LabelsResult) -> str:
    """The page as Markdown."""
    learned = result.learned
    rows = [
        ("labels", f"{result.num_labels}"),
        ("divergence from what was learned, before", _nats(result.js_before)),
        ("divergence from what was learned, after", _nats(result.js)),
    ]
    if result.truth is not None:
        rows += [
            (f"divergence from scenario {result.truth.scenario}, before", _nats(result.truth.before.js)),
            (f"divergence from scenario {result.truth.scenario}, after", _nats(result.truth.after.js)),
        ]
    rows += [
        ("rules before", f"{learned.rules_before}"),
        ("rules after", f"{learned.rules_after}"),
        ("effective models of the 5,000 looked at", f"{result.effective_models:.0f}"),
        ("method", f"{learned.method}, base {learned.base}"),
        ("seconds", f"{result.seconds:.1f}"),
    ]
    origin = (
        f"Learned by `grammarlab learn` from {result.source.name}.cga and {result.labels.name}. Divergences are "
        "Jensen-Shannon divergences in nats, 0 to 0.693.\n"
    )
    parts = [
        f"# {result.file.name}\n",
        origin,
        _table(("", ""), rows),
        f"![Samples before and after, drawn at random]({PICTURE})\n",
        "## Steps\n",
        _table(("step", "moves the density by"), [(step.name, _nats(step.js)) for step in result.steps]),
        "## Factors\n",
        _table(
            ("factor", "labels", "score levels", "relevant features"),
            [
                (
                    factor.name,
                    f"{factor.num_labels}",
                    ", ".join(f"{level:g}" for level in factor.simplified.levels) or "continuous",
                    f"{len(factor.simplified.columns)}",
                )
                for factor in result.factors
            ],
        ),
        "## What the grammar looks at\n",
        "\n".join(
            f"- {name} (`{feature}`)" for name, feature in zip(result.feature_names, result.features, strict=True)
        )
        or "Nothing: all models are liked alike.",
        "\n## What the scores depend on\n",
        "\n".join(f"- {entry}" for entry in result.relevances) or "Nothing.",
        *(f"\nNote: {finding}." for finding in learned.findings),
    ]
    return "\n".join(parts) + "\n"


def draw_side_by_side(shown: Sequence[tuple[str, Grammar, Path]], file: Path, *, seed: int, jobs: int) -> None:
    """Draws samples of some grammars beside each other, each model filling its picture.

    Args:
        shown: for each grammar what to write above its samples, itself, and the folder of its meshes and images.
        file: the picture.
        seed: of the models.
        jobs: processes; the picture does not depend on it.
    """
    batches = [triangles(realize(derive(grammar, SIDE * SIDE, seed, assets=assets))) for _, grammar, assets in shown]
    models = [batch.model(index) for batch in batches for index in range(SIDE * SIDE)]
    tiles = draw_tiles(models, TILE_AREA, jobs)
    layout = lay_out(SIDE * SIDE, SIDE, tiles.width, tiles.height)
    pages = []
    for number, (name, _, _) in enumerate(shown):
        own = tiles.pictures[number * SIDE * SIDE :][: SIDE * SIDE]
        pages.append(draw_page(layout, own, [("", "")] * len(own), (name, f"{SIDE * SIDE} samples")))
    gap = np.full((pages[0].shape[0], _MARGIN, 3), PAPER, np.uint8)
    joined = [part for page in pages for part in (page, gap)][:-1]
    with atomic_file(file) as part:
        Image.fromarray(np.concatenate(joined, axis=1)).save(part, format="PNG")


def _nats(value: float) -> str:
    return f"{value:.4f}" if value >= 1e-3 else f"{value:.2g}"


def _table(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [header, ("---",) * len(header), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)
