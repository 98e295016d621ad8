"""Layouts of a design: from patterns to words, alignments and sizes, the best first."""

from __future__ import annotations

from grammarlab.errors import FacadeError
from grammarlab.facade.layers.candidates import Fits
from grammarlab.facade.layers.designs.design import Design
from grammarlab.facade.layers.solving import Layout, solve

MOST_COUNT = 100


def layouts(design: Design, width: float, height: float, count: int = 1) -> list[Layout]:
    """The best different layouts of a design on a canvas.

    Args:
        design: the design.
        width: metres.
        height: metres.
        count: how many at most, up to `MOST_COUNT`.

    Raises:
        FacadeError: when there is none, and which patterns contradict each other.
    """
    fits = Fits(design, width, height)
    tolerances = fits.tolerances(enough=count)
    found = solve(fits, (width, height), design.weights, count, tolerances=tolerances, gaps=design.overhang)
    if not found:
        raise FacadeError(f"these layers do not fit each other on {width:g} x {height:g} m: {_reasons(design)}")
    return found


def _reasons(design: Design) -> str:
    """What may forbid all alignments and sizes, and what to try."""
    layers = design.visible_layers
    used: dict[str, set[tuple[int, str]]] = {}
    for layer in layers:
        for axis, name in enumerate(layer.patterns):
            for symbol in design.patterns[name].symbols():
                used.setdefault(symbol, set()).add((axis, name))
    flagged = [
        ("is not opaque", [name for name in used if not design.symbols[name].opaque]),
        ("is transparent", [name for name in used if design.symbols[name].transparent]),
        ("is unoccludable", [name for name in used if design.symbols[name].unoccludable]),
        ("is attached", [name for name in used if design.symbols[name].attached]),
        (
            "has one size wherever it is left open",
            [name for name, where in used.items() if len(where) > 1 and design.symbols[name].size is None],
        ),
    ]
    told = [f"{', '.join(names)} {flag}" for flag, names in flagged if names]
    return (
        f"{'; '.join(told) or 'no columns have a solid element each'}. Switch layers off, or put them into alignment "
        "groups of their own, to see which contradict each other."
    )
