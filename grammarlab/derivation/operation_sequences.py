"""Sequences of operations compiled to steps over columns."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import Literal, TypeAlias, cast

import numpy as np

from grammarlab.derivation.calls.arguments import NO_ARGUMENT, Constant, Late, all_values, argument, head, word
from grammarlab.derivation.calls.branches import Branching, Leaf, route
from grammarlab.derivation.calls.calls import Argument, BlockOperation, BoundCall, BoundPart, Head, Operation
from grammarlab.derivation.calls.inlining import (
    combined_shapes,
    derived_at_once,
    merged,
    row_name,
    with_attributes,
)
from grammarlab.derivation.calls.modifying import UNTOUCHED, RowNames, recomposed
from grammarlab.derivation.expressions import VOCABULARY, ExpressionCompiler
from grammarlab.derivation.liveness import INDEX, SHOWN, Liveness
from grammarlab.derivation.operations import BLOCKS, OPERATIONS
from grammarlab.derivation.state.lineage import NO_PART, PART
from grammarlab.derivation.state.shapes import Ids, Shapes, Value, child_keys, part_keys
from grammarlab.derivation.state.surroundings import visible
from grammarlab.derivation.state.workspace import Code, Workspace
from grammarlab.errors import DerivationError, Location
from grammarlab.language.numbering import RuleBranch
from grammarlab.language.syntax import syntax_tree as syntax
from grammarlab.language.syntax.builtins import blocks, operations
from grammarlab.language.syntax.syntax_tree import (
    Block,
    Expression,
    Group,
    Invoke,
    Item,
    Name,
    Node,
    Part,
    Scatter,
    Scoped,
)

Step: TypeAlias = "Callable[[Shapes, Shapes, Workspace], Shapes]"
"""A step: from the current shapes and the initial shapes of the sequence to the shapes for the next step."""

Shows: TypeAlias = Literal["all", "fruitless", "none"]


@dataclass(frozen=True, slots=True)
class Operations:
    """A compiled sequence."""

    steps: tuple[Step, ...]
    live_steps: tuple[Step, ...]
    """Those on which nodes, draws or reports depend: all that is carried out when no leaves are recorded."""
    shows: Shows
    """Which shapes are visible at its end: all, those for which it made nothing, or none."""
    rule: int = -1
    """Index of its rule branch, -1 for a sequence inside a rule."""

    def run(self, shapes: Shapes, workspace: Workspace) -> None:
        """Apply the sequence to shapes [N]: record visible shapes, queue shapes with rules."""
        recorder = workspace.recorder
        if self.shows == "fruitless" and recorder.has_leaves:
            shown = recorder.fruitless(lambda: self.applied(shapes, workspace))
        else:
            current = self.applied(shapes, workspace)
            shown = current if self.shows == "all" else None
        if shown is not None:
            recorder.add_leaves(shown)

    def applied(self, shapes: Shapes, workspace: Workspace) -> Shapes:
        """Shapes [N] after the last step; the caller decides whether they are visible."""
        current = shapes
        for step in self.steps if workspace.recorder.has_leaves else self.live_steps:
            current = step(current, shapes, workspace)
        return current


@dataclass(frozen=True, slots=True)
class Successors:
    """Symbols of a grammar and their rules."""

    symbols: Mapping[str, int]
    """Number of each symbol."""
    rules: Mapping[tuple[str, int], int]
    """Number of the rule for a symbol and a number of arguments."""
    draws: Callable[[Node], bool]
    """Whether a part of the syntax tree, or anything derived from it, may draw random numbers."""
    liveness: Liveness
    renewed: Callable[[Invoke], tuple[str, ...]]
    """Attributes that a call with new values of attributes evaluates again, in the order of their evaluation."""
    attributes: Container[str]
    """Names of the attributes and constants."""


def run_branches(body: Branching[Operations], shapes: Shapes, workspace: Workspace) -> None:
    """Apply to each shape the sequence that a choice selects."""
    if isinstance(body, Leaf):
        body.payload.run(shapes, workspace)
        return
    for sequence, _, chosen in route(body, shapes, workspace):
        sequence.run(chosen, workspace)


class SequenceCompiler:
    """Compiles the sequences of one branch of one rule."""

    def __init__(self, expressions: ExpressionCompiler, successors: Successors, branch: RuleBranch) -> None:
        self._expressions = expressions
        self._successors = successors
        # Both are visited in the order of their numbers in the branch.
        self._children = iter(enumerate(branch.successors))
        self._blocks = iter(range(len(branch.blocks)))
        self._num_children = 0
        """Number of successors that were compiled."""

    def sequence(
        self, sequence: syntax.Sequence, in_block: bool = False, rule: int = -1, is_part: bool = False
    ) -> Operations:
        """Code for a sequence.

        Args:
            sequence: the sequence.
            in_block: whether one node may run it several times.
            rule: index of its rule branch.
            is_part: whether its end is not the end of the shape of a node.
        """
        steps = tuple([self._item(item, in_block) for item in sequence.items])
        shows: Shows = "none" if is_part or _must_make(sequence) else "fruitless" if _may_make(sequence) else "all"
        return Operations(steps, tuple(self._live(sequence, steps)), shows, rule)

    def _live(self, sequence: syntax.Sequence, steps: Sequence[Step]) -> Iterator[Step]:
        """The steps on which nodes, draws or reports depend."""
        liveness = self._successors.liveness
        for item, step, is_dead in zip(sequence.items, steps, liveness.dead(sequence), strict=True):
            if not is_dead:
                yield step
            elif isinstance(item, Invoke) and liveness.acts(item):
                yield self._evaluation(item)

    def body(self, choice: syntax.Choice, in_block: bool, is_part: bool = True) -> Branching[Operations]:
        """Code for a choice whose leaves are sequences."""

        def leaf(choice: syntax.Choice, path: tuple[int, ...]) -> Operations:
            if not isinstance(choice, syntax.Sequence):
                raise DerivationError("expected operations, found an expression", choice.location)
            return self.sequence(choice, in_block, is_part=is_part)

        return self._expressions.branching(choice, leaf)

    def _item(self, item: Item, in_block: bool) -> Step:
        match item:
            case Invoke(name="NIL"):
                return _nothing
            case Invoke() if item.name in OPERATIONS:
                return self._operation(OPERATIONS[item.name], item)
            case Invoke() if item.name in BLOCKS:
                return _refusal(f"{item.name} without a block", item.location)
            case Invoke() if VOCABULARY.makes_shape(item, self._successors.rules):
                return self._successor(item, in_block)
            case Invoke():
                return _refusal(f"the operation {item.name}", item.location)
            case Scoped():
                return _bracket(self.body(item.body, in_block))
            case Block(name="modify"):
                return self._modify(BLOCKS["modify"], item)
            case Block() if item.name in BLOCKS:
                return self._block(BLOCKS[item.name], item)
            case Scatter():
                return self._scatter(BLOCKS["scatter"], item)
            case syntax.Inline():
                return self._inline(item) if item.operation == "inline" else self._combine(item)
        return _refusal(getattr(item, "name", type(item).__name__.lower()), item.location)

    def _operation(self, operation: Operation, item: Invoke) -> Step:
        arguments = all_values(self._arguments(item.name, item.arguments, operation, item.location))
        name, location, apply = item.name, item.location, operation.apply
        is_occluder = name == "offset"

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            if is_occluder and workspace.collector is not None:
                workspace.collector.add(visible(shapes))
            call = BoundCall(
                name=name,
                shapes=shapes,
                arguments=arguments(shapes, workspace),
                origin=origin,
                workspace=workspace,
                location=location,
            )
            return apply(call)

        return step

    def _evaluation(self, item: Invoke) -> Step:
        """Code that only evaluates the arguments of an operation, which draw or print."""
        arguments = all_values(self._arguments(item.name, item.arguments, OPERATIONS[item.name], item.location))

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            arguments(shapes, workspace)
            return shapes

        return step

    def _block(self, operation: BlockOperation, item: Block) -> Step:
        number = next(self._blocks)
        values = _per_edge(item) if item.name == "setbackPerEdge" else item.arguments
        arguments = all_values(self._arguments(item.name, values, operation, item.location))
        selectors = operation.selectors if item.remainder is None else frozenset[str]()
        parts = [(part, group, selectors) for part, group in _flattened(item.group, item.group.repeated)]
        if item.remainder is not None:
            parts += [(part, group, operation.selectors) for part, group in _flattened(item.remainder, False)]
        heads = all_values([head(self._expressions, part, group, words, number) for part, group, words in parts])
        return self._parted(item, item.name, number, operation, arguments, heads, [part.body for part, *_ in parts])

    def _scatter(self, operation: BlockOperation, item: Scatter) -> Step:
        """Code for ``scatter``, which has two blocks: the keys of the points, and the keys of their positions."""
        number, where = next(self._blocks), next(self._blocks)
        arguments = all_values(self._arguments("scatter", item.arguments, operation, item.location))
        heads = Constant((Head(argument=NO_ARGUMENT, block=where),))
        return self._parted(item, "scatter", number, operation, arguments, heads, [item.body])

    def _parted(
        self,
        item: Block | Scatter,
        name: str,
        number: int,
        operation: BlockOperation,
        arguments: Late[tuple[Argument, ...]],
        heads: Late[tuple[Head, ...]],
        choices: Sequence[syntax.Choice],
    ) -> Step:
        """Code that divides shapes into parts, and applies to the parts of each head its choice."""
        draws = tuple(self._successors.draws(choice) for choice in choices)
        first = self._num_children
        bodies = tuple(self.body(choice, in_block=True) for choice in choices)
        live = [self._successors.liveness.part(choice) for choice in choices]
        has_index = any(part & INDEX for part in live)
        bare = tuple([not part & SHOWN for part in live])
        location, divide = item.location, operation.divide
        is_occluder = name == "comp"

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            if is_occluder and workspace.collector is not None:
                workspace.collector.add(visible(shapes))
            bare_parts = () if workspace.recorder.has_leaves else bare
            values = arguments(shapes, workspace)
            call = BoundCall(
                name=name,
                shapes=shapes,
                arguments=values,
                origin=origin,
                workspace=workspace,
                location=location,
                has_index=has_index,
                bare=bare_parts,
            )
            parts = divide(call, heads(shapes, workspace))
            for part, body, random in zip(parts, bodies, draws, strict=True):
                if part.shapes.num:
                    key = part_keys(part.shapes.key, number, part.number) if random else None
                    inner = part.shapes if part.shapes.key is key else part.shapes._replace(key=key)
                    run_branches(body, _with_part(inner, first, part, workspace), workspace)
            return shapes

        return step

    def _modify(self, operation: BlockOperation, item: Block) -> Step:
        """Code for ``modify``: the components that its parts select are derived at once and put back into the shape."""
        number, location = next(self._blocks), item.location
        arguments = all_values(self._arguments("modify", item.arguments, operation, location))
        parts = [(part, group, operation.selectors) for part, group in _flattened(item.group, item.group.repeated)]
        heads = all_values([head(self._expressions, part, group, words, number) for part, group, words in parts])
        draws = tuple(self._successors.draws(part.body) for part, *_ in parts)
        first_child = self._num_children
        bodies = tuple(self.body(part.body, in_block=True) for part, *_ in parts)

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            call = BoundCall(
                name="modify",
                shapes=shapes,
                arguments=arguments(shapes, workspace),
                origin=origin,
                workspace=workspace,
                location=location,
            )
            bound = (*heads(shapes, workspace), UNTOUCHED)
            found: list[Shapes] = []

            def edit(marked: Shapes, workspace: Workspace) -> None:
                selected = operation.divide(call._replace(shapes=marked), bound)
                found.extend(part.shapes for part in selected)
                first = 0
                for part, body, random in zip(selected[:-1], bodies, draws, strict=True):
                    count = part.shapes.num
                    if count:
                        key = part_keys(part.shapes.key, number, part.number) if random else None
                        state = {
                            **part.shapes.state,
                            names.component: np.arange(first, first + count, dtype=np.float64),
                        }
                        inner = part.shapes._replace(key=key, state=state)
                        run_branches(body, _with_part(inner, first_child, part, workspace), workspace)
                    first += count

            names = RowNames(row_name(workspace), f"{row_name(workspace)}.component")
            leaves = derived_at_once(edit, shapes, workspace, location)
            return recomposed(shapes, found, leaves, names, call.words[0], workspace)

        return step

    def _inline(self, item: syntax.Inline) -> Step:
        """Code for ``inline``: the shapes of its body, derived at once, replace the current one."""
        body, location = self.body(item.body, in_block=True, is_part=False), item.location
        strategy = item.strategy or "append"

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            finished = derived_at_once(partial(run_branches, body), shapes, workspace, location)
            return merged(shapes, finished, strategy, workspace, location)

        return step

    def _combine(self, item: syntax.Inline) -> Step:
        """Code for ``union``, ``subtract`` and ``intersect``: of two bodies, or of the current shape and one."""
        if item.second is not None:
            return self._combine_bodies(item, item.second)
        body, location = self.body(item.body, in_block=True, is_part=False), item.location
        operation = cast("Literal['union', 'subtract', 'intersect']", item.operation)
        is_swapped = item.strategy == "swap"

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            leaves = derived_at_once(partial(run_branches, body), shapes, workspace, location)
            return combined_shapes(shapes, leaves, operation, is_swapped, workspace, location)

        return step

    def _combine_bodies(self, item: syntax.Inline, second: syntax.Sequence) -> Step:
        """Code for ``union { A | B }``: both operands are made of the current shape."""
        bodies = [self.body(body, in_block=True, is_part=False) for body in (item.body, second)]
        operation = cast("Literal['union', 'subtract', 'intersect']", item.operation)
        location = item.location

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            first, tool = [derived_at_once(partial(run_branches, body), shapes, workspace, location) for body in bodies]
            target = with_attributes(merged(shapes, first, "unify", workspace, location), first, workspace)
            return combined_shapes(target, tool, operation, False, workspace, location)

        return step

    def _successor(self, item: Invoke, in_block: bool) -> Step:
        child, successor = next(self._children)
        self._num_children = child + 1
        symbol = self._successors.symbols[item.name]
        arguments = tuple(self._expressions.expression(argument) for argument in item.arguments)
        overrides = self._overrides(item)
        rule = self._successors.rules.get(successor.key)
        if rule is None:
            return _leaf(symbol, child, in_block)
        draws = self._successors.draws(item)
        renewed = self._successors.renewed(item) if item.overrides is not None else ()

        def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
            values = tuple([argument(shapes, workspace) for argument in arguments])
            key = child_keys(shapes.key, child) if draws else None
            nodes = workspace.recorder.add_children(shapes, symbol, child, in_block)
            made = shapes.as_children(nodes, key, values)
            if workspace.recorder.siblings is not None:
                made = made._replace(state={**made.state, PART: NO_PART})
            if item.overrides is not None:
                values_at_call = {name: code(shapes, workspace) for name, code in overrides.items()}
                made = _reinitialised(made, item, values_at_call, renewed, workspace)
            workspace.pending[rule].append(made)
            return shapes

        return step

    def _overrides(self, item: Invoke) -> dict[str, Code]:
        """Values of attributes of an imported file for one shape: ``plant(height = 3).Generate``.

        Names that the file has no attribute of are left out: nothing can read them.
        """
        overrides: dict[str, Code] = {}
        for node in item.overrides or ():
            if not isinstance(node, syntax.Attribute):
                raise DerivationError("a rule cannot be redefined at the call of an imported rule", node.location)
            name, code = override_name(item, node), self._expressions.choice(node.value)
            if name in self._successors.attributes:
                overrides[name] = code
        return overrides

    def _arguments(
        self, name: str, arguments: tuple[Expression, ...], operation: Operation | BlockOperation, location: Location
    ) -> tuple[Late[Argument], ...]:
        least, most = operation.num_arguments
        if not least <= len(arguments) <= most:
            counts = str(least) if least == most else f"{least} to {most}"
            raise DerivationError(f"{name} expects {counts} arguments, found {len(arguments)}", location)
        if isinstance(operation, Operation) and operation.names_target:
            return self._target(arguments[0]), argument(self._expressions, arguments[1], frozenset())
        # CGA distinguishes keywords from values by their place: extrude(x) is a height, extrude(x, 3) a direction.
        forms = [form for form in (*operations().get(name, ()), *blocks().get(name, ())) if form.takes(len(arguments))]
        words = [frozenset[str]().union(*(f.parameters[i].keywords for f in forms)) for i in range(len(arguments))]
        for node, possible in zip(arguments, words, strict=True):
            if word(node) in possible - operation.keywords:
                return (_failure(f"{name} with {word(node)} is not supported", node.location),)
        return tuple(
            argument(self._expressions, node, possible) for node, possible in zip(arguments, words, strict=True)
        )

    def _target(self, node: Expression) -> Late[Argument]:
        """Name of the attribute that ``set`` changes: a name, or a text in ``sel``."""
        if isinstance(node, Name):
            return Constant(Argument(node.identifier, keyword=True))
        return argument(self._expressions, node, frozenset())


def _per_edge(item: Block) -> tuple[Expression, ...]:
    """Arguments of ``setbackPerEdge``: those of a ``setback`` by ``comp(fe) { all : distance }``."""
    first = item.arguments[0]
    if isinstance(first, syntax.Relative):
        first = first.operand
    edges = (Name("fe", location=first.location),)
    part = Part(Name("all", location=first.location), first, location=first.location)
    return (syntax.Components(edges, (part,), location=first.location), *item.arguments[1:])


def override_name(item: Invoke, attribute: syntax.Attribute) -> str:
    """Full name of an attribute of the file that an imported rule is in."""
    return f"{item.name.rpartition('.')[0]}.{attribute.name}"


def _reinitialised(
    shapes: Shapes, item: Invoke, values: Mapping[str, Value], renewed: Sequence[str], workspace: Workspace
) -> Shapes:
    """Shapes [N] with the attributes of an imported file as a call of one of its rules redefines them.

    All attributes of the file have their values before any rule again, except for those redefined at the call and those
    computed from them, which are evaluated once more on the initial shape. Their random parts are those of the model;
    only the draws that no evaluation made before are recorded.
    """
    prefix = f"{item.name.rpartition('.')[0]}."
    roots = workspace.roots.take(shapes.model)
    first = {name: value for name, value in roots.state.items() if name.startswith(prefix)}
    state = {**shapes.state, **first, **values}
    with workspace.recorder.without_repeats():
        for name in renewed:
            initial = roots._replace(state={**roots.state, **state})
            state[name] = workspace.attributes[name].code(initial, workspace)
    return shapes._replace(state=state)


def _with_part(shapes: Shapes, first: int, part: BoundPart, workspace: Workspace) -> Shapes:
    """Shapes [N] of a part that remember it, if rules ask for places among siblings.

    Args:
        shapes: the shapes of the part.
        first: number of the first successor in the block.
        part: the part.
        workspace: the workspace.
    """
    siblings = workspace.recorder.siblings
    if siblings is None:
        return shapes
    ids = siblings.add_parts(cast("Ids | int", shapes.state[PART]), first, part.number)
    return shapes._replace(state={**shapes.state, PART: ids})


def _bracket(body: Branching[Operations]) -> Step:
    def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
        for sequence, _, chosen in route(body, shapes, workspace):
            sequence.applied(chosen, workspace)
        return shapes

    return step


def _nothing(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
    """``NIL``: a child that is nothing, so that the shape itself is not visible."""
    workspace.recorder.add_nothing(shapes)
    return shapes


def _leaf(symbol: int, child: int, in_block: bool) -> Step:
    def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
        nodes = workspace.recorder.add_children(shapes, symbol, child, in_block)
        workspace.recorder.add_leaves(shapes.as_children(nodes, None, ()))
        return shapes

    return step


def _failure(message: str, location: Location) -> Callable[[Shapes, Workspace], Argument]:
    """An argument that raises an error when it is evaluated: a rule file may contain errors in unused parts."""

    def evaluate(shapes: Shapes, workspace: Workspace) -> Argument:
        raise DerivationError(message, location, "`grammarlab check` lists all unsupported features")

    return evaluate


def _refusal(name: str, location: Location) -> Step:
    """A step that raises an error when a shape reaches it: a rule file may contain errors in unused parts."""

    def step(shapes: Shapes, origin: Shapes, workspace: Workspace) -> Shapes:
        raise DerivationError(f"{name} is not supported", location, "`grammarlab check` lists all unsupported features")

    return step


def _must_make(sequence: syntax.Sequence) -> bool:
    """Whether a sequence gives every shape a child, or none by NIL."""
    return any(
        _makes(item) or (isinstance(item, Scoped) and isinstance(item.body, syntax.Sequence) and _must_make(item.body))
        for item in sequence.items
    )


def _may_make(sequence: syntax.Sequence) -> bool:
    """Whether a sequence gives some shapes children, or none by NIL: a block does if it has parts."""
    for item in sequence.items:
        if (isinstance(item, Block | Scatter) and getattr(item, "name", "") != "modify") or _makes(item):
            return True
        if isinstance(item, Scoped):
            leaves = [leaf for leaf in syntax.alternatives(item.body) if isinstance(leaf, syntax.Sequence)]
            if any(_may_make(leaf) for leaf in leaves):
                return True
    return False


def _makes(item: Item) -> bool:
    return isinstance(item, Invoke) and item.name not in OPERATIONS


def _flattened(group: Group, repeated: bool) -> Iterator[tuple[Part, int]]:
    """Parts of a block in the order of the text, each with the number of its repeated group.

    A repeated group inside a repeated group occurs once per repeat of the outer one, which fills the available length.
    """
    counter = count()

    def walk(group: Group, number: int) -> Iterator[tuple[Part, int]]:
        for part in group.parts:
            if isinstance(part, Part):
                yield part, number
            else:
                yield from walk(part, next(counter) if part.repeated and number < 0 else number)

    yield from walk(group, next(counter) if repeated else -1)
