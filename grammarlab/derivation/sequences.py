"""Sequences of operations compiled to steps over columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, TypeAlias

from grammarlab.derivation.calls import Argument, BlockOperation, Call, Head, Operation
from grammarlab.derivation.choices import Branching, Code, route
from grammarlab.derivation.expressions import ExpressionCompiler
from grammarlab.derivation.operations import BLOCKS, OPERATIONS
from grammarlab.derivation.shapes import Shapes, child_keys, part_keys
from grammarlab.errors import DerivationError, Location
from grammarlab.language import syntax
from grammarlab.language.builtins import operations
from grammarlab.language.syntax import (
    Binary,
    Block,
    Expression,
    Floating,
    Group,
    Invoke,
    Item,
    Name,
    Part,
    Relative,
    Scoped,
)

if TYPE_CHECKING:
    from grammarlab.derivation.workspace import Workspace

Step: TypeAlias = "Callable[[Shapes, Shapes, Workspace], Shapes]"
"""From the current shapes, and those that the sequence began with, to the shapes that the next step goes on with."""


@dataclass(frozen=True, slots=True)
class Operations:
    """A compiled sequence."""

    steps: tuple[Step, ...]
    visible: bool
    """Whether what is left at its end is a visible shape: it has no successor, no block and no NIL."""
    rule: int = -1
    """Index of the rule branch it is, -1 for a sequence inside a rule."""

    def run(self, shapes: Shapes, workspace: Workspace) -> None:
        """Carry the sequence out on shapes [N]: record what becomes visible, queue what is to be rewritten."""
        current = shapes
        for step in self.steps:
            current = step(current, shapes, workspace)
        if self.visible:
            workspace.recorder.add_leaves(current)


@dataclass(frozen=True, slots=True)
class Successors:
    """What the symbols of a grammar lead to."""

    symbols: Mapping[str, int]
    """Number of each symbol."""
    rules: Mapping[tuple[str, int], int]
    """Number of the rule for a symbol and a number of arguments."""
    draws: Callable[[object], bool]
    """Whether anything random may happen in, or be derived from, a piece of the syntax tree."""


class SequenceCompiler:
    """Compiles the sequences of one branch of one rule, numbering its successors and blocks as it goes."""

    def __init__(self, expressions: ExpressionCompiler, successors: Successors) -> None:
        self._expressions = expressions
        self._successors = successors
        self._num_children = 0
        self._num_blocks = 0

    def sequence(self, sequence: syntax.Sequence, in_block: bool = False, rule: int = -1) -> Operations:
        """Code for a sequence; ``in_block`` tells whether one node may run it several times."""
        steps: list[Step] = []
        for item in sequence.items:
            if isinstance(item, Invoke) and item.name == "NIL":
                break
            steps.append(self._item(item, in_block))
        return Operations(tuple(steps), not _consumes(sequence), rule)

    def body(self, choice: syntax.Choice, in_block: bool) -> Branching[Operations]:
        """Code for a choice whose leaves are sequences."""

        def leaf(choice: syntax.Choice, path: tuple[int, ...]) -> Operations:
            if not isinstance(choice, syntax.Sequence):
                raise DerivationError("expected operations, found an expression", choice.location)
            return self.sequence(choice, in_block)

        return self._expressions.branching(choice, leaf)

    def _item(self, item: Item, in_block: bool) -> Step:
        match item:
            case Invoke() if item.name in OPERATIONS:
                return self._operation(OPERATIONS[item.name], item)
            case Invoke() if item.name in BLOCKS:
                return _refusal(f"{item.name} without a block", item.location)
            case Invoke() if item.name in operations() and not self._has_rule(item):
                return _refusal(f"the operation {item.name}", item.location)
            case Invoke():
                return self._successor(item, in_block)
            case Scoped():
                return _bracket(self.body(item.body, in_block))
            case Block() if item.name in BLOCKS:
                return self._block(BLOCKS[item.name], item)
        return _refusal(getattr(item, "name", type(item).__name__.lower()), item.location)

    def _has_rule(self, item: Invoke) -> bool:
        return (item.name, len(item.arguments)) in self._successors.rules

    def _operation(self, operation: Operation, item: Invoke) -> Step:
        codes = self._arguments(item.name, item.arguments, operation, item.location)
        name, location, apply = item.name, item.location, operation.apply

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            arguments = tuple([code(shapes, workspace) for code in codes])
            return apply(Call(name, shapes, arguments, origin, workspace, location))

        return step

    def _block(self, operation: BlockOperation, item: Block) -> Step:
        number = self._num_blocks
        self._num_blocks += 1
        codes = self._arguments(item.name, item.arguments, operation, item.location)
        parts = list(_flattened(item.group, item.group.repeated))
        heads = tuple(self._head(part, group, operation) for part, group in parts)
        draws = tuple(self._successors.draws(part.body) for part, _ in parts)
        bodies = tuple(self.body(part.body, in_block=True) for part, _ in parts)
        name, location, divide = item.name, item.location, operation.divide

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            arguments = tuple([code(shapes, workspace) for code in codes])
            call = Call(name, shapes, arguments, origin, workspace, location)
            made = divide(call, tuple([head(shapes, workspace) for head in heads]))
            for part, body, random in zip(made, bodies, draws, strict=True):
                if part.shapes.num:
                    key = part_keys(part.shapes.key, number, part.number) if random else None
                    inner = part.shapes if part.shapes.key is key else part.shapes._replace(key=key)
                    for sequence, _, taken in route(body, inner, workspace):
                        sequence.run(taken, workspace)
            return shapes

        return step

    def _successor(self, item: Invoke, in_block: bool) -> Step:
        child = self._num_children
        self._num_children += 1
        symbol = self._successors.symbols[item.name]
        arguments = tuple(self._expressions.expression(argument) for argument in item.arguments)
        rule = self._successors.rules.get((item.name, len(arguments)))
        if rule is None:
            return _leaf(symbol, child, in_block)
        draws = self._successors.draws(item)

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            values = tuple([argument(shapes, workspace) for argument in arguments])
            key = child_keys(shapes.key, child) if draws else None
            nodes = workspace.recorder.add_children(shapes, symbol, child, in_block)
            workspace.pending[rule].append(shapes.as_children(nodes, key, values))
            return shapes

        return step

    def _arguments(
        self, name: str, arguments: tuple[Expression, ...], operation: Operation | BlockOperation, location: Location
    ) -> tuple[Callable[[Shapes, Workspace], Argument], ...]:
        least, most = operation.num_arguments
        if not least <= len(arguments) <= most:
            wanted = str(least) if least == most else f"{least} to {most}"
            raise DerivationError(f"{name} expects {wanted} arguments, found {len(arguments)}", location)
        named = isinstance(operation, Operation) and operation.names_target
        return tuple(
            self._argument(argument, operation.keywords, named and place == 0)
            for place, argument in enumerate(arguments)
        )

    def _argument(
        self, node: Expression, keywords: frozenset[str], named: bool = False
    ) -> Callable[[Shapes, Workspace], Argument]:
        if isinstance(node, Name) and (named or node.identifier in keywords):
            word = Argument(node.identifier, keyword=True)
            return lambda shapes, workspace: word
        inner, prefixes = _without_prefixes(node)
        floating, relative = Floating in prefixes, Relative in prefixes
        code: Code = self._expressions.expression(inner)
        return lambda shapes, workspace: Argument(code(shapes, workspace), False, relative, floating)

    def _head(self, part: Part, group: int, operation: BlockOperation) -> Callable[[Shapes, Workspace], Head]:
        argument = self._argument(part.head, operation.selectors)
        joined = part.inclusive
        return lambda shapes, workspace: Head(argument(shapes, workspace), joined, group)


def _without_prefixes(node: Expression) -> tuple[Expression, frozenset[type]]:
    """A size without its ``~`` and ``'``, which stand in front but hold for all of it: ``~height - 0.3``."""
    if isinstance(node, Floating | Relative):
        inner, prefixes = _without_prefixes(node.operand)
        return inner, prefixes | {type(node)}
    if isinstance(node, Binary):
        left, prefixes = _without_prefixes(node.left)
        return (replace(node, left=left), prefixes) if prefixes else (node, prefixes)
    return node, frozenset()


