"""Numbering of a grammar: the branches of its rules, their successors and blocks, and its random places.

Engine, densities and reports share it, so that number 3 is the same place of the text in all of them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from grammarlab.errors import Location
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.builtins import operations
from grammarlab.language.syntax.syntax_tree import (
    Block,
    Call,
    Case,
    Choice,
    Definition,
    Group,
    Import,
    Inline,
    Invoke,
    Item,
    Name,
    Node,
    Numbered,
    Part,
    Rule,
    Scatter,
    Scoped,
    Sequence,
    Stochastic,
    walk,
)

SymbolKey: TypeAlias = tuple[str, int]
"""A symbol with its number of arguments: rules of one name may differ in it."""
Branch: TypeAlias = tuple[int, ...]
"""Index of the branch at each level of a rule's choices, from the top; empty if the rule has no choice."""


@dataclass(frozen=True, slots=True)
class EngineWords:
    """Operations and functions of an engine; other words in the place of operations are symbols."""

    operations: frozenset[str]
    """Operations without a block."""
    blocks: frozenset[str]
    """Operations with a block."""
    draws: frozenset[str]
    """Functions that draw random numbers."""

    def is_symbol(self, name: str) -> bool:
        """Whether a word in the place of an operation is not an operation of the engine."""
        return name not in self.operations and name not in self.blocks and name != "NIL"

    def makes_shape(self, item: Invoke, rules: Collection[SymbolKey]) -> bool:
        """Whether an item of a sequence is a successor.

        Args:
            item: the item.
            rules: the symbols with rules; they may have the name of an operation that the engine lacks.
        """
        return self.is_symbol(item.name) and (
            item.name not in operations() or (item.name, len(item.arguments)) in rules
        )


@dataclass(frozen=True, slots=True)
class Successor:
    """A symbol in the text of a branch."""

    key: SymbolKey
    location: Location
    """Position of its name in the rule file."""
    copies: int | None
    """Number of shapes that it makes each time the branch is applied and no part is empty; None if it varies."""
    certain: bool
    """Whether exactly `copies` shapes are made each time; False inside blocks, where an empty part makes no shape."""


@dataclass(frozen=True, slots=True)
class RuleBranch:
    """One way to rewrite a symbol: a leaf of the case and stochastic tree of a rule."""

    key: SymbolKey
    branch: Branch
    location: Location
    successors: tuple[Successor, ...]
    """Successors in the order of the text; the index of each is `Nodes.child` of its shapes."""
    blocks: tuple[Location, ...]
    """Blocks in the order of the text; the index of each is its number; ``scatter`` counts as two."""


@dataclass(frozen=True, slots=True)
class RandomPlace:
    """A random place: a list of ``N%`` branches, or a call of a function that draws."""

    node: Numbered
    definition: Definition
    """Definition that contains it."""

    @property
    def owner(self) -> str:
        """Name of the rule, function or attribute that contains it."""
        return self.definition.alias if isinstance(self.definition, Import) else self.definition.name


@dataclass(frozen=True, slots=True)
class Numbering:
    """Symbols, branches and random places of a grammar; the index of each is its number."""

    symbols: tuple[str, ...]
    """Symbols with rules first, then the others, each in the order of the text."""
    branches: tuple[RuleBranch, ...]
    """Branches rule by rule, each from left to right."""
    random_places: tuple[RandomPlace, ...]
    """Random places in the order of the tree."""
    nodes: tuple[tuple[Node, ...], ...]
    """The nodes of each definition of the file, in the order of the tree."""

    @classmethod
    def of(cls, grammar: Grammar, vocabulary: EngineWords) -> Numbering:
        """Numbering of a grammar.

        Args:
            grammar: the grammar.
            vocabulary: operations and functions of the engine.
        """
        definitions = grammar.tree.definitions
        nodes = tuple(tuple(walk(definition)) for definition in definitions)
        defined = grammar.attributes.keys() | {name for name, _ in grammar.functions}
        random_places = tuple(
            RandomPlace(node, definition)
            for definition, inside in zip(definitions, nodes, strict=True)
            for node in inside
            if isinstance(node, Numbered)
            and (
                isinstance(node, Stochastic)
                or ((name := function_name(node)) in vocabulary.draws and name not in defined)
            )
        )
        ruled = [definition.name for definition in definitions if isinstance(definition, Rule)]
        invoked = [node.name for inside in nodes for node in inside if isinstance(node, Invoke)]
        symbols = dict.fromkeys([*ruled, *filter(vocabulary.is_symbol, invoked)])
        return cls(tuple(symbols), number_branches(grammar, vocabulary), random_places, nodes)


def number_branches(grammar: Grammar, vocabulary: EngineWords) -> tuple[RuleBranch, ...]:
    """Branches of a grammar's rules as in its `Numbering`, without reading the rest of its tree."""
    branches: list[RuleBranch] = []
    for key, rule in grammar.rules.items():
        for path, leaf in _leaves(rule.body):
            reader = _Reader(leaf, vocabulary, grammar.rules)
            branches.append(RuleBranch(key, path, leaf.location, tuple(reader.successors), tuple(reader.blocks)))
    return tuple(branches)


def function_name(node: Node) -> str:
    """Name of the function that a node calls, with or without parentheses; empty for other nodes."""
    return node.function if isinstance(node, Call) else node.identifier if isinstance(node, Name) else ""


def _leaves(choice: Choice, path: Branch = ()) -> Iterator[tuple[Branch, Choice]]:
    if isinstance(choice, Case | Stochastic):
        for i, branch in enumerate(choice.branches):
            yield from _leaves(branch, (*path, i))
    else:
        yield path, choice


class _Reader:
    """Reads the successors and blocks of a branch."""

    def __init__(self, leaf: Choice, vocabulary: EngineWords, rules: Collection[SymbolKey]) -> None:
        self._vocabulary = vocabulary
        self._rules = rules
        self.successors: list[Successor] = []
        self.blocks: list[Location] = []
        self._choice(leaf, 1, True)

    def _choice(self, choice: Choice, copies: int | None, certain: bool) -> None:
        if isinstance(choice, Case | Stochastic):
            for branch in choice.branches:
                self._choice(branch, None, False)
        elif isinstance(choice, Sequence):
            for item in choice.items:
                self._item(item, copies, certain)

    def _item(self, item: Item, copies: int | None, certain: bool) -> None:
        if isinstance(item, Invoke):
            if self._vocabulary.makes_shape(item, self._rules):
                self.successors.append(Successor((item.name, len(item.arguments)), item.location, copies, certain))
        elif isinstance(item, Scoped):
            self._choice(item.body, copies, certain)
        elif isinstance(item, Block) and item.name in self._vocabulary.blocks:
            self.blocks.append(item.location)
            for part, repeated in _parts(item.group, item.group.repeated):
                single = item.name == "split" and not repeated
                self._choice(part.body, copies if single else None, False)
            for part, _ in _parts(item.remainder, False) if item.remainder else ():
                self._choice(part.body, None, False)
        elif isinstance(item, Inline):
            self._choice(item.body, None, False)
            if item.second is not None:
                self._choice(item.second, None, False)
        elif isinstance(item, Scatter):
            self.blocks += [item.location, item.location]
            self._choice(item.body, None, False)


def _parts(group: Group, repeated: bool) -> Iterator[tuple[Part, bool]]:
    """The parts of a block in the order of the text, and whether each stands in a repeated group."""
    for part in group.parts:
        if isinstance(part, Part):
            yield part, repeated
        else:
            yield from _parts(part, repeated or part.repeated)
