"""Properties of shapes that nothing reads: a live-variable analysis of rules.

Trees, draws and reports depend on few properties of shapes: an operation may change only what leaves show, such as the
scope of a window. When no leaves are recorded, it is left out, and shapes of which only these properties would differ
have no geometry. A property is live before an operation if something later in its rule, or in a rule that is applied to
a later shape, may read it (Aho et al., Compilers, 2nd edition, 9.2.5). Sets of live properties only grow from rule to
rule, so that recursive rules end at the least fixed point.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from grammarlab.derivation.functions import BUILTINS, GEOMETRY_FREE, SHAPE_ATTRIBUTES
from grammarlab.derivation.functions.street_sides import OLDER_SELECTORS
from grammarlab.derivation.operations import OPERATIONS
from grammarlab.derivation.operations.insertion import OPERATIONS as INSERTING
from grammarlab.derivation.operations.roofing import OPERATIONS as ROOFING
from grammarlab.derivation.operations.split import AXES
from grammarlab.derivation.operations.texturing import OPERATIONS as TEXTURING
from grammarlab.geometry.selectors import SELECTORS
from grammarlab.language.call_order import groups
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import SymbolKey
from grammarlab.language.syntax.syntax_tree import (
    Block,
    Call,
    Case,
    Choice,
    Components,
    Expression,
    Group,
    Inline,
    Invoke,
    Item,
    Name,
    Node,
    Part,
    Rule,
    Scatter,
    Scoped,
    Sequence,
    Stochastic,
    walk,
)

Properties: TypeAlias = int
"""Set of properties of shapes that operations change and expressions read, one bit each."""
NONE: Properties = 0
_FORM: Properties = 1
"""Size of the scope, and the geometry within it."""
_PLACE: Properties = 2
"""Position and axes of the scope and of the pivot, and texture coordinates, which move with them. What reads these also
reads the form."""
_MATERIAL: Properties = 4
INDEX: Properties = 8
"""Index among the parts of the last split or ``comp``. No operation but these changes it, and no leaf shows it, so that
it is live whether or not leaves are recorded."""
SHOWN: Properties = _FORM | _PLACE | _MATERIAL
"""Everything that leaves show."""

_CHANGES: dict[str, Properties] = {
    **dict.fromkeys(("center", "r", "t", *TEXTURING), _PLACE),
    **dict.fromkeys(("extrude", "innerRect", "offset", "s", "scale", *ROOFING), _FORM | _PLACE),
    **dict.fromkeys(("color", "resetMaterial", "setMaterial", "texture"), _MATERIAL),
    **dict.fromkeys(INSERTING, SHOWN),
}
"""What operations change whose results depend on nothing else: form on form, place on form and place, material on
material. Other operations may read and change everything."""
_ACTING = frozenset({"label", "print", "report", "set"})
"""Operations that do more than change shapes."""
_PLAIN_SELECTORS = frozenset(word for word in SELECTORS if "." not in word) - OLDER_SELECTORS.keys()
"""Selectors of ``comp`` that depend on the form alone."""


@dataclass(frozen=True, slots=True)
class Liveness:
    """Live properties of the shapes of one grammar; all but `INDEX` hold only while no leaves are recorded."""

    functions: Mapping[SymbolKey, Properties]
    """What functions of the grammar read."""
    rules: Mapping[SymbolKey, Properties]
    """What is live at the beginning of rules."""
    acts: Callable[[Node], bool]
    """Whether evaluating a part of the syntax tree may draw or print."""
    attributes: Collection[str]
    """Attributes of the grammar, which ``set`` changes in place of properties of the same name."""
    trims: bool
    """Whether trim planes may cut what is inserted, so that its form depends on its position."""
    _dead: dict[int, tuple[bool, ...]] = field(default_factory=dict[int, tuple[bool, ...]])
    """Whether each item of a sequence is dead, by the identity of the sequence."""
    _parts: dict[int, Properties] = field(default_factory=dict[int, Properties])
    """What is live at the beginning of the body of a part of a block, by its identity."""

    @classmethod
    def of(
        cls,
        grammar: Grammar,
        calls: Mapping[SymbolKey, Collection[SymbolKey]],
        acts: Callable[[Node], bool],
        trims: bool,
    ) -> Liveness:
        """The least fixed point of a grammar.

        Args:
            grammar: the grammar.
            calls: the rules that each rule calls directly.
            acts: whether evaluating a part of the syntax tree may draw or print.
            trims: whether trim planes may cut what is inserted.
        """
        functions: dict[SymbolKey, Properties] = dict.fromkeys(grammar.functions, NONE)
        rules: dict[SymbolKey, Properties] = dict.fromkeys(grammar.rules, NONE)
        liveness = cls(functions, rules, acts, grammar.attributes.keys(), trims)
        _grow(functions, functions, lambda key: liveness.read_by(grammar.functions[key]))
        for group in groups(calls):
            is_recursive = len(group) > 1 or any(key in calls[key] for key in group)
            _grow(rules, group, lambda key: liveness._before_rule(grammar.rules[key]), repeats=is_recursive)
        return liveness

    def read_by(self, *nodes: Node) -> Properties:
        """Properties that expressions read, functions of the grammar included."""
        live = NONE
        for node in nodes:
            for inner in walk(node):
                live |= self._read_by(inner)
        return live

    def dead(self, sequence: Sequence) -> tuple[bool, ...]:
        """Whether each item of a sequence is an operation that changes nothing while no leaves are recorded.

        It can be left out, except for the draws and prints of its arguments.
        """
        return self._dead[id(sequence)]

    def part(self, body: Choice) -> Properties:
        """What is live at the beginning of the body of a part of a block."""
        return self._parts[id(body)]

    def _read_by(self, node: Node) -> Properties:
        if isinstance(node, Components):
            return SHOWN
        if not isinstance(node, Name | Call):
            return NONE
        name, arity = (node.identifier, 0) if isinstance(node, Name) else (node.function, len(node.arguments))
        if (name, arity) in self.functions:
            return self.functions[name, arity]
        if isinstance(node, Call) or name in BUILTINS:
            return NONE if name in GEOMETRY_FREE else SHOWN
        return _READ_BY_ATTRIBUTE.get(name, NONE)

    def _before_rule(self, rule: Rule) -> Properties:
        return self.read_by(*(variable.value for variable in rule.variables)) | self._before(rule.body)

    def _before(self, choice: Choice) -> Properties:
        """What is live before a choice whose results nobody reads."""
        match choice:
            case Case():
                read = self.read_by(*filter(None, choice.conditions))
                return _union(map(self._before, choice.branches), read)
            case Stochastic():
                read = self.read_by(*filter(None, choice.percentages))
                return _union(map(self._before, choice.branches), read)
            case Sequence():
                return self._before_sequence(choice)
            case _:
                return NONE

    def _before_part(self, body: Choice) -> Properties:
        self._parts[id(body)] = live = self._before(body)
        return live

    def _before_sequence(self, sequence: Sequence) -> Properties:
        live, dead = NONE, []
        for item in reversed(sequence.items):
            dead.append(self._is_dead(item, live))
            live |= self._read_by_dead(item) if dead[-1] else self._read_by_item(item)
        self._dead[id(sequence)] = tuple(reversed(dead))
        return live

    def _is_dead(self, item: Item, live: Properties) -> bool:
        """Whether an item changes nothing that is live after it, and does nothing else but evaluate its arguments."""
        if not isinstance(item, Invoke) or item.name not in OPERATIONS:
            return False
        if item.name in _ACTING:
            return not live & _MATERIAL and self._sets_material(item)
        return not live & _CHANGES.get(item.name, SHOWN)

    def _read_by_dead(self, item: Item) -> Properties:
        """What the arguments of an operation that is left out read: if they act, or if leaves are recorded."""
        read = self.read_by(*(item.arguments if isinstance(item, Invoke) else ()))
        return read if self.acts(item) else read & INDEX

    def _read_by_item(self, item: Item) -> Properties:
        match item:
            case Invoke() if item.name in OPERATIONS:
                return self._read_by_operation(item)
            case Invoke():
                key = item.name, len(item.arguments)
                if key not in self.rules:
                    return NONE
                return self.rules[key] | self.read_by(*item.arguments, *(item.overrides or ()))
            case Scoped():
                return self._before(item.body)
            case Block():
                return self._read_by_block(item)
            case Scatter() | Inline():
                arguments = item.arguments if isinstance(item, Scatter) else ()
                second = item.second if isinstance(item, Inline) else None
                read = self._before_part(second) if second is not None else NONE
                return SHOWN | self._before_part(item.body) | self.read_by(*arguments) | read

    def _read_by_operation(self, item: Invoke) -> Properties:
        if item.name == "set":
            return self.read_by(*item.arguments[1:]) | (SHOWN if _sets_placement(item) else NONE)
        read = self.read_by(*item.arguments)
        if item.name in _ACTING:
            return read
        is_local = item.name in _CHANGES and (item.name != "extrude" or len(item.arguments) == 1)
        if not is_local or (item.name in INSERTING and self.trims):
            return read | SHOWN
        return read

    def _sets_material(self, item: Invoke) -> bool:
        target = _target(item)
        return item.name == "set" and target.startswith("material.") and target not in self.attributes

    def _read_by_block(self, block: Block) -> Properties:
        parts = [*_parts(block.group), *(_parts(block.remainder) if block.remainder else ())]
        inner = _union((self._before_part(part.body) for part in parts), NONE)
        is_simple = _is_simple(block, [part.head for part in parts])
        read = self.read_by(
            *block.arguments, *(part.head for part in parts), *(part.depth for part in parts if part.depth)
        )
        return read | inner | (_FORM if is_simple else SHOWN)


_READ_BY_ATTRIBUTE = {
    **dict.fromkeys(SHAPE_ATTRIBUTES, SHOWN),
    **dict.fromkeys((name for name in SHAPE_ATTRIBUTES if name.startswith("material.")), _MATERIAL),
    **dict.fromkeys(("scope.sx", "scope.sy", "scope.sz"), _FORM),
    **dict.fromkeys(("split.index", "split.total", "comp.index", "comp.total", "comp.sel"), INDEX),
    **dict.fromkeys(("seedian", "uid"), NONE),
}
"""What each shape attribute depends on; those of initial shapes and trim planes count as reading everything."""


def _grow(
    live: dict[SymbolKey, Properties],
    keys: Collection[SymbolKey],
    update: Callable[[SymbolKey], Properties],
    *,
    repeats: bool = True,
) -> None:
    """Update entries, repeatedly until none changes if they depend on each other."""
    changes = True
    while changes:
        changes = False
        for key in keys:
            grown = live[key] | update(key)
            changes, live[key] = changes or (repeats and grown != live[key]), grown


def _union(sets: Iterable[Properties], start: Properties) -> Properties:
    for each in sets:
        start |= each
    return start


def _parts(group: Group) -> Iterator[Part]:
    for part in group.parts:
        yield from [part] if isinstance(part, Part) else _parts(part)


def _is_simple(block: Block, heads: Iterable[Expression]) -> bool:
    """Whether the number of parts depends on the form alone, and their properties on those of the shape in this way."""
    first = block.arguments[0] if block.arguments else None
    if block.name == "split":
        return isinstance(first, Name) and first.identifier in AXES
    return block.name == "comp" and all(
        isinstance(head, Name) and head.identifier in _PLAIN_SELECTORS for head in heads
    )


def _sets_placement(item: Invoke) -> bool:
    """Whether ``set`` may move, turn or scale the shape; a target that is not a name may be any number of it."""
    target = _target(item)
    return not target or target.startswith(("scope.", "pivot."))


def _target(item: Invoke) -> str:
    target = item.arguments[0] if item.arguments else None
    return target.identifier if isinstance(target, Name) else ""
