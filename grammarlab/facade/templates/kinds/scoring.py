"""Agreement of kinds with the ground truth."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from grammarlab.facade.templates.elements import Ints, Truth
from grammarlab.facade.templates.kinds.match import SURE, UNKNOWN, Match


def agreeing(match: Match, truth: Truth) -> tuple[np.ndarray, Ints]:
    """[N] whether the kind of each element is correct, and [N] its kind; unknown elements have a kind of their own."""
    found = np.where(match.kind == UNKNOWN, match.kind.max() + 1, match.kind)
    table = np.zeros((found.max() + 1, truth.kind.max() + 1))
    np.add.at(table, (found, truth.kind), 1.0)
    table[match.kind.max() + 1 :] = 0.0
    rows, columns = linear_sum_assignment(-table)
    partner = np.full(len(table), -1)
    partner[rows] = columns
    right = (partner[found] == truth.kind) & (match.kind != UNKNOWN)
    return right, found


def compare(match: Match, truth: Truth) -> dict[str, Any]:
    """Adjusted mutual information, number of mislabelled elements, and correct ones among the sure results.

    Kinds of match and truth are paired so that most elements agree; elements of other pairs are mislabelled.
    """
    from sklearn.metrics import adjusted_mutual_info_score  # noqa: PLC0415 scikit-learn takes a second to load

    right, found = agreeing(match, truth)
    sure = (match.probability >= SURE) & (match.kind != UNKNOWN)
    return {
        "adjusted_mutual_information": float(adjusted_mutual_info_score(truth.kind, found)),
        "mislabelled": int((~right).sum()),
        "kinds": len(np.unique(truth.kind)),
        "kinds_found": len(match.values),
        "sure": int(sure.sum()),
        "sure_and_right": int((sure & right).sum()),
    }
