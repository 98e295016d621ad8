"""Numbers of occurrences of labels, and whether there is room for them."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.label_grid import LabelGrid
from grammarlab.facade.examples.wishes import Count

Domain = NDArray[np.bool_]
LabelCount = tuple[int, int, int]
"""Label, least and largest count."""
_MOST_PLACED = 400
"""Largest number of units that are placed before the search; more are left to it."""


def forced_cells(domain: Domain, label: int) -> NDArray[np.bool_]:
    """[rows, columns] whether a label is the only one of a cell."""
    return domain[:, :, label] & (domain.sum(axis=2) == 1)


def label_count(domain: Domain, example: LabelGrid, count: Count, symmetric: bool) -> LabelCount:
    """The count of a label, checked on its own.

    Args:
        domain: [rows, columns, labels] whether each cell may have each label.
        example: an example with the numbering of labels.
        count: name of the label, and its limits.
        symmetric: whether every row is a palindrome.

    Raises:
        FacadeError: If the label is unknown, or no grid can have so many or so few of it.
    """
    label = example.label(count.label)
    text = f"{count.label} {count.least} to {count.most} times"
    if count.least < 0 or count.most < count.least:
        raise FacadeError(f"wishes: {text}; expected counts of at least 0, the first at most the second.")
    able = int(domain[:, :, label].sum())
    if able < count.least:
        raise FacadeError(f"wishes: {text}, but only {able} cells may be {count.label}.")
    forced = int(forced_cells(domain, label).sum())
    if forced > count.most:
        raise FacadeError(f"wishes: {text}, but {forced} cells can only be {count.label}.")
    columns = domain.shape[1]
    odd = columns % 2 == 1 and domain[:, columns // 2, label].any()
    if symmetric and count.least == count.most and count.least % 2 == 1 and not odd:
        raise FacadeError(f"wishes: symmetric and {text} contradict each other: an odd number needs a middle column.")
    return label, count.least, count.most


def make_way(domain: Domain, wide: Domain, label: int, most: int, fixed: Collection[tuple[int, int]]) -> None:
    """Cells whose only label has a largest count below their number get those of a wider domain."""
    forced = forced_cells(domain, label)
    if int(forced.sum()) > max(0, most):
        for row, column in np.argwhere(forced).tolist():
            if (row, column) not in fixed:
                domain[row, column] = wide[row, column]


def check_room(domain: Domain, names: tuple[str, ...], counts: Sequence[LabelCount]) -> None:
    """Checks that all counts fit together, not only one by one.

    Raises:
        FacadeError: If they do not.
    """
    required = np.array([label for label, least, _ in counts for _ in range(least)], dtype=np.int64)
    if not 0 < len(required) <= _MOST_PLACED:
        return
    refused = ~domain.reshape(-1, domain.shape[2]).T[required]  # [required, cells]
    if len(required) > refused.shape[1] or refused[linear_sum_assignment(refused)].any():
        text = ", ".join(f"{names[label]} at least {least} times" for label, least, _ in counts if least)
        raise FacadeError(f"wishes: {text}: there is not enough room for all of these together.")