def _bracket(body: Branching[Operations]) -> Step:
    def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
        for sequence, _, taken in route(body, shapes, workspace):
            current = taken
            for inner in sequence.steps:
                current = inner(current, taken, workspace)
        return shapes

    return step


def _leaf(symbol: int, child: int, in_block: bool) -> Step:
    def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
        nodes = workspace.recorder.add_children(shapes, symbol, child, in_block)
        workspace.recorder.add_leaves(shapes.as_children(nodes, None, ()))
        return shapes

    return step


def _refusal(name: str, location: Location) -> Step:
    """A step that fails when a shape comes to it: a rule file may hold what its models never use."""

    def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
        raise DerivationError(f"{name} is not supported", location, "`grammarlab check` lists everything that is not")

    return step


def _consumes(sequence: syntax.Sequence) -> bool:
    """Whether a sequence has a successor, a block or a NIL, so that the shape itself does not stay visible."""
    return _makes_shapes(sequence) or any(isinstance(i, Invoke) and i.name == "NIL" for i in sequence.items)


def _makes_shapes(sequence: syntax.Sequence) -> bool:
    for item in sequence.items:
        if isinstance(item, Block):
            return True
        if isinstance(item, Invoke) and item.name not in OPERATIONS and item.name != "NIL":
            return True
        if isinstance(item, Scoped):
            leaves = [leaf for leaf in syntax.alternatives(item.body) if isinstance(leaf, syntax.Sequence)]
            if any(_makes_shapes(leaf) for leaf in leaves):
                return True
    return False


def _flattened(group: Group, repeated: bool) -> Iterator[tuple[Part, int]]:
    """The parts of a block in the order of the text, each with the number of the repeated group it stands in."""
    counter = count()

    def walk(group: Group, number: int) -> Iterator[tuple[Part, int]]:
        for part in group.parts:
            if isinstance(part, Part):
                yield part, number
            elif part.repeated and number >= 0:
                raise DerivationError("a repeated group inside a repeated group is not supported", part.location)
            else:
                yield from walk(part, next(counter) if part.repeated else number)

    yield from walk(group, next(counter) if repeated else -1)
