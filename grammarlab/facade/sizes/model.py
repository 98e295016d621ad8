"""A facade and wishes as a quadratic programme.

The axes are independent unless a wish connects them: only with a wish for an aspect ratio, both are solved in one
programme.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.sizes.axes import Axis
from grammarlab.facade.sizes.lines import Sums, stacked
from grammarlab.facade.sizes.program import QuadraticProgram
from grammarlab.facade.sizes.wishes import Aspect, Position, Size, Wish
from grammarlab.facade.tree import Facade, Floats, Ints, X, Y

SYMMETRY, ALIGNMENT, WISH = 0, 1, 2
"""Kinds of rows, in the order of relaxation."""
_STILL = 1e-12
"""Largest distance, as a fraction of the facade's size, that counts as 0."""
_NONE = Sums(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2)))


@dataclass(frozen=True, eq=False)
class SizeModel:
    """R equations and K bounds over the M lines of one axis, or of both, with their sources."""

    axes: tuple[Axis, ...]
    program: QuadraticProgram
    scale: float
    """Unit of length, metres."""
    value: Floats
    """[R] values of the programme's rows."""
    kind: Ints
    """[R] `SYMMETRY`, `ALIGNMENT` or `WISH`."""
    along: Ints
    """[R] axis of the grid; 0 for wishes."""
    source: Ints
    """[R] index of the grid, or of the wish."""
    bound_source: Ints
    """[K] index of the wish for the bounds of an aspect ratio; -1 for least sizes of leaves."""

    def lines(self, place: Floats) -> list[Floats]:
        """[M] for each axis, positions of its lines, metres, the first at 0."""
        each = np.split(place, np.cumsum([axis.lines.num for axis in self.axes])[:-1])
        return [(lines - lines[0]) * self.scale for lines in each]

    def places(self, facade: Facade) -> Floats:
        """[M] positions of the lines of a facade of the same tree."""
        sides = [(axis.lines, facade.position[:, axis.along], facade.size[:, axis.along]) for axis in self.axes]
        return np.concatenate([lines.places(position, size) for lines, position, size in sides]) / self.scale

    def wanted(self, wishes: Sequence[Wish]) -> Floats:
        """[R] values of the rows for wishes that differ from those of the model only in lengths."""
        value, of_wish = self.value.copy(), self.kind == WISH
        value[of_wish] = _values([wishes[at] for at in self.source[of_wish]], self.scale)
        return value


def build_model(axes: Sequence[Axis], wishes: Sequence[Wish], scale: float) -> SizeModel:
    """The programme of these axes under the wishes for them.

    Args:
        axes: one of them, or both if a wish connects them.
        wishes: all wishes.
        scale: unit of length, metres.
    """
    firsts = np.cumsum([0, *(axis.lines.num for axis in axes)]).tolist()
    ties = [(SYMMETRY, axis.symmetry, axis.along, first) for axis, first in zip(axes, firsts, strict=False)]
    ties += [(ALIGNMENT, axis.alignment, axis.along, first) for axis, first in zip(axes, firsts, strict=False)]
    lengths = [
        (at, _length(axis, wish).shifted(first))
        for axis, first in zip(axes, firsts, strict=False)
        for at, wish in enumerate(wishes)
        if isinstance(wish, Size | Position) and wish.axis == axis.along
    ]
    aspects = [(at, wish) for at, wish in enumerate(wishes) if isinstance(wish, Aspect) and len(axes) > 1]
    ranges = [_aspect(axes, firsts, wish) for _, wish in aspects]
    sizes = stacked([axis.extent.shifted(first) for axis, first in zip(axes, firsts, strict=False)])
    weight = np.concatenate([axis.weight for axis in axes]) * scale
    # Sizes do not determine the position of a facade; a target of 0 for the start of each axis does, at no cost.
    pins = Sums(np.array(firsts[:-1])[:, None], np.ones((len(axes), 1)))
    counts = [*(len(tie.value) for _, tie, _, _ in ties), len(lengths)]
    kind = np.repeat([*(kind for kind, *_ in ties), WISH], counts)
    value = np.concatenate([*(tie.value for _, tie, _, _ in ties), _values([wishes[at] for at, _ in lengths], scale)])
    rows = stacked([_NONE, *(tie.sums.shifted(first) for _, tie, _, first in ties), *(row for _, row in lengths)])
    program = QuadraticProgram(
        num_lines=firsts[-1],
        parts=stacked([sizes, pins]),
        weight=np.append(weight, np.full(len(axes), weight.max())),
        target=np.append(np.concatenate([axis.target for axis in axes]), np.zeros(len(axes))),
        rows=rows,
        still=(np.abs(value) <= _STILL) & (kind != WISH),
        bounds=stacked([sizes, *ranges]),
        least=np.concatenate([*(axis.least for axis in axes), np.zeros(2 * len(aspects))]),
    )
    return SizeModel(
        axes=tuple(axes),
        program=program,
        scale=scale,
        value=np.where(program.still, 0.0, value),
        kind=kind,
        along=np.repeat([*(along for _, _, along, _ in ties), X], counts),
        source=np.concatenate([*(tie.grid for _, tie, _, _ in ties), [at for at, _ in lengths]]).astype(np.int64),
        bound_source=np.repeat([-1, *(at for at, _ in aspects)], [len(sizes), *(2 for _ in aspects)]),
    )


def _values(wishes: Sequence[Wish], scale: float) -> list[float]:
    """Values of the rows of wishes for sizes and positions."""
    return [wish.metres / scale for wish in wishes if not isinstance(wish, Aspect)]


def _length(axis: Axis, wish: Size | Position) -> Sums:
    """[1] the size or the position that a wish fixes."""
    node, start = np.array([wish.node]), np.zeros(1)
    if isinstance(wish, Size):
        return axis.lines.extent(node)
    return axis.lines.reach(node, start).minus(axis.lines.reach(np.zeros(1, dtype=np.int64), start))


def _aspect(axes: Sequence[Axis], firsts: Sequence[int], wish: Aspect) -> Sums:
    """[2] width - least * height and most * height - width, which must be at least 0."""
    node, order = np.array([wish.node, wish.node]), [axis.along for axis in axes]
    width, height = (
        axes[order.index(along)].lines.extent(node).shifted(firsts[order.index(along)]) for along in (X, Y)
    )
    return width.times(np.array([1.0, -1.0])).minus(height.times(np.array([wish.least, -wish.most])))
