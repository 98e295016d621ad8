"""Layouts adapted to a dragged canvas: alignments are kept, only sizes are solved for."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

from grammarlab.facade.layers.designs.design import Design
from grammarlab.facade.layers.showing.flattening import flattened
from grammarlab.facade.layers.showing.panels import panels_of
from grammarlab.facade.layers.sizing.sizes import size_letters
from grammarlab.facade.layers.solving import Layout
from grammarlab.facade.layers.words import STRETCH
from grammarlab.runs.facade.layers import SolvedLayout

Key = tuple[object, ...]
"""Key of a layout, independent of the canvas."""


def key_of(layout: Layout) -> Key:
    """A key that is equal for layouts of a design that differ only in sizes."""
    return tuple((group, each.words, each.cells) for group, each in layout.alignments.items())


def followed(design: Design, known: Sequence[Layout], width: float, height: float) -> list[Layout]:
    """Known layouts on another canvas, those of least energy first; without those with too much stretching.

    Better layouts are possible, so none is proven.

    Args:
        design: the design of the layouts.
        known: layouts for canvases of any size.
        width: metres.
        height: metres.
    """
    found = []
    for layout in known:
        alignments = [(each, (width, height)[axis]) for (axis, _), each in layout.alignments.items()]
        sizing = size_letters(alignments, gaps=design.overhang)
        if sizing is None or not _close(design, sizing.sizes):
            continue
        paid = sum(each.energy for each, _ in alignments)
        energy = paid + design.weights.sizing * sizing.error
        found.append(replace(layout, sizing=sizing, energy=energy, bound=0.0, proven=False))
    return sorted(found, key=lambda layout: layout.energy)


def shown(design: Design, layout: Layout, width: float, height: float) -> SolvedLayout:
    """A layout with its panels on its canvas."""
    start = time.perf_counter()
    panels = panels_of(design, layout, width, height)
    return SolvedLayout(design, layout, panels, flattened(panels), time.perf_counter() - start)


def _close(design: Design, sizes: Mapping[str, float]) -> bool:
    """Whether no symbol is more than `STRETCH` times larger or smaller than its preferred size."""
    wished = {name: design.symbols[name].size for name in sizes}
    return all(size is None or size / STRETCH <= sizes[name] <= size * STRETCH for name, size in wished.items())
