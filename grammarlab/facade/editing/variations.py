"""Variations of a facade with one column or row added or removed in one of its grids (paper 000, section 4).

Removal of a column takes its elements, the parts of the wall without other contents, and the gap beside each. Copies of
locked nodes are locked.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.editing.column_insertion import Insertion, Placement, inserted, stretched, unreachable
from grammarlab.facade.editing.grid_proposals import unused
from grammarlab.facade.editing.grids import following, grid_of, kinds
from grammarlab.facade.editing.pieces import (
    NEW,
    WHOLE,
    AxisView,
    FacadePart,
    JoinedParts,
    assembled,
    part_of,
    stretched_targets,
    take,
)
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.size_wishes import Position, Wish
from grammarlab.facade.tree import Facade, X, check

_MAX_DEPTH = 200
"""Largest depth of a tree for edits; real facades have about ten levels."""


@dataclass(frozen=True, slots=True)
class Edit:
    """One column (or row) of some grids, added or removed."""

    grids: tuple[str, ...]
    """Active grids; all have this line and position."""
    axis: int
    """X for columns, Y for rows."""
    line: int
    """Column from 0 at the left, or row from 0 at the top, to repeat or remove."""
    position: int | None = None
    """Number of columns (rows) before the new one; None to remove."""

    def __str__(self) -> str:
        name = "column" if self.axis == X else "row"
        text = f"{' and '.join(self.grids)}: {name} {self.line + 1}"
        if self.position is None:
            return f"{text} removed"
        return f"{text} repeated " + (f"after {name} {self.position}" if self.position else f"before {name} 1")


@dataclass(frozen=True, eq=False)
class Variation:
    """A facade made from another one by edits."""

    facade: Facade
    """The edited facade, laid out from `target`; its sizes are initial values, not a solution."""
    source: Ints
    """[N] node of the original facade that each node is or copies; -1 for new inner nodes."""
    target: Floats
    """[N, 2] target sizes of leaves, metres: those of their sources, of the visible parts of cut leaves, and of changed
    rows for bands over them."""
    visible: Floats
    """[N, 4] left, bottom, right, top of the visible part of a leaf's source."""
    edits: tuple[Edit, ...] = ()
    missing: tuple[str, ...] = ()
    """Parts of the edits that were not possible, in words."""

    @property
    def steps(self) -> tuple[str, ...]:
        """The edits in words."""
        return tuple(str(edit) for edit in self.edits)


@dataclass(frozen=True, slots=True)
class Variations:
    """Results of edits, and edits without a result."""

    variations: tuple[Variation, ...]
    discarded: tuple[str, ...]
    """Each impossible edit, with the reason."""


def vary(
    start: Facade | Variation,
    grid: str,
    axis: int,
    *,
    also: Sequence[str] | None = None,
    insertions: bool = True,
    removals: bool = True,
) -> Variations:
    """Every facade with one column (or row) added or removed in a grid.

    Args:
        start: a facade, or a variation to continue from.
        grid: name of the active grid.
        axis: X for columns, Y for rows.
        also: grids that are edited in the same places; by default those that `following` finds. They must have as many
            columns (rows) as the active one.
        insertions: whether to repeat each different column at every position: before, between and after the others.
        removals: whether to remove each column.
    """
    before = unedited(start) if isinstance(start, Facade) else start
    names = (grid, *(following(before.facade, grid) if also is None else also))
    variations, discarded = [], []
    wall = _wall(before.facade, axis)
    for edit in edits(before.facade, names, axis):
        if insertions if edit.position is not None else removals:
            try:
                variations.append(_applied(before, wall, edit))
            except FacadeError as error:
                discarded.append(f"{edit}: {error}")
    return Variations(tuple(variations), tuple(discarded))


