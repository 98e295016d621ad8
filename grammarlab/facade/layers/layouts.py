"""Layouts of a design: from patterns to words, alignments and sizes, the best first."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from grammarlab.errors import FacadeError
from grammarlab.facade.layers.candidates import FittingWords, NothingFitsError
from grammarlab.facade.layers.conflicts import contradiction, in_words
from grammarlab.facade.layers.designs.design import Design
from grammarlab.facade.layers.solving import Layout, solve

MOST_COUNT = 100
_EFFORT = 20_000
"""Steps of a test whether a part of a design has a layout."""
_SECONDS = 3.0
"""Time limit for finding a contradiction, seconds; after that, the message may name more than is needed."""
_MOST_TOLD = 12
"""Largest number of statements in a message."""


def _never() -> bool:
    return False


def layouts(
    design: Design, width: float, height: float, count: int = 1, *, stop: Callable[[], bool] = _never
) -> list[Layout]:
    """The best different layouts of a design on a canvas.

    Args:
        design: the design.
        width: metres.
        height: metres.
        count: largest number of layouts, up to `MOST_COUNT`.
        stop: see `solve`.

    Raises:
        FacadeError: If there is none; the message names statements that contradict each other.
    """
    try:
        found = _solved(design, width, height, count, stop)
    except NothingFitsError as error:
        raise FacadeError(f"{str(error).rstrip('.')}.{_told(design, width, height)}") from error
    if not found and not stop():
        text = f"these layers do not fit each other on {width:g} x {height:g} m"
        raise FacadeError(f"{text}.{_told(design, width, height)}")
    return found


def _solved(
    design: Design, width: float, height: float, count: int, stop: Callable[[], bool] = _never, effort: int = 500_000
) -> list[Layout]:
    fits = FittingWords(design, width, height)
    return solve(
        fits, (width, height), design.weights, count,
        tolerances=fits.tolerances(enough=count), gaps=design.overhang,
        others=fits.least_of_others, effort=effort, stop=stop,
    )  # fmt: skip


def may_fit(design: Design, stop: Callable[[], bool] = _never) -> bool:
    """Whether a design has a layout on its canvas; true if the test runs out of steps."""
    if stop():
        return True
    try:
        return bool(_solved(design, design.width, design.height, 1, stop, effort=_EFFORT)) or stop()
    except NothingFitsError:
        return False
    except FacadeError:  # too many words, or too many steps
        return True


def _told(design: Design, width: float, height: float) -> str:
    """The statements that contradict each other, if found in time."""
    design = replace(design, width=width, height=height)
    end = time.monotonic() + _SECONDS

    def late() -> bool:
        return time.monotonic() > end

    found = contradiction(design, partial(may_fit, stop=late))
    if not found or len(found) > _MOST_TOLD:
        return ""
    told = "though some of it may be irrelevant" if late() else "but it can if any one of these is dropped"
    return f" These cannot all hold, {told}: {in_words(design, found)}."
