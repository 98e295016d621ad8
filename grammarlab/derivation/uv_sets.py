"""Sets of texture coordinates that a grammar uses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from grammarlab.derivation.functions.shape_textures import BUILTINS
from grammarlab.derivation.operations.texturing import OPERATIONS
from grammarlab.derivation.state.texture_maps import NUM_SETS
from grammarlab.language.syntax.syntax_tree import Block, Call, Expression, Invoke, Name, Node, Number


def mentioned_uv_sets(nodes: Iterable[Node]) -> frozenset[int]:
    """Sets that operations and expressions of a rule file use; all sets if the number of one is computed."""
    mentioned = [_set_of(expression) for node in nodes for expression in _expressions(node)]
    return frozenset().union(*mentioned)


def _expressions(node: Node) -> Iterator[Expression | None]:
    """Argument of a node that names a uv set; None for the first set, which is the default."""
    match node:
        case Invoke() if node.name in OPERATIONS:
            yield from node.arguments[: 2 if node.name == "copyUV" else 1]
        case Block(name="split", arguments=(_, _, uv_set)):
            yield uv_set
        case Call() if node.function in BUILTINS:
            yield node.arguments[0] if node.arguments else None
        case Name() if node.identifier in BUILTINS:
            yield None
        case _:
            pass


def _set_of(expression: Expression | None) -> frozenset[int]:
    if expression is None:
        return frozenset({0})
    if isinstance(expression, Number):
        return frozenset(uv_set for uv_set in range(NUM_SETS) if uv_set == expression.value)
    return frozenset(range(NUM_SETS))
