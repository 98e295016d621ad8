"""Sizes of a facade under wishes: as close to the original ones as its structure allows (paper 000, section 5).

Wishes that contradict each other give the closest sizes and a minimal contradiction. Symmetry is relaxed first, then
alignment, then wishes; the decomposition always holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import linprog

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError
from grammarlab.facade.sizes.constraints import LineOrigin, Weights, build_axis, leaf_weights
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH, SizeModel, build_model
from grammarlab.facade.sizes.size_wishes import Aspect, Wish, checked, in_words
from grammarlab.facade.tree import Facade, X, Y, decomposition_misses

_Tie = tuple[int, int, int]
"""A group of rows that is relaxed as a whole: kind of row, axis, and index of the grid or wish."""
_CONTRADICTION = 1e-7
"""Least violation, as a fraction of the facade's size, that counts as a contradiction."""
_LP_TOLERANCE = 1e-10
"""Tolerance of the linear programmes."""
_UNMOVED_TOLERANCE = 1e-12
"""Largest violation, as a fraction of the facade's size, of sizes that are kept without a solution."""


@dataclass(frozen=True, slots=True)
class Compromise:
    """Positions of lines that are closest to the wishes."""

    position: Floats
    """[V] positions."""
    conflict: tuple[str, ...]
    """Wishes, then grids, of a minimal contradiction: without any one of them, the others can hold."""
    relaxed: tuple[str, ...]
    """Relaxed wishes and grids, with the largest violation in metres."""


