"""``getTreeKey``: numbers of nodes among their siblings, as one shape makes them part by part."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.state.lineage import NO_PART, SiblingOrder
from grammarlab.language.grammar import Grammar
from tests.oracle import interpreter
from tests.oracle.blocks import BLOCKS, flat_parts
from tests.oracle.interpreter import interpret

RULES = """
Lot --> PRINT extrude(6) [ t(0, 1, 0) B ]
        comp(f) { front : split(x) { ~1 : A | { 1 : B [ A ] }* | 2 : C } | side : A B | top : C } B
A --> PRINT split(y) { '0.5 : Row | '0.5 : split(x) { ~1 : C | ~1 : D C }* }*
Row --> PRINT split(x) { { 2 : [ case scope.sy > 4 : B else : C D ] | 1 : E. }* } D
B --> PRINT s('0.5, '0.5, '0.5) C D
C --> PRINT NIL
D --> PRINT E.
"""


def keys_of_oracle(rules: str) -> Counter[str]:
    """Keys of all nodes with a rule, with their symbols, of a model derived shape by shape."""
    nodes = interpret(Grammar.parse(rules), 1, 0).nodes
    counts, keys = Counter[int](), list[str]()
    for node in nodes:
        above = keys[node.parent] if node.parent >= 0 else ""
        keys.append(f"{above}{counts[node.parent] if node.parent >= 0 else 0};")
        counts[node.parent] += 1
    return Counter(f"{key} {node.symbol}" for key, node in zip(keys, nodes, strict=True) if node.rule is not None)


def test_keys_are_those_of_a_derivation_shape_by_shape_and_part_by_part(monkeypatch):
    def divide(self, item, shape):
        pieces = sorted(BLOCKS[item.name](item, self._scope(shape)), key=lambda piece: piece.number)
        for piece in pieces:
            self.run(flat_parts(item)[piece.part].body, piece.shape)

    monkeypatch.setattr(interpreter._Branch, "_divide", divide)
    expected = keys_of_oracle(RULES.replace("PRINT ", ""))
    rules = "\n".join(
        line.replace("PRINT", f'print(getTreeKey + " {line.partition(" ")[0]}")') for line in RULES.splitlines()
    )
    assert len(expected) > 300
    assert Counter(derive(Grammar.parse(rules), 1, 1).prints) == expected
    twice = Counter(derive(Grammar.parse(rules), 2, 1, leaves=False).prints)
    assert twice == Counter(dict.fromkeys(expected, 2))


def test_the_key_of_a_shape_stays_the_same_in_its_rule():
    rules = "A --> print(getTreeKey) split(x) { 2 : B print(getTreeKey()) | 3 : C print(getTreeKey) }"
    assert derive(Grammar.parse(rules), 1, 1).prints == ("0;", "0;", "0;")


@pytest.mark.parametrize("asked_early", [False, True])
def test_keys_of_siblings_differ_however_late_they_come(asked_early):
    order = SiblingOrder()
    root = np.array([0], np.int32)
    order.add_nodes(np.array([-1], np.int32), NO_PART, 0)
    parts = order.add_parts(NO_PART, 1, np.array([1, 0]))
    order.add_nodes(root.repeat(2), parts, 1)
    order.add_nodes(root, NO_PART, 0)
    if asked_early:
        assert order.keys(np.array([1, 2, 3], np.int32)) == ["0;2;", "0;1;", "0;0;"]
    order.add_nodes(root, NO_PART, 2)
    assert order.keys(np.arange(5, dtype=np.int32)) == ["0;", "0;2;", "0;1;", "0;0;", "0;3;"]