def edits(facade: Facade, grids: Sequence[str], axis: int) -> Iterator[Edit]:
    """Insertions of each different column (or row) of some grids at every position, then removals of each.

    Raises:
        FacadeError: If the grids have different numbers of columns (rows).
    """
    lines = [_lines(grid_of(facade, name), axis) for name in grids]
    if len({len(grid_lines) for grid_lines in lines}) != 1:
        raise FacadeError(
            f"Grids {', '.join(grids)}: expected the same number of {'columns' if axis == X else 'rows'} in each."
        )
    kind = np.append(kinds(facade), -1)
    contents = [tuple(kind[grid_lines[line]].tobytes() for grid_lines in lines) for line in range(len(lines[0]))]
    for line, content in enumerate(contents):
        if content not in contents[:line]:
            yield from (Edit(tuple(grids), axis, line, position) for position in range(len(contents) + 1))
    if len(contents) > 1:
        yield from (Edit(tuple(grids), axis, line) for line in range(len(contents)))


def unedited(facade: Facade) -> Variation:
    """The facade itself as a variation without edits."""
    whole = np.tile(WHOLE, (len(facade), 1))
    return Variation(facade, np.arange(len(facade)), facade.size.copy(), whole)


def _removed(wall: AxisView, elements: Set[int], *, last: bool) -> FacadePart | None:
    """The wall without some elements of its grids; None if nothing remains.

    A part of a row without other elements is removed whole, with the gap up to the next element: removal is the inverse
    of insertion. If a part contains other elements, only the removable pieces around the elements are removed;
    otherwise the wall closes over the place.

    Args:
        wall: the edited facade.
        elements: the elements to remove.
        last: whether they have the highest coordinates of their grids: then the gap before them is removed first.
    """
    return _reduced(wall, 0, elements, -1 if last else 1)


def applied(before: Variation, edit: Edit) -> Variation:
    """A variation after one more edit.

    Raises:
        FacadeError: If the edit is not possible; with the reason.
    """
    return _applied(before, _wall(before.facade, edit.axis), edit)


def lost(facade: Facade, locks: Sequence[Wish], variation: Variation) -> tuple[Wish, ...]:
    """Locks of parts of which neither a copy is left, nor a part of the same label with an equal lock.

    Args:
        facade: the original facade.
        locks: its locks; positions are not lost, since they do not apply to variations.
        variation: a variation of that facade.
    """
    remaining = {_lock_key(variation.facade, lock) for lock in inherited(locks, variation)}
    return tuple(
        lock
        for lock in locks
        if lock.node and not isinstance(lock, Position) and _lock_key(facade, lock) not in remaining
    )


def inherited(locks: Sequence[Wish], variation: Variation) -> tuple[Wish, ...]:
    """Locks of remaining nodes, and of their copies.

    Cut nodes have no locks. Positions have changed, so locks of positions are dropped.

    Args:
        locks: locks of the original facade.
        variation: a variation of that facade.
    """
    whole = np.isclose(variation.visible, WHOLE).all(axis=1)
    copies: list[Wish] = []
    for lock in locks:
        if isinstance(lock, Position):
            continue
        nodes = np.flatnonzero(whole & (variation.source == lock.node)).tolist() if lock.node else [0]
        copies += [replace(lock, node=node) for node in nodes]
    return tuple(copies)


def _lines(grid: Grid, axis: int) -> Ints:
    """[lines, places] nodes of each column, or of each row; -1 for phantoms."""
    return grid.places().T if axis == X else grid.places()


def check_depth(facade: Facade) -> None:
    """Check that a tree is not too deep for edits.

    Raises:
        FacadeError: If it is.
    """
    depth = [0] * len(facade)
    for node, above in enumerate(facade.parent.tolist()[1:], start=1):
        depth[node] = depth[above] + 1
    if max(depth) > _MAX_DEPTH:
        raise FacadeError(
            f"The facade has {max(depth)} levels of nested parts; expected at most {_MAX_DEPTH} to edit it."
        )


def _wall(facade: Facade, axis: int) -> AxisView:
    check_depth(facade)
    return AxisView(facade, axis)


def _applied(before: Variation, wall: AxisView, edit: Edit) -> Variation:
    if edit.position is None:
        top, added, missing = _line_removed(wall, edit), {}, []
    else:
        top, added, missing = _line_added(wall, edit, edit.position)
    tree = assembled(wall, top)
    facade, source, target, visible = _as_facade(before, wall, tree)
    grids = _grids(wall, edit, tree, added)
    facade = check(replace(facade, grids=grids))
    missing = [f"{edit}: {reason}" for reason in missing]
    return Variation(facade, source, target, visible, (*before.edits, edit), (*before.missing, *missing))