@dataclass(frozen=True, slots=True)
class Residuals:
    """Violations of constraints, measured on the facade itself."""

    decomposition: float
    """Largest gap or overlap of parts, as a fraction of the facade's width or height."""
    alignment: float
    """Largest change of the distance between anchors of neighbours in a grid, or of lines that were one, metres."""
    symmetry: float
    """Largest deviation of a size from its ratio to that of a similar or an equal part, metres."""
    target: float
    """Largest violation of a wish, metres."""

    def as_dict(self) -> dict[str, float]:
        """Values for `--json`."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Resized:
    """A facade with solved sizes."""

    facade: Facade
    energy: tuple[float, float]
    """E of Equation 1 for widths and for heights: 0 without deviations."""
    residuals: Residuals
    conflict: tuple[str, ...]
    """Wishes and grids of a minimal contradiction; empty if all constraints hold."""
    relaxed: tuple[str, ...]
    """Relaxed wishes and grids, with the largest violation in metres; empty if all constraints hold."""


@dataclass(frozen=True, eq=False)
class Sizing:
    """A facade and kinds of wishes, prepared for solutions with any lengths, as during a drag."""

    facade: Facade
    wishes: tuple[Wish, ...]
    origin: LineOrigin
    weight: Floats
    """[L, 2] weights of leaves, per metre."""

    @cached_property
    def models(self) -> tuple[SizeModel, ...]:
        """A programme for each axis; one for both if a wish connects them."""
        scale = max(self.facade.width, self.facade.height)
        axes = [build_axis(self.facade, along, self.origin, self.weight[:, along], scale) for along in (X, Y)]
        tied = any(isinstance(wish, Aspect) for wish in self.wishes)
        groups = [axes] if tied else [axes[:1], axes[1:]]
        return tuple(build_model(group, self.wishes, scale) for group in groups)

    def resized(self, wishes: Sequence[Wish]) -> Resized:
        """The facade under wishes that differ from the prepared ones only in metres.

        Raises:
            FacadeError: If lengths are out of range, or the kinds of wishes differ.
        """
        wishes = checked(wishes, self.facade)
        if [_kind(wish) for wish in wishes] != [_kind(wish) for wish in self.wishes]:
            raise FacadeError("Expected the prepared wishes with other lengths, found other wishes.")
        position, size = self.facade.position.copy(), self.facade.size.copy()
        conflict: list[str] = []
        relaxed: list[str] = []
        for model in self.models:
            value = model.row_values(wishes)
            start = model.line_positions(self.facade)
            if max(model.program.max_violation(start, value), model.program.deviation(start)) <= _UNMOVED_TOLERANCE:
                continue
            line_position = model.program.solve(value)
            if line_position is None:
                closest = _compromise(model, value, self.facade, wishes)
                line_position = closest.position
                conflict += closest.conflict
                relaxed += closest.relaxed
            for axis, lines in zip(model.axes, model.lines(line_position), strict=True):
                position[:, axis.along], size[:, axis.along] = axis.lines.spans(lines)
        facade = replace(self.facade, position=position, size=size)
        return Resized(facade, self._energy(facade), self._residuals(facade, wishes), tuple(conflict), tuple(relaxed))

    def _energy(self, facade: Facade) -> tuple[float, float]:
        leaf = facade.leaves
        energy = np.square(self.weight * (facade.size[leaf] - self.origin.size[leaf])).sum(axis=0)
        return float(energy[X]), float(energy[Y])

    def _residuals(self, facade: Facade, wishes: Sequence[Wish]) -> Residuals:
        worst = np.zeros(3)
        for model in self.models:
            line_position = model.line_positions(facade)
            row_violation = np.abs(model.program.rows.evaluate(line_position) - model.row_values(wishes)) * model.scale
            bound_violation = (model.program.least - model.program.bounds.evaluate(line_position)) * model.scale
            bound_violation = bound_violation[model.bound_source >= 0]
            np.maximum.at(worst, model.kind, row_violation)
            np.maximum.at(worst, np.full(len(bound_violation), WISH), bound_violation)
        decomposition = float(decomposition_misses(facade)[0].max(initial=0.0))
        return Residuals(decomposition, float(worst[ALIGNMENT]), float(worst[SYMMETRY]), float(worst[WISH]))


def resize(
    facade: Facade, wishes: Sequence[Wish], targets: LineOrigin | None = None, weights: Weights = "default"
) -> Resized:
    """The facade under these wishes.

    Args:
        facade: a facade with its grids; alignments and equal sizes of these are preserved.
        wishes: fixed properties; other sizes follow.
        targets: target sizes of its nodes, if they differ from the current ones, as after insertions.
        weights: kind of weights: relative deviations, or those of the paper.

    Raises:
        FacadeError: If a wish does not apply to this facade.
    """
    return prepare(facade, wishes, targets, weights).resized(wishes)


def prepare(
    facade: Facade, wishes: Sequence[Wish], targets: LineOrigin | None = None, weights: Weights = "default"
) -> Sizing:
    """A facade prepared for several solutions, for wishes that differ only in metres.

    Args:
        facade: a facade with its grids.
        wishes: fixed properties.
        targets: target sizes of its nodes, if they differ from the current ones, as after insertions.
        weights: kind of weights: relative deviations, or those of the paper.

    Raises:
        FacadeError: If a wish does not apply to this facade.
    """
    origin = targets or LineOrigin(facade.position, facade.size, facade.size[0])
    if origin.size.shape != facade.size.shape or not (np.isfinite(origin.size).all() and (origin.size > 0.0).all()):
        raise FacadeError(f"Wanted sizes: expected {facade.size.shape} finite numbers above 0.")
    weight = leaf_weights(origin.size[facade.leaves], origin.whole, weights)
    return Sizing(facade, checked(wishes, facade), origin, weight)


def _kind(wish: Wish) -> Wish:
    """A wish without its metres; a range of aspect ratios is part of the kind."""
    return wish if isinstance(wish, Aspect) else replace(wish, metres=0.0)


def _compromise(model: SizeModel, value: Floats, facade: Facade, wishes: Sequence[Wish]) -> Compromise:
    """The positions with the least violations of wishes, then of alignment, then of symmetry, each summed over rows.

    Args:
        model: the programme.
        value: [R] values of its rows.
        facade: facade with the names for messages.
        wishes: wishes of the rows.
    """
    ties = _ties(model)
    position, _ = _least_slack(
        model, value, ties, [[tie for tie in ties if tie[0] == kind] for kind in (WISH, ALIGNMENT, SYMMETRY)]
    )
    rows, bounds = model.program.rows.evaluate(position), model.program.bounds.evaluate(position)
    row_violation, bound_violation = np.abs(rows - value), model.program.least - bounds
    relaxed = []
    for tie in ties:
        row, bound = _members(model, [tie])
        violation = max(row_violation[row].max(initial=0.0), bound_violation[bound].max(initial=0.0))
        if violation > _CONTRADICTION:
            relaxed.append(f"{_in_words(tie, facade, wishes)}: missed by {violation * model.scale:.3g} m")
    least = np.where(model.bound_source >= 0, np.minimum(model.program.least, bounds), model.program.least)
    attainable = np.where(row_violation > _CONTRADICTION, rows, value)
    solved = replace(model.program, least=least, is_zero=np.zeros(len(attainable), dtype=bool)).solve(attainable)
    causes = sorted(_irreducible(model, value, ties), key=lambda tie: -tie[0]) if relaxed else []
    conflict = tuple(_in_words(tie, facade, wishes) for tie in causes)
    return Compromise(position if solved is None else solved, conflict, tuple(relaxed))


def _ties(model: SizeModel) -> list[_Tie]:
    """All groups that can be relaxed, in the order of relaxation."""
    rows = np.unique(np.stack([model.kind, model.along, model.source], axis=1), axis=0)
    aspects = np.unique(model.bound_source[model.bound_source >= 0])
    return [(int(kind), int(along), int(source)) for kind, along, source in rows] + [
        (WISH, X, int(wish)) for wish in aspects
    ]


def _least_slack(
    model: SizeModel, value: Floats, ties: Sequence[_Tie], stages: Sequence[Sequence[_Tie]]
) -> tuple[Floats, float]:
    """[V] positions with the least violation of all bounds of leaves and of these groups, and the total violation.

    Args:
        model: the programme.
        value: [R] values of its rows.
        ties: groups to include; others are left out.
        stages: groups to satisfy first, second, and so on.
    """
    included, soft = _members(model, ties)
    hard = soft | (model.bound_source < 0)
    num_lines, num_rows = model.program.num_lines, int(included.sum())
    rows = model.program.rows.matrix(num_lines)[included]
    bounds = model.program.bounds.matrix(num_lines)[hard]
    bound_slack = sparse.csr_array(np.eye(len(soft))[hard][:, soft])
    eye = sparse.eye_array(num_rows)
    equality = sparse.hstack([rows, -eye, eye, sparse.csr_array((num_rows, int(soft.sum())))], format="csc")
    inequality = -sparse.hstack(
        [bounds, sparse.csr_array((len(model.program.least[hard]), 2 * num_rows)), bound_slack], format="csr"
    )
    upper = -model.program.least[hard]
    limits = np.tile([0.0, np.inf], (num_lines + 2 * num_rows + int(soft.sum()), 1))
    limits[:num_lines, 0] = -np.inf
    options = {"primal_feasibility_tolerance": _LP_TOLERANCE, "dual_feasibility_tolerance": _LP_TOLERANCE}
    position, total = np.zeros(num_lines), 0.0
    for stage in stages:
        row, bound = _members(model, stage)
        cost = np.concatenate([np.zeros(num_lines), row[included], row[included], bound[soft]])
        solution = linprog(cost, inequality, upper, equality, value[included], limits, options=options)
        if solution.x is None:
            raise FacadeError("No sizes were found for these wishes: try other or fewer wishes.")
        position, total = solution.x[:num_lines], total + float(solution.fun)
        inequality = sparse.vstack([inequality, sparse.csr_array(cost[None])], format="csr")
        upper = np.append(upper, solution.fun + _LP_TOLERANCE)
    return position, total


def _members(model: SizeModel, ties: Sequence[_Tie]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """[R] whether each row is in one of these groups, and [K] whether each bound is."""
    row, bound = np.zeros(len(model.kind), dtype=bool), np.zeros(len(model.bound_source), dtype=bool)
    for kind, along, source in ties:
        row |= (model.kind == kind) & (model.along == along) & (model.source == source)
        bound |= (kind == WISH) & (model.bound_source == source)
    return row, bound


def _in_words(tie: _Tie, facade: Facade, wishes: Sequence[Wish]) -> str:
    kind, along, source = tie
    if kind == WISH:
        return in_words(wishes[source], facade)
    if source == len(facade.grids):
        if kind == SYMMETRY:
            return f"elements of one {'width' if along == X else 'height'} stay alike"
        return f"what stands exactly {'above' if along == X else 'beside'} each other stays so"
    name = facade.grids[source].name
    if kind == SYMMETRY:
        return f"what is alike in grid '{name}' keeps its {'widths' if along == X else 'heights'} alike"
    return f"the {'columns' if along == X else 'rows'} of grid '{name}' stay aligned"


def _irreducible(model: SizeModel, value: Floats, ties: list[_Tie]) -> list[_Tie]:
    """A minimal set of contradicting groups, found by dropping one after the other."""
    kinds = [[tie for tie in ties if tie[0] == kind] for kind in (SYMMETRY, ALIGNMENT)]
    remaining = ties
    for dropped in [*kinds, *([tie] for tie in ties)]:
        without = [tie for tie in remaining if tie not in dropped]
        if len(without) < len(remaining) and _least_slack(model, value, without, [without])[1] > _CONTRADICTION:
            remaining = without
    return remaining
