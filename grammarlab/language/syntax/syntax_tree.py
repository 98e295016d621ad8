"""Syntax tree of a rule file, shared by the parser, the checker and the derivation; iteration over its nodes.

Every node is frozen and has its location in the text. Equality ignores locations, so trees of equal content are
equal.

A *choice* is a leaf, a ``case`` or an ``N%`` list, nested to any depth. The leaves are expressions in
attributes, constants and functions, and sequences of operations in rules and blocks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, Literal, TypeAlias

from grammarlab.errors import Location

TRIM_SWITCHES = frozenset({"trim.vertical", "trim.horizontal"})
"""Names of shape attributes that say whether trim planes apply."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """Base class of all nodes."""

    location: Location = field(default=Location(), compare=False, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Numbered(Node):
    """A node with a possible random draw or call."""

    number: int = field(default=-1, compare=False, repr=False)
    """Index among these nodes in the order of the tree of a whole `Grammar`: the address of its draws."""


# Expressions -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Number(Node):
    value: float


@dataclass(frozen=True, slots=True)
class String(Node):
    value: str
    """The text between the quotes, escapes resolved."""


@dataclass(frozen=True, slots=True)
class Boolean(Node):
    value: bool


@dataclass(frozen=True, slots=True)
class Name(Numbered):
    """An identifier, dots included: ``height``, ``scope.sx``, ``lib.colour``, ``world.up``, ``top``."""

    identifier: str


@dataclass(frozen=True, slots=True)
class Call(Numbered):
    """A function call; ``function`` may be dotted (``geometry.area``, ``lib.height``)."""

    function: str
    arguments: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Unary(Node):
    operator: Literal["-", "+", "!", ".-", ".+", ".!"]
    """Unary operator; with a leading dot it is applied element by element to an array."""
    operand: Expression


# fmt: off
BinaryOperator: TypeAlias = Literal[
    "+", "-", "*", "/", "%", "==", "!=", "<", "<=", ">", ">=", "&&", "||",
    ".+", ".-", ".*", "./", ".%", ".==", ".!=", ".<", ".<=", ".>", ".>=", ".&&", ".||",
]
# fmt: on
"""Binary operator; with a leading dot it is applied element by element to arrays."""


@dataclass(frozen=True, slots=True)
class Binary(Node):
    operator: BinaryOperator
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Relative(Node):
    """``'x``: x times the scope's size along the current axis."""

    operand: Expression


@dataclass(frozen=True, slots=True)
class Floating(Node):
    """``~x``: about x; the operand is a `Relative` in ``~'x``."""

    operand: Expression


@dataclass(frozen=True, slots=True)
class Index(Node):
    """``array[i]`` or ``array[i, j]``."""

    array: Expression
    indices: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Array(Node):
    """``[a, b; c, d]``: rows of columns."""

    rows: tuple[tuple[Expression, ...], ...]


@dataclass(frozen=True, slots=True)
class Span(Node):
    """``first : last`` or ``first : step : last``: a range of numbers, only inside ``[ ]``."""

    first: Expression
    last: Expression
    step: Expression | None = None


@dataclass(frozen=True, slots=True)
class Components(Node):
    """``comp(f) { front : a | all : b }`` as an expression: an array with one value per component."""

    arguments: tuple[Expression, ...]
    parts: tuple[Part, ...]
    """Parts, whose bodies are expressions or choices between expressions."""


# Choices ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Case(Node):
    """``case c1: a  case c2: b  else: c``. The last condition is None when there is an else."""

    conditions: tuple[Expression | None, ...]
    branches: tuple[Choice, ...]


@dataclass(frozen=True, slots=True)
class Stochastic(Numbered):
    """``30%: a  20%: b  else: c``. Percentages; the last is None for else, which has the rest to 100."""

    percentages: tuple[Expression | None, ...]
    branches: tuple[Choice, ...]


Choice: TypeAlias = "Case | Stochastic | Sequence | Expression"