def _line_removed(wall: AxisView, edit: Edit) -> FacadePart:
    lines = [_lines(grid_of(wall.facade, name), edit.axis) for name in edit.grids]
    elements = {node for grid_lines in lines for node in grid_lines[edit.line].tolist()} - {-1}
    # Rows count from the top, coordinates from the bottom.
    top = _removed(wall, elements, last=edit.line == (len(lines[0]) - 1 if edit.axis == X else 0))
    if top is None:
        raise FacadeError("The edit would remove the whole facade.")
    return top


def _reduced(wall: AxisView, node: int, elements: Set[int], step: int) -> FacadePart | None:
    if node in elements:
        return None
    if not wall.has(node, elements):
        return wall.whole(node)
    children = wall.children[node]
    if wall.axis[node] != wall.along:
        return stretched(
            wall, node, children, [_reduced(wall, child, elements, step) for child in children], fresh=False
        )
    is_removed = [wall.has(child, elements) and not _has_others(wall, child, elements) for child in children]
    gaps = [not wall.has_elements(child) for child in children]
    for index in [index for index, drop in enumerate(is_removed) if drop]:
        for gap in _gap_beside(index, step, gaps, is_removed):
            is_removed[gap] = True
    remaining = [child for child, drop in zip(children, is_removed, strict=True) if not drop]
    return stretched(wall, node, remaining, [_reduced(wall, child, elements, step) for child in remaining], fresh=False)


def _has_others(wall: AxisView, node: int, elements: Set[int]) -> bool:
    """Whether a node contains elements that stay."""
    inside = wall.elements_before[wall.end[node]] - wall.elements_before[node]
    for element in elements:
        if node <= element < wall.end[node]:
            inside -= wall.elements_before[wall.end[element]] - wall.elements_before[element]
    return inside > 0


def _gap_beside(index: int, step: int, gaps: Sequence[bool], is_removed: Sequence[bool]) -> list[int]:
    """The gap on one side of a removed part, up to the next element; on the other side, if there is no next element.

    Without any other element, only one of both gaps is removed, so that a wall remains.
    """
    first, second = _gap(index, step, gaps, is_removed), _gap(index, -step, gaps, is_removed)
    for gap, ends_at_element in (first, second):
        if ends_at_element:
            return gap
    return first[0] if second[0] else []


def _gap(index: int, step: int, gaps: Sequence[bool], is_removed: Sequence[bool]) -> tuple[list[int], bool]:
    """The parts without elements next to a place, and whether another part follows them."""
    gap = []
    index += step
    while 0 <= index < len(gaps) and gaps[index] and not is_removed[index]:
        gap.append(index)
        index += step
    return gap, 0 <= index < len(gaps)


def _line_added(wall: AxisView, edit: Edit, position: int) -> tuple[FacadePart, dict[str, Ints], list[str]]:
    """The wall with a new line, the sources of that line in each grid, and the elements that could not be inserted."""
    added, missing, insertions = {}, [], []
    for name in edit.grids:
        lines = _lines(grid_of(wall.facade, name), edit.axis)
        sources = lines[edit.line].copy()
        for cross, source in enumerate(sources.tolist()):
            insertion = _insertion(lines[:, cross].tolist(), source, position, edit.axis)
            if source >= 0 and (insertion is None or unreachable(wall, insertion)):
                kind = "row" if edit.axis == X else "column"
                reason = "the place beside it is empty" if insertion is None else "its neighbours are not aligned"
                missing.append(f"nothing in {kind} {cross + 1} of {name}, {reason}")
                sources[cross] = -1
            elif insertion is not None:
                insertions.append(insertion)
        if (sources >= 0).any():
            added[name] = sources
    if not insertions:
        raise FacadeError("; ".join(missing) or "There is nothing to repeat.")
    # Grids that share elements request the same copies.
    return inserted(wall, list(dict.fromkeys(insertions))), added, missing


