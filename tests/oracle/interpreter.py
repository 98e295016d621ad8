"""The oracle: CGA for one model and one shape at a time, as plainly as it can be said.

`interpret` derives one model. It shares with the columnar engine the syntax tree and the hash behind the
random numbers; everything else is its own.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from grammarlab.errors import DerivationError
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Block, Choice, Invoke, Node, Rule, Scoped, Sequence, alternatives
from grammarlab.randomness import fold, root_keys
from tests.oracle.blocks import BLOCKS, Piece, flat_parts
from tests.oracle.expressions import Scope, choose, evaluate, with_variables
from tests.oracle.heavy import HEAVY as OPERATIONS
from tests.oracle.numbers import number_sites
from tests.oracle.operations import KEYWORDS, Argument, Call, argument
from tests.oracle.shape import Mesh, Shape, Value, initial_shape
from tests.oracle.streets import begun, carried

CHILD_LANE, BLOCK_LANE = 0, 1
MOST_NODES = 20_000
MOVES = {"center", "r", "rotate", "s", "scale", "t", "translate"}
NEW_GEOMETRY = {"i", "primitiveCube", "primitiveCylinder", "primitiveQuad"}
"""Operations after which nothing of a shape is of its lot."""


@dataclass
class NodeRecord:
    parent: int
    symbol: str
    child: int
    """Which successor of the parent's rule, through the text of its branch."""
    repeat: int
    """Which of the shapes that this successor made under this parent."""
    rule: tuple[str, int, tuple[int, ...]] | None = None
    """Name, number of parameters and branch of the rule that rewrote it; None for a leaf."""


@dataclass(frozen=True)
class LeafRecord:
    node: int
    polygons: list[np.ndarray]
    """World coordinates [corners, 3] of each face."""
    material: dict[str, float | str]


@dataclass(frozen=True)
class DrawRecord:
    node: int
    place: int
    """Number of the random expression among all places in the grammar."""
    value: float
    log_density: float


@dataclass
class Model:
    """One derivation, as far as it has come."""

    grammar: Grammar
    overrides: Mapping[str, Value]
    root: Shape
    assets: Callable[[str], Mesh]
    addresses: dict[int, int]
    nodes: list[NodeRecord] = field(default_factory=list)
    leaves: list[LeafRecord] = field(default_factory=list)
    draws: list[DrawRecord] = field(default_factory=list)
    reports: list[tuple[int, str, Value]] = field(default_factory=list)
    pending: list[tuple[Shape, Rule, dict[str, Value]]] = field(default_factory=list)
    repeats: Counter[tuple[int, int]] = field(default_factory=Counter)
    """How many shapes each successor, by number, has made so far under each node."""
    fruitful: set[int] = field(default_factory=set)
    """The nodes that made something, even if it was NIL."""
    _attribute_values: dict[str, Value] = field(default_factory=dict)

    @property
    def attribute_definitions(self):
        return self.grammar.attributes

    @property
    def functions(self):
        return self.grammar.functions

    def attribute(self, name: str) -> Value:
        """An attribute's value, evaluated once, on the initial shape."""
        if name in self.overrides:
            return self.overrides[name]
        if name not in self._attribute_values:
            definition = self.attribute_definitions[name]
            scope = with_variables(Scope(self, self.root), definition.variables)
            self._attribute_values[name] = evaluate(definition.value, scope)
        return self._attribute_values[name]

    def record_draw(self, shape: Shape, place: Node, value: float, log_density: float) -> None:
        self.draws.append(DrawRecord(shape.node, self.addresses[id(place)], value, log_density))

    def log_probability(self) -> float:
        return sum(draw.log_density for draw in self.draws)

    def grow(self, shape: Shape, invoke: Invoke, child: int, scope: Scope) -> None:
        """Make the child that a successor names; it waits for its rule, or is a leaf."""
        self.fruitful.add(shape.node)
        repeat = self.repeats[shape.node, child]
        self.repeats[shape.node, child] += 1
        self.nodes.append(NodeRecord(shape.node, invoke.name, child, repeat))
        if len(self.nodes) > MOST_NODES:
            raise DerivationError("more nodes than the oracle has patience for")
        grown = replace(shape, node=len(self.nodes) - 1, key=fold(shape.key, 3 * child + CHILD_LANE))
        rule = self.grammar.rules.get((invoke.name, len(invoke.arguments)))
        if rule is None:
            self.show(grown)
            return
        values = [evaluate(node, replace(scope, shape=shape)) for node in invoke.arguments]
        self.pending.append((grown, rule, dict(zip(rule.parameters, values, strict=True))))

    def show(self, shape: Shape) -> None:
        """Record a visible shape."""
        if shape.mesh.faces:
            self.leaves.append(LeafRecord(shape.node, shape.world_polygons(), shape.material))


