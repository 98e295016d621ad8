"""Wishes that contradict each other: a minimal contradiction, and the closest sizes.

Symmetry is relaxed first, then alignment, then wishes; the decomposition always holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import linprog

from grammarlab.errors import FacadeError
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH, SizeModel
from grammarlab.facade.sizes.wishes import Wish, in_words
from grammarlab.facade.tree import Facade, Floats, X

_CONTRADICTION = 1e-7
"""Least violation, as a fraction of the facade's size, that counts as a contradiction."""
_TIGHTEST = 1e-10
"""Tolerance of the linear programmes."""

Tie = tuple[int, int, int]
"""A group of rows that is relaxed as a whole: kind of row, axis, and index of the grid or wish."""


@dataclass(frozen=True, slots=True)
class Compromise:
    """Positions of lines that are closest to the wishes."""

    place: Floats
    """[V] positions."""
    conflict: tuple[str, ...]
    """Wishes, then grids, of a minimal contradiction: without any one of them, the others can hold."""
    relaxed: tuple[str, ...]
    """Relaxed wishes and grids, with the largest violation in metres."""


def compromise(model: SizeModel, value: Floats, facade: Facade, wishes: Sequence[Wish]) -> Compromise:
    """The positions with the least violations of wishes, then of alignment, then of symmetry, each summed over rows.

    Args:
        model: the programme.
        value: [R] values of its rows.
        facade: facade with the names for messages.
        wishes: wishes of the rows.
    """
    ties = _ties(model)
    place, _ = _least_slack(
        model, value, ties, [[tie for tie in ties if tie[0] == kind] for kind in (WISH, ALIGNMENT, SYMMETRY)]
    )
    rows, bounds = model.program.rows.at(place), model.program.bounds.at(place)
    gave, short = np.abs(rows - value), model.program.least - bounds
    relaxed = []
    for tie in ties:
        row, bound = _members(model, [tie])
        most = max(gave[row].max(initial=0.0), short[bound].max(initial=0.0))
        if most > _CONTRADICTION:
            relaxed.append(f"{_in_words(tie, facade, wishes)}: missed by {most * model.scale:.3g} m")
    least = np.where(model.bound_source >= 0, np.minimum(model.program.least, bounds), model.program.least)
    held = np.where(gave > _CONTRADICTION, rows, value)
    solved = replace(model.program, least=least, still=np.zeros(len(held), dtype=bool)).solve(held)
    causes = sorted(_irreducible(model, value, ties), key=lambda tie: -tie[0]) if relaxed else []
    conflict = tuple(_in_words(tie, facade, wishes) for tie in causes)
    return Compromise(place if solved is None else solved, conflict, tuple(relaxed))


def _ties(model: SizeModel) -> list[Tie]:
    """All groups that can be relaxed, in the order of relaxation."""
    rows = np.unique(np.stack([model.kind, model.along, model.source], axis=1), axis=0)
    aspects = np.unique(model.bound_source[model.bound_source >= 0])
    return [(int(kind), int(along), int(source)) for kind, along, source in rows] + [
        (WISH, X, int(at)) for at in aspects
    ]


def _members(model: SizeModel, ties: Sequence[Tie]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """[R] whether each row is in one of these groups, and [K] whether each bound is."""
    row, bound = np.zeros(len(model.kind), dtype=bool), np.zeros(len(model.bound_source), dtype=bool)
    for kind, along, source in ties:
        row |= (model.kind == kind) & (model.along == along) & (model.source == source)
        bound |= (kind == WISH) & (model.bound_source == source)
    return row, bound


def _irreducible(model: SizeModel, value: Floats, ties: list[Tie]) -> list[Tie]:
    """A minimal set of contradicting groups, found by dropping one after the other."""
    kinds = [[tie for tie in ties if tie[0] == kind] for kind in (SYMMETRY, ALIGNMENT)]
    kept = ties
    for out in [*kinds, *([tie] for tie in ties)]:
        without = [tie for tie in kept if tie not in out]
        if len(without) < len(kept) and _least_slack(model, value, without, [without])[1] > _CONTRADICTION:
            kept = without
    return kept


def _least_slack(
    model: SizeModel, value: Floats, ties: Sequence[Tie], stages: Sequence[Sequence[Tie]]
) -> tuple[Floats, float]:
    """[V] positions with the least violation of all bounds of leaves and of these groups, and the total violation.

    Args:
        model: the programme.
        value: [R] values of its rows.
        ties: groups to include; others are left out.
        stages: groups to satisfy first, second, and so on.
    """
    kept, soft = _members(model, ties)
    hard = soft | (model.bound_source < 0)
    num_places, num_rows = model.program.num_lines, int(kept.sum())
    rows = model.program.rows.matrix(num_places)[kept]
    bounds = model.program.bounds.matrix(num_places)[hard]
    short = sparse.csr_array(np.eye(len(soft))[hard][:, soft])
    eye = sparse.eye_array(num_rows)
    equal = sparse.hstack([rows, -eye, eye, sparse.csr_array((num_rows, int(soft.sum())))], format="csc")
    below = -sparse.hstack(
        [bounds, sparse.csr_array((len(model.program.least[hard]), 2 * num_rows)), short], format="csr"
    )
    most = -model.program.least[hard]
    limits = np.tile([0.0, np.inf], (num_places + 2 * num_rows + int(soft.sum()), 1))
    limits[:num_places, 0] = -np.inf
    options = {"primal_feasibility_tolerance": _TIGHTEST, "dual_feasibility_tolerance": _TIGHTEST}
    place, missed = np.zeros(num_places), 0.0
    for stage in stages:
        row, bound = _members(model, stage)
        cost = np.concatenate([np.zeros(num_places), row[kept], row[kept], bound[soft]])
        found = linprog(cost, below, most, equal, value[kept], limits, options=options)
        if found.x is None:
            raise FacadeError("No sizes were found for these wishes: try other or fewer wishes.")
        place, missed = found.x[:num_places], missed + float(found.fun)
        below = sparse.vstack([below, sparse.csr_array(cost[None])], format="csr")
        most = np.append(most, found.fun + _TIGHTEST)
    return place, missed


def _in_words(tie: Tie, facade: Facade, wishes: Sequence[Wish]) -> str:
    kind, along, source = tie
    if kind == WISH:
        return in_words(wishes[source], facade)
    name = facade.grids[source].name
    if kind == SYMMETRY:
        return f"what is alike in grid '{name}' keeps its {'widths' if along == X else 'heights'} alike"
    return f"the {'columns' if along == X else 'rows'} of grid '{name}' stay aligned"
