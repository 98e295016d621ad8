"""Sizes of a facade under wishes: as close to the original ones as its structure allows (paper 000, section 5).

Wishes that contradict each other: a minimal contradiction, and the closest sizes.

Symmetry is relaxed first, then alignment, then wishes; the decomposition always holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import linprog

from grammarlab.errors import FacadeError
from grammarlab.facade.sizes.constraints import LineOrigin, Weights, build_axis, leaf_weights
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH, SizeModel, build_model
from grammarlab.facade.sizes.size_wishes import Aspect, Wish, checked, in_words
from grammarlab.facade.tree import Facade, Floats, X, Y, decomposition_misses

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


_UNMOVED = 1e-12
"""Largest violation, as a fraction of the facade's size, of sizes that are kept without a solution."""


@dataclass(frozen=True, slots=True)
class Residuals:
    """Violations of constraints, measured on the facade itself."""

    decomposition: float
    """Largest gap or overlap of parts, as a fraction of the facade's width or height."""
    alignment: float
    """Largest change of the distance between anchors of neighbours in a grid, metres."""
    symmetry: float
    """Largest deviation of a size from its ratio to that of a similar part, metres."""
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
            value = model.wanted(wishes)
            start = model.places(self.facade)
            if max(model.program.misses(start, value), model.program.deviation(start)) <= _UNMOVED:
                continue
            place = model.program.solve(value)
            if place is None:
                found = compromise(model, value, self.facade, wishes)
                place, conflict, relaxed = found.place, [*conflict, *found.conflict], [*relaxed, *found.relaxed]
            for axis, lines in zip(model.axes, model.lines(place), strict=True):
                position[:, axis.along], size[:, axis.along] = axis.lines.laid(lines)
        facade = replace(self.facade, position=position, size=size)
        return Resized(facade, self._energy(facade), self._residuals(facade, wishes), tuple(conflict), tuple(relaxed))

    def _energy(self, facade: Facade) -> tuple[float, float]:
        leaf = facade.leaves
        energy = np.square(self.weight * (facade.size[leaf] - self.origin.size[leaf])).sum(axis=0)
        return float(energy[X]), float(energy[Y])

    def _residuals(self, facade: Facade, wishes: Sequence[Wish]) -> Residuals:
        worst = np.zeros(3)
        for model in self.models:
            place = model.places(facade)
            gaps = np.abs(model.program.rows.at(place) - model.wanted(wishes)) * model.scale
            short = (model.program.least - model.program.bounds.at(place))[model.bound_source >= 0] * model.scale
            np.maximum.at(worst, model.kind, gaps)
            np.maximum.at(worst, np.full(len(short), WISH), short)
        decomposition = float(decomposition_misses(facade)[0].max(initial=0.0))
        return Residuals(decomposition, float(worst[ALIGNMENT]), float(worst[SYMMETRY]), float(worst[WISH]))


def prepare(
    facade: Facade, wishes: Sequence[Wish], wanted: LineOrigin | None = None, weights: Weights = "default"
) -> Sizing:
    """A facade prepared for several solutions, for wishes that differ only in metres.

    Args:
        facade: a facade with its grids.
        wishes: fixed properties.
        wanted: target sizes of its nodes, if they differ from the current ones, as after insertions.
        weights: kind of weights: relative deviations, or those of the paper.

    Raises:
        FacadeError: If a wish does not apply to this facade.
    """
    origin = wanted or LineOrigin(facade.position, facade.size, facade.size[0])
    if origin.size.shape != facade.size.shape or not (np.isfinite(origin.size).all() and (origin.size > 0.0).all()):
        raise FacadeError(f"Wanted sizes: expected {facade.size.shape} finite numbers above 0.")
    weight = leaf_weights(origin.size[facade.leaves], origin.whole, weights)
    return Sizing(facade, checked(wishes, facade), origin, weight)


def resize(
    facade: Facade, wishes: Sequence[Wish], wanted: LineOrigin | None = None, weights: Weights = "default"
) -> Resized:
    """The facade under these wishes.

    Args:
        facade: a facade with its grids; alignments and equal sizes of these are preserved.
        wishes: fixed properties; other sizes follow.
        wanted: target sizes of its nodes, if they differ from the current ones, as after insertions.
        weights: kind of weights: relative deviations, or those of the paper.

    Raises:
        FacadeError: If a wish does not apply to this facade.
    """
    return prepare(facade, wishes, wanted, weights).resized(wishes)


def _kind(wish: Wish) -> Wish:
    """A wish without its metres; a range of aspect ratios is part of the kind."""
    return wish if isinstance(wish, Aspect) else replace(wish, metres=0.0)
