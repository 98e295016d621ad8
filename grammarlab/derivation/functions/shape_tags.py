"""Functions of tags: ``geometry.tags``, ``geometry.hasTags``, and ``isTagged`` of a component."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.state.array_table import Table, table_of
from grammarlab.derivation.state.face_tags import sets_of_shapes
from grammarlab.derivation.state.shapes import Value, kind_of
from grammarlab.derivation.state.tag_table import Names, TagTable, matches
from grammarlab.errors import DerivationError

COMPONENT_TAGS = "component.tags"
"""Entry of `Shapes.state` with the set of tags of each component, while ``comp`` evaluates a condition on it. With
``.e`` and ``.v`` behind it: of what shares an edge or a corner with it."""


def _tags(call: FunctionCall) -> Value:
    def listed(names: Names) -> Table:
        return table_of("string", 1, len(names), names, call.location)

    ids, table, query = _sets(call), _table(call), _query(call)
    different, inverse = np.unique(ids, return_inverse=True)
    kept = [tuple(name for name in table[number] if query(name)) for number in different.tolist()]
    return call.workspace.tables.ids([listed(names) for names in kept])[inverse]


def _has_tags(call: FunctionCall) -> Value:
    return _any(call, _sets(call))


def _is_tagged(call: FunctionCall) -> Value:
    part = f".{call.arguments[1]}" if len(call.arguments) > 1 else ""
    ids = call.shapes.state.get(COMPONENT_TAGS + part)
    return _any(call, _sets(call) if ids is None else np.asarray(ids))


def _any(call: FunctionCall, ids: NDArray[np.integer]) -> NDArray[np.bool_]:
    """[N] whether the query selects a tag of sets [N]."""
    table, query = _table(call), _query(call)
    different, inverse = np.unique(ids, return_inverse=True)
    return np.array([any(map(query, table[number])) for number in different.tolist()], dtype=bool)[inverse]


def _sets(call: FunctionCall) -> NDArray[np.int32]:
    return sets_of_shapes(call.shapes, call.workspace, _table(call))


def _table(call: FunctionCall) -> TagTable:
    table = call.workspace.tags
    if table is None:
        raise DerivationError(f"{call.name} needs a grammar that was compiled with tags", call.location)
    return table


def _query(call: FunctionCall) -> Callable[[str], bool]:
    """Whether the first argument, if there is one, selects a tag."""
    if not call.arguments:
        return lambda tag: True
    query = call.arguments[0]
    if isinstance(query, np.ndarray) and query.dtype.kind == "i" and len(set(query.tolist())) == 1:
        query = call.workspace.strings[int(query[0])]
    if not isinstance(query, str):
        found = "several different ones" if kind_of(query) == "string" else f"a {kind_of(query)}"
        raise DerivationError(f"{call.name} expects one string for all shapes, found {found}", call.location)
    return lambda tag: matches(query, tag)


_FACES = frozenset({"all", "faces"})

BUILTINS: dict[str, Builtin] = {
    "geometry.hasTags": Builtin(_has_tags, (0, 2), keywords=_FACES),
    "geometry.tags": Builtin(_tags, (0, 2), keywords=_FACES),
    "isTagged": Builtin(_is_tagged, (1, 2), keywords=frozenset({"e", "v"})),
}