Expression: TypeAlias = (
    Number
    | String
    | Boolean
    | Name
    | Call
    | Unary
    | Binary
    | Relative
    | Floating
    | Index
    | Array
    | Span
    | Components
    | Case
    | Stochastic
)
"""A choice in parentheses is an expression: ``270 + (case left: 90 else: 0)``."""

# Sequences of operations -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Invoke(Node):
    """An operation or a successor shape: ``extrude(10)``, ``Wall``, ``Window("oak")``, ``NIL``.

    Its name decides which of the two it is (`grammarlab.language.syntax.builtins`).
    """

    name: str
    arguments: tuple[Expression, ...] = ()
    parenthesised: bool = field(default=False, compare=False)
    """Whether the text had parentheses: ``Wall()`` against ``Wall``."""
    overrides: tuple[Override, ...] | None = None
    """Redefinitions of a dynamic import, ``plant(Name = "Oak").Generate``; otherwise None."""


@dataclass(frozen=True, slots=True)
class Part(Node):
    """``head : body`` inside a block; ``inclusive`` for ``head = body``, one shape for all components together."""

    head: Expression
    """A size in a split, a selector (a Name or an index expression) in the other blocks."""
    body: Choice
    inclusive: bool = False
    connected: bool = False
    """Whether the part is ``head =: body``: one shape for each connected set of components."""
    depth: Expression | None = None
    """The setback of a ``length : depth : body`` part of splitAndSetbackPerimeter."""


@dataclass(frozen=True, slots=True)
class Group(Node):
    """``{ part | part }`` inside a block, repeated when followed by ``*``."""

    parts: tuple[Part | Group, ...]
    repeated: bool = False


@dataclass(frozen=True, slots=True)
class Block(Node):
    """An operation with a block: ``split(x) { … }``, ``comp(f) { … }``, ``shapeL(2, 3) { … }``."""

    name: str
    arguments: tuple[Expression, ...]
    group: Group
    remainder: Group | None = None
    """The second pair of braces of splitAndSetbackPerimeter."""


@dataclass(frozen=True, slots=True)
class Scoped(Node):
    """``[ … ]``: operations, or a choice of operations, on a copy of the shape."""

    body: Choice


@dataclass(frozen=True, slots=True)
class Scatter(Node):
    """``scatter(surface, 10, uniform) { … }``: operations on shapes scattered over the current one."""

    arguments: tuple[Expression, ...]
    body: Choice


@dataclass(frozen=True, slots=True)
class Inline(Node):
    """``inline(strategy) Rule``, ``union { A | B }`` or ``union(order) { … }``: the bodies are derived at once."""

    operation: Literal["inline", "union", "subtract", "intersect"]
    strategy: str
    """``append``, ``unify``, ``recompose``, or else ``swap`` or ``noSwap``; empty for the default."""
    body: Sequence
    """The only operand that is derived, or the first of two."""
    second: Sequence | None = None
    """The second operand of ``union { A | B }``, both of which are derived from the current shape."""


Item: TypeAlias = Invoke | Block | Scoped | Scatter | Inline


@dataclass(frozen=True, slots=True)
class Sequence(Node):
    items: tuple[Item, ...]


# Definitions -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Annotation(Node):
    """``@Range(min=1, max=5)``; ``arguments`` are (keyword or "", value)."""

    name: str
    arguments: tuple[tuple[str, Expression], ...] = ()


@dataclass(frozen=True, slots=True)
class Variable(Node):
    """``name := value`` in ``with ( … )``: a local variable of a definition, evaluated once."""

    name: str
    value: Expression


@dataclass(frozen=True, slots=True)
class Attribute(Node):
    """``attr name = value`` or, with ``constant``, ``const name = value``."""

    name: str
    value: Choice
    constant: bool = False
    annotations: tuple[Annotation, ...] = ()
    variables: tuple[Variable, ...] = ()