def _insertion(line: Sequence[int], source: int, position: int, axis: int) -> Insertion | None:
    """Source and position in one row; None if the source or an anchor is a phantom."""
    first = min(max(position - 1, 0), max(len(line) - 2, 0))
    anchors = line[first : first + 2]
    if source < 0 or min(anchors) < 0:
        return None
    placement = Placement.BEFORE if position == 0 else Placement.AFTER if position == len(line) else Placement.BETWEEN
    if axis != X:
        # Rows count from the top, coordinates from the bottom.
        anchors = anchors[::-1]
        placement = {Placement.BEFORE: Placement.AFTER, Placement.AFTER: Placement.BEFORE}.get(placement, placement)
    return Insertion(source, anchors[0], anchors[-1], placement)


def _as_facade(before: Variation, wall: AxisView, tree: JoinedParts) -> tuple[Facade, Ints, Floats, Floats]:
    """A tree as a facade without grids, with the columns `source`, `target` and `visible` of `Variation`."""
    node, axis = np.where(tree.source >= 0, tree.source, 0), wall.along
    target = before.target[node].copy()
    target[:, axis] *= tree.visible[:, 1] - tree.visible[:, 0]
    target[:, axis] = stretched_targets(wall, tree, target[:, axis])
    target[:, 1 - axis] *= tree.scale
    part = np.tile(WHOLE, (len(node), 1))
    part[:, [axis, axis + 2]] = tree.visible
    visible = part_of(before.visible[node], part)
    source = np.where(tree.source == NEW, NEW, before.source[node])
    return take(before.facade, tree.parent, tree.axis, tree.source, target, part), source, target, visible


def _grids(wall: AxisView, edit: Edit, tree: JoinedParts, added: dict[str, Ints]) -> tuple[Grid, ...]:
    """The grids of the new tree: active ones with their new line, copies of subgrids, all others unchanged."""
    copies = np.flatnonzero(tree.fresh)
    copy_of = np.full(len(wall.facade), -1, dtype=np.int64)
    grids: list[Grid] = []
    for grid in wall.facade.grids:
        node, lines, cross = tree.new_node[grid.node], *_split(grid, edit.axis)
        if grid.name in added and edit.position is not None:
            new = np.flatnonzero(added[grid.name] >= 0)
            copy_of[tree.source[copies]] = copies
            node = np.append(node, copy_of[added[grid.name][new]])
            lines = np.append(lines + (lines >= edit.position), np.full(len(new), edit.position))
            cross = np.append(cross, new)
        grids += _compressed(grid.name, node, lines, cross, edit.axis)
    sources = np.concatenate([*added.values(), np.zeros(0, dtype=np.int64)])
    for source in sources[sources >= 0].tolist():
        begin = copy_of[source]
        for grid in wall.facade.grids:
            inside = grid.node[0] > source and grid.node[-1] < wall.end[source]
            if inside:
                name = unused(grid.name, [other.name for other in grids])
                grids.append(replace(grid, name=name, node=grid.node + (begin - source)))
    return tuple(grids)


def _split(grid: Grid, axis: int) -> tuple[Ints, Ints]:
    return (grid.column, grid.row) if axis == X else (grid.row, grid.column)


def _compressed(name: str, node: Ints, lines: Ints, cross: Ints, axis: int) -> list[Grid]:
    """The grid of the remaining nodes, without empty rows and columns; none if no node remains."""
    remaining = np.flatnonzero(node >= 0)
    if not remaining.size:
        return []
    remaining = remaining[np.argsort(node[remaining])]
    lines, cross = (np.unique(values[remaining], return_inverse=True)[1] for values in (lines, cross))
    row, column = (cross, lines) if axis == X else (lines, cross)
    return [Grid(name, node[remaining], row, column)]


def _lock_key(facade: Facade, lock: Wish) -> tuple[int, Wish]:
    """The label of a locked part, and its lock without the number of the node."""
    return int(facade.label[lock.node]), replace(lock, node=0)
