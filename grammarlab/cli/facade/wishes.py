"""Constraints on the labels of a new facade, from options."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import get_args

from grammarlab.errors import UsageError
from grammarlab.facade.examples.wishes import Count, Fixed, Only, Rows, Wishes


def wishes_of(
    counts: Sequence[str],
    only: Sequence[str],
    fixed: Sequence[str],
    *,
    equal_corners: bool,
    symmetric: bool,
    keep: bool,
) -> Wishes:
    """Constraints from the values of options.

    Args:
        counts: such as `door=1` or `shop=2:5`.
        only: such as `shop=ground`.
        fixed: such as `door=0,3`: row and column, from 0, at the bottom and at the left.
        equal_corners: as in `Wishes`.
        symmetric: as in `Wishes`.
        keep: as in `Wishes`.

    Raises:
        UsageError: If a value has another form.
    """
    return Wishes(
        counts=tuple(_count(each) for each in counts),
        only=tuple(_only(each) for each in only),
        fixed=tuple(_fixed(each) for each in fixed),
        equal_corners=equal_corners,
        symmetric=symmetric,
        keep=keep,
    )


def _count(text: str) -> Count:
    label, value = _parts(text, "--count", r"\d{1,6}(:\d{1,6})?", "door=1, or shop=2:5 for 2 to 5 of them")
    least, _, most = value.partition(":")
    return Count(label, int(least), int(most or least))


def _only(text: str) -> Only:
    label, value = _parts(text, "--only", "|".join(get_args(Rows)), "shop=ground, shop=top or shop=between")
    return Only(label, next(each for each in get_args(Rows) if each == value))


def _fixed(text: str) -> Fixed:
    label, value = _parts(text, "--fix", r"\d{1,6},\d{1,6}", "door=0,3: row and column, from 0 at the lower left")
    row, column = value.split(",")
    return Fixed(int(row), int(column), label)


def _parts(text: str, option: str, pattern: str, example: str) -> tuple[str, str]:
    """The label before the last equals sign, and the value after it."""
    label, _, value = text.rpartition("=")
    if not label.strip() or not re.fullmatch(pattern, value.strip(), re.ASCII):
        raise UsageError(f"{option}: expected {example}; found {text!r:.80}.")
    return label.strip(), value.strip()
