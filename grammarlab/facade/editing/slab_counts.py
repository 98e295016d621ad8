"""Numbers of columns of a whole facade that fit another size best, with a proof.

Columns in a row are springs in series: at a size s, numbers n of columns with lengths a and gives q, beside a fixed
part of length a0 and give q0, have the energy (s - a0 - n a)^2 / (q0 + n q). To it comes a price for numbers that
differ from their shares of the size. Columns with the same elements and nearly the same length are one kind, and count
with their mean length and give. All numbers of kinds that can be better than a first guess are tried.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.editing.composition import Interval, composed
from grammarlab.facade.editing.faults import find_faults
from grammarlab.facade.editing.repeats import counts_in_words
from grammarlab.facade.editing.retarget import EVENNESS_DEVIATION
from grammarlab.facade.editing.springs import least_energy
from grammarlab.facade.editing.variations import Variation
from grammarlab.facade.editing.wall_slabs import Slab, find_elements, find_slabs
from grammarlab.facade.sizes.constraints import SIMILAR_SIZE_TOLERANCE, LineOrigin
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH
from grammarlab.facade.sizes.size_wishes import Size
from grammarlab.facade.tree import TOLERANCE, Facade

_STRETCH = 1.1
"""Stretch at which the give of a column is measured; its energy is quadratic."""
_MOST_STEPS = 1000
"""Largest number of improvements of a first guess."""
_MOST_NUMBERS = 300_000
"""Largest number of numbers to try: some tenths of a second."""


@dataclass(frozen=True, eq=False)
class SlabChoice:
    """The columns of a facade for another size."""

    along: int
    """X for columns, Y for rows."""
    variation: Variation
    """The facade with these columns, laid out without deformation."""
    counts: tuple[int, ...]
    """Number of copies of each column."""
    is_proven: bool
    """Whether no other numbers of kinds of columns deform less."""

    def __str__(self) -> str:
        return f"facade: {counts_in_words(self.along, self.counts)}"


@dataclass(frozen=True, eq=False)
class SpringKinds:
    """S kinds of columns as springs in series, beside a fixed part."""

    length: Floats
    """[S] mean length, metres."""
    give: Floats
    """[S] square metres per unit of energy, > 0."""
    price: Floats
    """[S] energy for a deviation of one from the share; quadratic, > 0."""
    share: Floats
    """[S] proportional number of each kind."""
    least: Ints
    """[S] least number of each kind."""
    fixed_length: float
    """Length of the fixed part, metres."""
    fixed_give: float
    """Give of the fixed part."""
    size: float
    """Target of the whole, metres."""

    def deformation(self, counts: Ints) -> Floats:
        """[...] energy and price of counts [..., S]; infinite if nothing would be left."""
        length, give = self.fixed_length + counts @ self.length, self.fixed_give + counts @ self.give
        stretched = np.square(self.size - length) / np.where(give > 0.0, give, 1.0)
        price = np.square(counts - self.share) @ self.price
        return np.where((give > 0.0) & (length > 0.0), stretched + price, np.inf)


def best_slabs(
    before: Variation,
    facade: Facade,
    along: int,
    metres: float,
    locked: Collection[int] = (),
    *,
    careful: bool = False,
    shops: bool = False,
    singles: bool = True,
) -> SlabChoice | None:
    """The columns for a size (rows for `along` = Y); None if no column of the facade can be repeated.

    Args:
        before: a variation laid out with its targets, such as the unedited facade.
        facade: the original facade.
        along: X for columns, Y for rows.
        metres: target size along the axis.
        locked: nodes of the variation with locks; their columns keep one copy.
        careful: whether to leave columns as they are that show a fault if they alone occur twice, or not at all for a
            smaller size.
        shops: whether shop windows are openings that are never cut.
        singles: whether elements that are alone in their storey occur once, as long as enough columns are left.
    """
    elements = find_elements(before.facade, along, shops=shops, singles=singles)
    slabs, solid = find_slabs(before.facade, along, elements, locked), elements.uncut
    if careful:
        slabs = _faultless(
            before, facade, along, slabs, solid, 2 if metres > float(before.facade.size[0, along]) else 0
        )
    if all(slab.is_fixed for slab in slabs):
        return None
    kinds = _kinds(slabs)
    counts, is_proven = best_counts(_springs(before, facade, along, metres, slabs, kinds, solid))
    copies = _balanced(slabs, kinds, counts)
    intervals = _intervals(slabs, copies, float(before.facade.size[0, along]))
    return SlabChoice(along, composed(before, along, intervals, solid), tuple(copies.tolist()), is_proven)


def changed_slabs(before: Variation, along: int, change: int) -> Iterator[SlabChoice]:
    """The facade with columns of the whole facade more or fewer: evenly spread, or of one column after the other.

    Args:
        before: a variation laid out with its targets.
        along: X for columns, Y for rows.
        change: number of columns to add, or to leave out if negative.
    """
    elements = find_elements(before.facade, along)
    slabs = find_slabs(before.facade, along, elements)
    free = np.flatnonzero([not slab.is_fixed for slab in slabs])
    num, whole = len(free), float(before.facade.size[0, along])
    if change < 0:
        changes = [np.roll(np.repeat([-1, 0], [-change, num + change]), shift) for shift in range(num + change + 1)]
    else:
        changes = [change * np.eye(num, dtype=np.int64)[index] for index in range(num)]
    if num and num + change >= 0:
        changes.insert(0, np.sign(change) * _spread(abs(change), num))
    for counts in {tuple(one.tolist()): None for one in changes if num + change >= 0}:
        copies = np.ones(len(slabs), dtype=np.int64)
        copies[free] += np.array(counts, dtype=np.int64)
        solid, intervals = elements.uncut, _intervals(slabs, copies, whole)
        try:
            variation = composed(before, along, intervals, solid)
        except FacadeError:  # nothing would be left
            continue
        yield SlabChoice(along, variation, tuple(copies.tolist()), is_proven=False)


def best_counts(kinds: SpringKinds) -> tuple[Ints, bool]:
    """The numbers [S] of least deformation, and whether all others that could be better were tried."""
    counts = np.maximum(np.rint(kinds.share), kinds.least).astype(np.int64)
    if not np.isfinite(kinds.deformation(counts)):
        counts[0] += 1
    counts = _descended(kinds, counts)
    # The price alone bounds the numbers that are better.
    reach = np.sqrt(float(kinds.deformation(counts)) / kinds.price)
    low = np.maximum(np.ceil(kinds.share - reach), kinds.least).astype(np.int64)
    high = np.maximum(np.floor(kinds.share + reach).astype(np.int64), low)
    if float(np.prod(high - low + 1.0)) > _MOST_NUMBERS:
        return counts, False
    ranges = [np.arange(first, last + 1) for first, last in zip(low.tolist(), high.tolist(), strict=True)]
    numbers = np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, len(ranges))
    best = numbers[int(kinds.deformation(numbers).argmin())]  # ty: ignore[invalid-argument-type]
    return (best if kinds.deformation(best) < kinds.deformation(counts) else counts), True


def _descended(kinds: SpringKinds, counts: Ints) -> Ints:
    """Counts that no single change by one, and no exchange of one for another, improves."""
    steps = np.vstack([np.eye(len(counts), dtype=np.int64), -np.eye(len(counts), dtype=np.int64)])
    steps = (steps[:, None] + np.vstack([steps, 0 * steps[:1]])[None]).reshape(-1, len(counts))
    for _ in range(_MOST_STEPS):
        candidates = counts + steps
        candidates = candidates[(candidates >= kinds.least).all(axis=1)]
        energies = kinds.deformation(candidates)
        best = int(energies.argmin())
        # Sums of many numbers differ by rounding from those of one.
        if not energies[best] < (1.0 - 1e-12) * float(kinds.deformation(counts)):
            break
        counts = candidates[best]
    return counts


def _kinds(slabs: Sequence[Slab]) -> list[list[int]]:
    """The columns of each kind that can be repeated."""
    kinds: list[list[int]] = []
    order = sorted(range(len(slabs)), key=lambda index: (slabs[index].contents, slabs[index].length))
    for index in order:
        slab = slabs[index]
        if slab.is_fixed:
            continue
        last = slabs[kinds[-1][-1]] if kinds else None
        is_alike = (
            last is not None
            and last.contents == slab.contents
            and slab.length <= (1.0 + SIMILAR_SIZE_TOLERANCE) * last.length
            and not (last.is_required or slab.is_required)
        )
        if is_alike:
            kinds[-1].append(index)
        else:
            kinds.append([index])
    return [sorted(members) for members in kinds]


def _springs(
    before: Variation,
    facade: Facade,
    along: int,
    metres: float,
    columns: Sequence[Slab],
    kinds: Sequence[Sequence[int]],
    solid: Ints,
) -> SpringKinds:
    whole = float(before.facade.size[0, along])
    length = np.array([float(np.mean([columns[index].length for index in members])) for members in kinds], np.float64)
    occurs = np.array([len(members) for members in kinds])
    fixed = _intervals(columns, np.array([int(slab.is_fixed) for slab in columns]), whole)
    fixed = [(begin, end) for begin, end in fixed if end > begin]
    fixed_length = whole - float(occurs @ length)
    measured = [
        _measured(before, facade, along, [(columns[members[0]].begin, columns[members[0]].end)], solid)
        for members in kinds
    ]
    give = np.array([one[0] for one in measured], np.float64) * length
    leaves = np.array([one[1] for one in measured])
    share = occurs * max(metres - fixed_length, 0.0) / float(occurs @ length)
    return SpringKinds(
        length=length,
        give=give,
        price=EVENNESS_DEVIATION**2 * leaves / occurs,
        share=share,
        least=np.array([int(columns[members[0]].is_required) for members in kinds]),
        fixed_length=fixed_length,
        fixed_give=_measured(before, facade, along, fixed, solid)[0] * fixed_length if fixed else 0.0,
        size=metres,
    )


def _faultless(
    before: Variation, facade: Facade, along: int, slabs: Sequence[Slab], solid: Ints, count: int
) -> tuple[Slab, ...]:
    """The columns; those fixed that cause a fault if they occur this many times and all others once."""
    checked = []
    for index, slab in enumerate(slabs):
        copies = np.ones(len(slabs), dtype=np.int64)
        copies[index] = count
        is_fixed = slab.is_fixed
        if not is_fixed:
            variation = composed(before, along, _intervals(slabs, copies, float(before.facade.size[0, along])), solid)
            is_fixed = bool(find_faults(facade, variation, variation.facade).words)
        checked.append(replace(slab, is_fixed=is_fixed))
    return tuple(checked)


def _measured(
    before: Variation, facade: Facade, along: int, intervals: Sequence[Interval], solid: Ints
) -> tuple[float, int]:
    """Give of some intervals, per metre of their length, and the number of their leaves."""
    part = composed(before, along, intervals, solid)
    length = float(part.facade.size[0, along])
    origin = LineOrigin(part.facade.position, part.target, facade.size[0], shares_lines=True)
    wish = Size(0, along, _STRETCH * length)
    energy = least_energy(part.facade, origin, [wish], "default", (WISH, ALIGNMENT, SYMMETRY))
    return ((_STRETCH - 1.0) * length) ** 2 / (energy * length), len(part.facade.leaves)


def _balanced(slabs: Sequence[Slab], kinds: Sequence[Sequence[int]], counts: Ints) -> Ints:
    """Copies [S] of each column, for numbers of kinds: spread evenly, and as much to the left as to the right.

    So a facade with a portal in its middle keeps it there, if columns of several kinds are left out or added.
    """
    copies = np.ones(len(slabs), dtype=np.int64)
    middle = 0.5 * (slabs[0].begin + slabs[-1].end)
    offset = np.array([0.5 * (slab.begin + slab.end) - middle for slab in slabs])
    moment = 0.0
    for members, count in zip(kinds, counts.tolist(), strict=True):
        spread = _spread(count, len(members))
        moments = [moment + float((one - 1) @ offset[members]) for one in (spread, spread[::-1])]
        mirrored = abs(moments[1]) < abs(moments[0]) - TOLERANCE * abs(offset).max()
        copies[members], moment = (spread[::-1], moments[1]) if mirrored else (spread, moments[0])
    return copies


def _spread(count: int, members: int) -> Ints:
    """[K] copies of each of some columns of a kind: all as often, and the rest evenly among them."""
    each, extra = divmod(count, members)
    copies = np.full(members, each)
    copies[((np.arange(extra) + 0.5) * members / max(extra, 1)).astype(np.int64)] += 1
    return copies


def _intervals(slabs: Sequence[Slab], copies: Ints, whole: float) -> list[Interval]:
    """The intervals of a facade with copies [S] of each column."""
    inner = [(slab.begin, slab.end) for slab, count in zip(slabs, copies.tolist(), strict=True) for _ in range(count)]
    return [(0.0, slabs[0].begin), *inner, (slabs[-1].end, whole)]
