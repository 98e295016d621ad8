"""Small grammars, all their trees, and patterns counted by their definition."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

from hypothesis import strategies as st

from grammarlab.features.patterns.pattern import Below, Pattern


@dataclass(frozen=True)
class Tree:
    """A node of a derivation tree."""

    symbol: str
    branch: tuple[int, ...] | None
    children: tuple[tuple[int, Tree], ...] = ()
    """Each with its place in the text of the branch."""


Rules = dict[str, Any]
"""By symbol: a list of (percentage, body), or a tuple of successors; a body is again one of the two."""


def text_of(rules: Rules) -> str:
    """The rules as CGA; the first is the start rule."""
    return 'version "2023.0"\n\n' + "\n".join(f"{symbol} --> {_body_text(body)}" for symbol, body in rules.items())


def _body_text(body) -> str:
    if isinstance(body, list):
        return " ".join(
            f"{f'{percentage}%' if i < len(body) - 1 else 'else'} : {_body_text(inner)}"
            for i, (percentage, inner) in enumerate(body)
        )
    return " ".join(f"[ t(0, 1, 0) {name} ]" if i % 2 else name for i, name in enumerate(body)) or "NIL"


def all_trees(rules: Rules, symbol: str, depth: int = 12) -> list[tuple[float, Tree]]:
    """Every tree of a symbol that is not too deep, with its probability."""
    if symbol not in rules:
        return [(1.0, Tree(symbol, None))]
    if depth == 0:
        return []
    found = []
    for probability, branch, successors in _ends(rules[symbol], 1.0, ()):
        below = [all_trees(rules, successor, depth - 1) for successor in successors]
        for parts in product(*below):
            p = probability
            for part, _ in parts:
                p *= part
            found.append((p, Tree(symbol, branch, tuple((i, tree) for i, (_, tree) in enumerate(parts)))))
    return found


def _ends(body, probability, path):
    if isinstance(body, list):
        for i, (percentage, inner) in enumerate(body):
            yield from _ends(inner, probability * percentage / 100, (*path, i))
    elif probability:
        yield probability, path, body


def count(pattern: Pattern, tree: Tree) -> int:
    """Embeddings of a pattern in a tree."""
    return matches(pattern, tree) + sum(count(pattern, child) for _, child in tree.children)


def matches(pattern: Pattern, tree: Tree) -> int:
    """Embeddings whose top is the root."""
    if pattern.symbol not in (None, tree.symbol):
        return 0
    if pattern.branch is not None and (tree.branch is None or tree.branch[: len(pattern.branch)] != pattern.branch):
        return 0
    if pattern.parameters is not None and (tree.branch is None or pattern.parameters != 0):
        return 0
    result = 1
    for below in pattern.below:
        result *= sum(_runs(below, node) for node in (_nodes(tree) if below.deep else [tree]))
    return result


def _runs(below: Below, tree: Tree) -> int:
    total = 0
    for start in range(len(tree.children) - len(below.run) + 1):
        if below.child in (None, tree.children[start][0]):
            ways = 1
            for step, inner in enumerate(below.run):
                ways *= matches(inner, tree.children[start + step][1])
            total += ways
    return total


def _nodes(tree: Tree):
    yield tree
    for _, child in tree.children:
        yield from _nodes(child)


SYMBOLS = ("S", "A", "B", "C", "D")
LEAVES = ("x", "y")


def _percentages(number: int) -> st.SearchStrategy[list[int]]:
    cuts = st.lists(st.integers(1, 19), min_size=number - 1, max_size=number - 1, unique=True)
    return cuts.map(sorted).map(lambda c: [5 * (b - a) for a, b in zip([0, *c], [*c, 20], strict=True)])


def _choice(inner: st.SearchStrategy) -> st.SearchStrategy:
    return st.integers(2, 3).flatmap(
        lambda n: st.tuples(_percentages(n), st.lists(inner, min_size=n, max_size=n)).map(
            lambda pair: list(zip(*pair, strict=True))
        )
    )


@st.composite
def grammars(draw, recursive: bool = False) -> Rules:
    """Grammars with few trees: each symbol leads to later ones, or, at most once and not too likely, to itself."""
    rules: Rules = {}
    for i, symbol in enumerate(SYMBOLS):
        names = [*SYMBOLS[i + 1 : i + 3], *LEAVES]
        sequence = st.lists(st.sampled_from(names), min_size=i == 0, max_size=2 if i else 3).map(tuple)
        nested = st.one_of(sequence, sequence, _choice(sequence)) if i > 1 else sequence
        rules[symbol] = draw(_choice(nested) if i < 4 else st.one_of(sequence, _choice(sequence)))
        if recursive and i in (1, 2) and draw(st.booleans()):
            again = draw(st.permutations([symbol, draw(st.sampled_from(names))]))
            rules[symbol] = [(20, tuple(again)), (80, rules[symbol])]
    return rules


def patterns(depth: int = 2) -> st.SearchStrategy[Pattern]:
    """Patterns about the symbols of `grammars`."""
    label = st.tuples(st.sampled_from([*SYMBOLS, *LEAVES, None]), st.sampled_from([None, None, (), (0,), (1,), (1, 0)]))
    if depth == 0:
        return label.map(lambda pair: Pattern(pair[0], None, pair[1]))
    below = st.builds(
        Below,
        st.lists(patterns(depth - 1), min_size=1, max_size=2).map(tuple),
        st.sampled_from([None, None, 0, 1]),
        st.booleans(),
    )
    return st.tuples(label, st.lists(below, max_size=2)).map(
        lambda pair: Pattern(pair[0][0], None, pair[0][1], tuple(pair[1]))
    )