@dataclass(frozen=True, slots=True)
class Function(Node):
    """``name(a, b) = value``, or ``name = value`` without parameters."""

    name: str
    parameters: tuple[str, ...]
    value: Choice
    constant: bool = False
    annotations: tuple[Annotation, ...] = ()
    variables: tuple[Variable, ...] = ()


@dataclass(frozen=True, slots=True)
class Rule(Node):
    """``Name(a, b) --> body``."""

    name: str
    parameters: tuple[str, ...]
    body: Choice
    annotations: tuple[Annotation, ...] = ()
    variables: tuple[Variable, ...] = ()
    keyword: Literal["", "start", "extension"] = ""
    """``start`` marks the start rule, ``extension`` a rule that an import may redefine."""


Override: TypeAlias = "Attribute | Rule"
"""Redefinition of an import: ``height = 20`` or ``Roof --> roofHip(30)``."""


@dataclass(frozen=True, slots=True)
class Import(Node):
    """``import alias(styles) : "file.cga" (attribute = value, protected, Rule --> operations)``."""

    alias: str
    path: str
    arguments: tuple[tuple[str, Expression], ...] = ()
    """Attributes with new values."""
    annotations: tuple[Annotation, ...] = ()
    styles: tuple[str, ...] = ()
    protected: tuple[str, ...] | None = ()
    """Attributes that keep their own value; None protects all of them, as empty parentheses do."""
    rules: tuple[Rule, ...] = ()
    """Extension rules with new operations."""


@dataclass(frozen=True, slots=True)
class Style(Node):
    """``style Name`` or ``style Name extends Base``: the following attributes override values in that style."""

    name: str
    base: str = ""
    annotations: tuple[Annotation, ...] = ()


Definition: TypeAlias = Attribute | Function | Rule | Import | Style


@dataclass(frozen=True, slots=True)
class RuleFile(Node):
    """A whole rule file."""

    version: str
    """``"2023.0"``; empty if the file has none."""
    definitions: tuple[Definition, ...]
    spans: tuple[tuple[int, int], ...] = field(default=(), compare=False, repr=False)
    """Offsets of the beginning of each definition, with its annotations, and of the end of its last word."""


def alternatives(choice: Choice) -> Iterator[Sequence | Expression]:
    """Leaves of a choice, from left to right."""
    if isinstance(choice, Case | Stochastic):
        for branch in choice.branches:
            yield from alternatives(branch)
    else:
        yield choice


def children(node: Node) -> list[Node]:
    """Children of a node, in the order of its fields."""
    nodes: list[Node] = []
    for name in _field_names(type(node)):
        value = getattr(node, name)
        if isinstance(value, Node):
            nodes.append(value)
        elif value:
            _gather(value, nodes)
    return nodes


def walk(node: Node) -> Iterator[Node]:
    """The node and all nodes below it, in preorder."""
    stack = [node]
    while stack:
        current = stack.pop()
        yield current
        if _field_names(type(current)):
            below = children(current)
            below.reverse()
            stack += below


def number(tree: RuleFile) -> None:
    """Assign numbers (`Numbered.number`) to the nodes of a new tree, in the order of the text.

    So reformatting a grammar or renaming a rule changes no draw; nor does switching trim planes on or off, whose names
    have no number.
    """
    numbered = (node for node in walk(tree) if isinstance(node, Numbered) and not _is_trim_switch(node))
    for position, node in enumerate(numbered):
        object.__setattr__(node, "number", position)  # safe to mutate: the tree is new and not shared yet


def _is_trim_switch(node: Numbered) -> bool:
    return isinstance(node, Name) and node.identifier in TRIM_SWITCHES


@cache
def _field_names(kind: type[Any]) -> tuple[str, ...]:
    """Fields that may contain nodes; annotations are texts in this file."""
    return tuple(
        field.name
        for field in fields(kind)
        if field.name not in ("location", "number") and field.type not in ("str", "float", "bool")
    )


def _gather(value: object, nodes: list[Node]) -> None:
    if isinstance(value, tuple):
        for item in value:
            if isinstance(item, Node):
                nodes.append(item)
            else:
                _gather(item, nodes)
