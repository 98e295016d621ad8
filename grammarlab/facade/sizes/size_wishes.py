"""Wishes: properties of a facade that a person fixes before its sizes are solved for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import SHORTEST, Facade, X, Y

MAX_LENGTH_RATIO = 1000.0
"""Largest length of a wish, as a multiple of the larger side of the facade."""
MAX_ASPECT = 1e6
"""Largest ratio of the sides of a part, in both directions."""


@dataclass(frozen=True, slots=True)
class Size:
    """A node with a given size along one axis; node 0 is the facade itself."""

    node: int
    """Index of the node."""
    axis: int
    """0 for the width, 1 for the height."""
    metres: float
    """Size, metres, > 0."""


@dataclass(frozen=True, slots=True)
class Position:
    """A node with a given distance of its edge from the left or the bottom of the facade."""

    node: int
    """Index of the node."""
    axis: int
    """0 for the left edge, 1 for the lower edge."""
    metres: float
    """Distance, metres, >= 0."""


@dataclass(frozen=True, slots=True)
class Aspect:
    """A node with a range of the ratio of width to height: the only wish that connects both axes."""

    node: int
    """Index of the node."""
    least: float
    """Least ratio of width to height, > 0."""
    most: float
    """Largest ratio of width to height, at least `least`."""


Wish = Size | Position | Aspect


def width(metres: float) -> Size:
    """A facade with a given width."""
    return Size(0, X, metres)


def height(metres: float) -> Size:
    """A facade with a given height."""
    return Size(0, Y, metres)


def checked(wishes: Sequence[Wish], facade: Facade) -> tuple[Wish, ...]:
    """The wishes themselves, if all are valid for this facade.

    Raises:
        FacadeError: If a node does not exist, or a length or range is out of range.
    """
    largest = MAX_LENGTH_RATIO * max(facade.width, facade.height)
    for wish in wishes:
        if not 0 <= wish.node < len(facade):
            raise FacadeError(f"A wish for node {wish.node}: expected 0 to {len(facade) - 1}.")
        if isinstance(wish, Aspect):
            if not 1.0 / MAX_ASPECT <= wish.least <= wish.most <= MAX_ASPECT:
                raise FacadeError(
                    f"{in_words(wish, facade)}: expected a range above 0, the smaller number first, from "
                    f"{1.0 / MAX_ASPECT:g} to {MAX_ASPECT:,.0f}."
                )
        elif wish.axis not in {X, Y}:
            raise FacadeError(f"A wish along axis {wish.axis}: expected {X} for x or {Y} for y.")
        elif not (SHORTEST if isinstance(wish, Size) else 0.0) <= wish.metres <= largest:
            bound = "above 0" if isinstance(wish, Size) else "of at least 0"
            raise FacadeError(f"{in_words(wish, facade)}: expected a length {bound} and at most {largest:g} m.")
    return tuple(wishes)


def in_words(wish: Wish, facade: Facade) -> str:
    """A wish as a sentence without its full stop, such as `the facade is 31.5 m wide`."""
    name = f"{facade.name_of(wish.node) or 'part'} (node {wish.node})" if wish.node else "the facade"
    if isinstance(wish, Size):
        return f"{name} is {wish.metres:g} m {'wide' if wish.axis == X else 'high'}"
    if isinstance(wish, Position):
        edge = "left" if wish.axis == X else "lower"
        return f"the {edge} edge of {name} is {wish.metres:g} m from that of the facade"
    return f"{name} is {wish.least:g} to {wish.most:g} times as wide as high"
