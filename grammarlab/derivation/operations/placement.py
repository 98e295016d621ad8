"""``set`` for the numbers that place a shape: ``scope.t``, ``scope.r``, ``scope.s``, ``pivot.p`` and ``pivot.o``."""

from __future__ import annotations

from grammarlab.derivation.calls.calls import Argument, BoundCall
from grammarlab.derivation.calls.pivots import pivot_position, with_pivot
from grammarlab.derivation.calls.texture_transfer import carried
from grammarlab.derivation.functions.shapes.attributes import turn_angles
from grammarlab.derivation.operations.scope import s
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.derivation.values.angles import euler

PLACEMENT = frozenset(
    f"{kind}{axis}" for kind in ("scope.t", "scope.r", "scope.s", "pivot.p", "pivot.o") for axis in "xyz"
)
"""The names of these numbers."""

_KEPT = Argument(1.0, relative=True)


def set_placement(call: BoundCall, name: str, argument: Argument) -> Shapes:
    """Shapes with one of the numbers changed and the others kept.

    The scope is placed relative to the pivot, so it moves and rotates with it.

    Args:
        call: the operation.
        name: one of `PLACEMENT`.
        argument: metres or degrees.
    """
    axis = "xyz".index(name[-1])
    if name.startswith("scope.s"):
        return s(call._replace(arguments=tuple(argument if other == axis else _KEPT for other in range(3))))
    return carried(call.shapes, _placed(call, name, axis, argument), call.workspace)


def _placed(call: BoundCall, name: str, axis: int, argument: Argument) -> Shapes:
    """Shapes moved or rotated, with their pivots or relative to them."""
    shapes, frames, value = call.shapes, call.workspace.frames, call.column(argument)
    pivot = pivot_position(shapes, call.workspace)
    if name.startswith("pivot.p"):
        initial = call.workspace.roots.frame[shapes.model]
        start = call.workspace.roots.position[shapes.model]
        offset = frames.to_local(initial, pivot - start)
        offset[:, axis] = value
        moved = start + frames.to_world(initial, offset)
        return with_pivot(
            shapes._replace(position=shapes.position + moved - pivot), moved, shapes.pivot, call.workspace
        )
    translation = frames.to_local(shapes.pivot, shapes.position - pivot)
    if name.startswith("scope.t"):
        translation[:, axis] = value
        return shapes._replace(position=pivot + frames.to_world(shapes.pivot, translation))
    reference = call.workspace.roots.frame[shapes.model] if name.startswith("pivot.o") else shapes.pivot
    turned = shapes.pivot if name.startswith("pivot.o") else shapes.frame
    angles = turn_angles(reference, turned, call.workspace)
    angles[:, axis] = value
    frame = frames.rotated(reference, euler(*angles.T))
    if name.startswith("scope.r"):
        return shapes._replace(frame=frame)
    scope = frames.rotations(shapes.pivot).swapaxes(1, 2) @ frames.rotations(shapes.frame)
    placed = shapes._replace(frame=frames.rotated(frame, scope), position=pivot + frames.to_world(frame, translation))
    return with_pivot(placed, pivot, frame, call.workspace)
