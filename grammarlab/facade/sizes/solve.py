"""Sizes of a facade under wishes: as near to what they were as its structure allows (paper 000, section 5)."""

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
"""Sizes that fit all wishes this well, as part of the facade's size, are not solved for."""


@dataclass(frozen=True, slots=True)
class Residuals:
    """What the sizes of a facade miss, measured on the facade itself."""

    decomposition: float
    """Largest gap or overlap of parts, as part of the facade's width or height."""
    alignment: float
    """Metres by which the worst distance between anchors of neighbours in a grid is not what it was."""
    symmetry: float
    """Metres by which the worst size is not in its ratio to that of a part that is alike."""
    target: float
    """Metres by which the worst wish is missed."""

    def as_dict(self) -> dict[str, float]:
        """For `--json`."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Resized:
    """A facade whose sizes have been solved for."""

    facade: Facade
    energy: tuple[float, float]
    """E of Equation 1 for widths and for heights: 0 where nothing deviates."""
    residuals: Residuals
    conflict: tuple[str, ...]
    """Wishes and grids that contradict each other, and without any one of them would not; empty when all is met."""
    relaxed: tuple[str, ...]
    """What gave way, and by how many metres at most; empty when all is met."""


@dataclass(frozen=True, eq=False)
class Sizing:
    """A facade and the kinds of wishes it gets, ready to be solved for any lengths, as while a handle is dragged."""

    facade: Facade
    wishes: tuple[Wish, ...]
    origin: LineOrigin
    weight: Floats
    """[L, 2] of leaves, for metres."""

    @cached_property
    def models(self) -> tuple[SizeModel, ...]:
        """A programme for each axis; one for both when a wish ties them."""
        scale = max(self.facade.width, self.facade.height)
        axes = [build_axis(self.facade, along, self.origin, self.weight[:, along], scale) for along in (X, Y)]
        tied = any(isinstance(wish, Aspect) for wish in self.wishes)
        groups = [axes] if tied else [axes[:1], axes[1:]]
        return tuple(build_model(group, self.wishes, scale) for group in groups)

    def resized(self, wishes: Sequence[Wish]) -> Resized:
        """The facade under wishes that differ from those it was prepared for in metres only.

        Raises:
            FacadeError: for lengths that no facade can have, and for other kinds of wishes.
        """
        wishes = checked(wishes, self.facade)
        if [_kind(wish) for wish in wishes] != [_kind(wish) for wish in self.wishes]:
            raise FacadeError(
                "Expected the wishes that the facade was prepared for with other metres, found other wishes."
            )
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
    """A facade that is about to be solved for several times, for wishes that differ in metres only.

    Args:
        facade: a facade with its grids.
        wishes: what is fixed.
        wanted: what its nodes would like to be, when that is not what they are: after columns were inserted.
        weights: how much deviations count: in parts of what deviates, or as the paper says.

    Raises:
        FacadeError: for wishes that mean nothing for this facade.
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
        facade: a facade with its grids; what is aligned and alike in these stays so.
        wishes: what is fixed; a size that nobody fixes comes out of the others.
        wanted: what its nodes would like to be, when that is not what they are: after columns were inserted.
        weights: how much deviations count: in parts of what deviates, or as the paper says.

    Raises:
        FacadeError: for wishes that mean nothing for this facade.
    """
    return prepare(facade, wishes, wanted, weights).resized(wishes)


def _kind(wish: Wish) -> Wish:
    """A wish without its metres; a range of aspects counts as a kind."""
    return wish if isinstance(wish, Aspect) else replace(wish, metres=0.0)