def interpret(
    grammar: Grammar,
    seed: int,
    model: int,
    *,
    attributes: Mapping[str, Value] | None = None,
    start_rule: str | None = None,
    footprint: tuple[float, float] | np.ndarray = (20.0, 20.0),
    assets: Callable[[str], Mesh] | None = None,
    street_width: list[float] | None = None,
) -> Model:
    """Derive model number ``model`` of a seed."""
    key = root_keys(seed, np.array([model], dtype=np.uint64))
    root = begun(initial_shape(footprint, key), street_width)
    result = Model(grammar, attributes or {}, root, assets or _no_assets, number_sites(grammar.tree))
    start = start_rule or (grammar.start_rule.name if grammar.start_rule else "")
    result.nodes.append(NodeRecord(-1, start, 0, 0))
    for name in grammar.attributes:
        result.attribute(name)
    result.pending.append((root, grammar.rules[start, 0], {}))
    while result.pending:
        rewrite(result, *result.pending.pop())
    return result


def rewrite(model: Model, shape: Shape, rule: Rule, parameters: dict[str, Value]) -> None:
    """Carry out the rule of one shape."""
    parameters = with_variables(Scope(model, shape, parameters), rule.variables).parameters
    sequence, branch = choose(rule.body, Scope(model, shape, parameters))
    if sequence is None:
        return
    assert isinstance(sequence, Sequence)
    model.nodes[shape.node].rule = (rule.name, len(rule.parameters), branch)
    _Branch(model, parameters, sequence).run(sequence, shape, is_whole=True)


class _Branch:
    """Carries out one branch of one rule, whose successors and blocks are numbered through its text."""

    def __init__(self, model: Model, parameters: dict[str, Value], sequence: Sequence) -> None:
        self.model = model
        self.parameters = parameters
        self.child_numbers: dict[int, int] = {}
        self.block_numbers: dict[int, int] = {}
        self._number(sequence)

    def run(self, choice: Choice, shape: Shape, is_whole: bool = False) -> None:
        """Carry out a sequence, or the one that a choice comes to; a whole rule that made nothing shows its shape."""
        sequence, _ = choose(choice, self._scope(shape))
        if sequence is None:
            return
        assert isinstance(sequence, Sequence)
        current = shape
        for item in sequence.items:
            match item:
                case Invoke(name="NIL"):
                    self.model.fruitful.add(shape.node)
                case Invoke() if item.name in OPERATIONS:
                    current = self._operate(item, current, shape)
                case Invoke():
                    self.model.grow(current, item, self.child_numbers[id(item)], self._scope(current))
                case Scoped():
                    self.run(item.body, current)
                case Block():
                    self._divide(item, current)
                case _:
                    raise DerivationError(f"the oracle does not know {item}", item.location)
        if is_whole and shape.node not in self.model.fruitful:
            self.model.show(current)

    def _operate(self, item: Invoke, shape: Shape, began: Shape) -> Shape:
        scope = self._scope(shape)
        words = KEYWORDS.get(item.name, set())
        arguments = [argument(node, scope, words) for node in item.arguments]
        if item.name == "set":
            arguments = [Argument(getattr(item.arguments[0], "identifier", ""), word=True), arguments[1]]
        changed = OPERATIONS[item.name](Call(item.name, shape, arguments, began, scope, self.model.assets))
        if item.name in MOVES:
            return carried(shape, changed)
        return replace(changed, place=None) if item.name in NEW_GEOMETRY else changed

    def _divide(self, item: Block, shape: Shape) -> None:
        """Split the shape into parts and carry out what the block says for each, part by part of the text."""
        pieces: list[Piece] = BLOCKS[item.name](item, self._scope(shape))
        key = fold(shape.key, 3 * self.block_numbers[id(item)] + BLOCK_LANE)
        for place, part in enumerate(flat_parts(item)):
            for piece in pieces:
                if piece.part == place:
                    self.run(part.body, replace(piece.shape, key=fold(key, piece.number)))

    def _scope(self, shape: Shape) -> Scope:
        return Scope(self.model, shape, self.parameters)

    def _number(self, sequence: Sequence) -> None:
        for item in sequence.items:
            if isinstance(item, Invoke) and item.name != "NIL" and item.name not in OPERATIONS:
                self.child_numbers[id(item)] = len(self.child_numbers)
            if isinstance(item, Block):
                self.block_numbers[id(item)] = len(self.block_numbers)
            for inner in _inner_sequences(item):
                self._number(inner)


def _inner_sequences(item: object) -> list[Sequence]:
    """The sequences in the parts of a block or in a bracket, in the order of the text."""
    bodies = [part.body for part in flat_parts(item)] if isinstance(item, Block) else []
    if isinstance(item, Scoped):
        bodies = [item.body]
    return [leaf for body in bodies for leaf in alternatives(body) if isinstance(leaf, Sequence)]


def _no_assets(name: str) -> Mesh:
    raise DerivationError(f"no asset folder was given, so there is no {name}")
