"""Layouts of a design: from patterns to words, alignments and sizes, the best first."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from grammarlab.errors import FacadeError
from grammarlab.layers.candidates import FittingWords, NothingFitsError
from grammarlab.layers.conflicts import contradiction, in_words
from grammarlab.layers.design import Design
from grammarlab.layers.shared_wildcards import shared_wildcards, told_apart
from grammarlab.layers.solving import Layout, StepsSpentError, solve

MOST_COUNT = 100
"""Largest number of layouts of one search."""
_EFFORTS = (20_000, 100_000)
"""Steps of a test whether a part of a design has a layout: more if the first find no contradiction."""
_TIME_LIMIT_S = 3.0
"""Time limit for finding a contradiction, seconds; after that, the message may name more than is needed."""
_MOST_NAMED = 12
"""Largest number of statements in a message."""


def _never() -> bool:
    return False


def layouts(
    design: Design, width: float, height: float, count: int = 1, *, stop: Callable[[], bool] = _never
) -> list[Layout]:
    """The best different layouts of a design on a canvas.

    Args:
        design: the design.
        width: width of the canvas, metres.
        height: height of the canvas, metres.
        count: largest number of layouts, at most `MOST_COUNT`.
        stop: function that ends the search as soon as it returns true, see `solve`.

    Raises:
        FacadeError: If there is none; the message names statements that contradict each other.
    """
    try:
        solutions = _solved(design, width, height, count, stop)
    except NothingFitsError as error:
        raise FacadeError(f"{str(error).rstrip('.')}.{_contradiction_text(design, width, height)}") from error
    except StepsSpentError as error:
        raise FacadeError(f"{error}{_shared_text(design, width, height, spent=True)}") from error
    if not solutions and not stop():
        text = f"these layers do not fit each other on {width:g} x {height:g} m."
        reason = _shared_text(design, width, height) or _contradiction_text(design, width, height)
        raise FacadeError(f"{text}{reason}")
    return solutions


def _solved(
    design: Design, width: float, height: float, count: int, stop: Callable[[], bool] = _never, effort: int = 500_000
) -> list[Layout]:
    fits = FittingWords(design, width, height)
    return solve(
        fits, (width, height), design.weights, count,
        tolerances=fits.tolerances(count=count), gaps=design.overhang,
        others=fits.least_of_others, effort=effort, stop=stop,
    )  # fmt: skip


def may_fit(design: Design, stop: Callable[[], bool] = _never, effort: int = _EFFORTS[0]) -> bool:
    """Whether a design has a layout on its canvas; true if the test runs out of steps."""
    if stop():
        return True
    try:
        return bool(_solved(design, design.width, design.height, 1, stop, effort=effort)) or stop()
    except NothingFitsError:
        return False
    except FacadeError:  # too many words, or too many steps
        return True


def _shared_text(design: Design, width: float, height: float, *, spent: bool = False) -> str:
    """Which shared symbol without a size is, or if the search was not complete may be, the reason for no layout."""
    design = replace(design, width=width, height=height)
    shared = shared_wildcards(design)
    for some in (*((each,) for each in shared), *([shared] if len(shared) > 1 else [])):
        if _has_layout(told_apart(design, some)):
            return " ".join(("", *(each.as_reason() for each in some)))
    return " ".join(("", *(each.as_hint() for each in shared))) if spent else ""


def _has_layout(design: Design) -> bool:
    """Whether a layout of a design is found within few steps."""
    try:
        return bool(_solved(design, design.width, design.height, 1, effort=_EFFORTS[-1]))
    except FacadeError:
        return False


def _contradiction_text(design: Design, width: float, height: float) -> str:
    """The statements that contradict each other, if found in time."""
    design = replace(design, width=width, height=height)
    end = time.monotonic() + _TIME_LIMIT_S

    def late() -> bool:
        return time.monotonic() > end

    trials = (contradiction(design, partial(may_fit, stop=late, effort=effort)) for effort in _EFFORTS)
    conflict = next((conflict for conflict in trials if conflict), ())
    if not conflict or len(conflict) > _MOST_NAMED:
        return ""
    hint = "though some may be irrelevant" if late() else "but they can if any one is dropped"
    return f" These statements cannot all hold, {hint}: {in_words(design, conflict)}."
