"""``tag`` and ``deleteTags``: names of the faces of shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.state.face_tags import with_changed_tags
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.derivation.state.tag_table import Names, matches

_WILDCARDS = str.maketrans("", "", "?*")


def tag(call: BoundCall) -> Shapes:
    """``tag(name)`` or ``tag(name, faces)``: every face also has this tag; a dot divides it into subtags."""

    def named(name: str) -> Callable[[Names], Iterable[str]]:
        plain = name.translate(_WILDCARDS)
        if plain != name:
            call.warn(f'a tag has no wildcards, found "{name}"; the tag is "{plain}"')
        return lambda names: (*names, plain) if plain else names

    return _by_text(call, named)


def delete_tags(call: BoundCall) -> Shapes:
    """``deleteTags()``, ``deleteTags(query)`` or ``deleteTags(query, all|faces)``: tags of all faces removed."""

    def without(query: str) -> Callable[[Names], Iterable[str]]:
        return lambda names: [name for name in names if not matches(query, name)]

    if not call.values:
        return with_changed_tags(call.shapes, call.workspace, lambda names: ())
    return _by_text(call, without)


def _by_text(call: BoundCall, change: Callable[[str], Callable[[Names], Iterable[str]]]) -> Shapes:
    """Shapes whose tags change by what ``change`` makes of the text of each."""
    text, shapes, workspace = call.text(call.values[0]), call.shapes, call.workspace
    if isinstance(text, str):
        return with_changed_tags(shapes, workspace, change(text))
    mesh = shapes.mesh.copy()
    for code in np.unique(text).tolist():
        rows = np.flatnonzero(text == code)
        mesh[rows] = with_changed_tags(shapes.take(rows), workspace, change(workspace.strings[code])).mesh
    return shapes._replace(mesh=mesh)


OPERATIONS: dict[str, Operation] = {
    "deleteTags": Operation(delete_tags, frozenset({"all", "faces"}), (0, 2)),
    "tag": Operation(tag, frozenset({"auto", "faces"}), (1, 2)),
}
