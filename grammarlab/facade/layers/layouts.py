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
        FacadeError: when there is none: which patterns contradict each other.
    """
    fits = Fits(design, width, height)
    tolerances = fits.tolerances(enough=count)
    found = solve(fits, (width, height), design.weights, count, tolerances=tolerances, gaps=design.overhang)
    if not found:
        raise FacadeError(
            f"no alignment of these layers on {width:g} x {height:g} m: {_flags(design)}. Switch layers off, or put "
            "their patterns into alignment groups of their own, to see which contradict each other."
        )
    return found


def _flags(design: Design) -> str:
    """What forbids alignments, in words."""
    used = {
        name for layer in design.visible_layers for key in layer.patterns for name in design.patterns[key].symbols()
    }
    flags = {
        "not opaque": [name for name in used if not design.symbols[name].opaque],
        "unoccludable": [name for name in used if design.symbols[name].unoccludable],
        "attached": [name for name in used if design.symbols[name].attached],
    }
    told = [
        f"{', '.join(sorted(names))} {'is' if len(names) == 1 else 'are'} {flag}"
        for flag, names in flags.items()
        if names
    ]
    return "; ".join(told) or "their words have no columns in common"
