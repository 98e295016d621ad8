"""``convert``: a position or an orientation in another coordinate system of a shape."""

from __future__ import annotations

import numpy as np

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.calls.pivots import pivot_position
from grammarlab.derivation.state.shapes import Ids, Value, kind_of, number_column
from grammarlab.derivation.values.angles import Floats, euler, euler_angles
from grammarlab.errors import DerivationError
from grammarlab.language.vocabulary.keywords import KEYWORDS


def _convert(call: FunctionCall) -> Value:
    """``convert(axis, from, to, pos|orient, x, y, z)``: one coordinate in metres, or one angle in degrees."""
    axis, source, target, kind = (str(word) for word in call.arguments[:4])
    columns = [_number(call, value) for value in call.arguments[4:]]
    frames = call.workspace.frames
    origin, frame = _system(call, source)
    other_origin, other_frame = _system(call, target)
    if kind == "orient":
        turned = frames.rotations(frame) @ euler(*columns)
        angles = euler_angles(np.swapaxes(frames.rotations(other_frame), 1, 2) @ turned)
        return angles[:, "xyz".index(axis)]
    world = origin + frames.to_world(frame, np.stack(columns, axis=1))
    return frames.to_local(other_frame, world - other_origin)[:, "xyz".index(axis)]


def _number(call: FunctionCall, value: Value) -> Floats:
    if kind_of(value) == "string":
        raise DerivationError("convert expected a number, found a string", call.location)
    return number_column(value, call.shapes.num)


def _system(call: FunctionCall, name: str) -> tuple[Floats, Ids]:
    """Origin [N, 3], relative to the origin of positions, and frames [N] of a coordinate system of each shape."""
    shapes, workspace = call.shapes, call.workspace
    if name == "scope":
        return shapes.position, shapes.frame
    if name == "pivot":
        return pivot_position(shapes, workspace), shapes.pivot
    if name == "object":
        return workspace.roots.position[shapes.model], workspace.roots.frame[shapes.model]
    return -workspace.origins[shapes.model], np.zeros(shapes.num, dtype=np.int32)


_WORDS = frozenset().union(*(KEYWORDS[name] for name in ("axis", "system", "position_type")))

BUILTINS: dict[str, Builtin] = {"convert": Builtin(_convert, (7, 7), keywords=_WORDS)}
