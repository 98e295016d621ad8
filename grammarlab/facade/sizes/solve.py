"""Sizes of a facade under wishes: as close to the original ones as its structure allows (paper 000, section 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.sizes.axes import LineOrigin, Weights, build_axis, leaf_weights
from grammarlab.facade.sizes.conflicts import compromise
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH, SizeModel, build_model
from grammarlab.facade.sizes.wishes import Aspect, Wish, checked
from grammarlab.facade.tree import Facade, Floats, X, Y, decomposition_misses

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
