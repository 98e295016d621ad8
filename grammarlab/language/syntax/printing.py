"""Nodes of a syntax tree as CGA text on one line."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import isfinite
from typing import Any

from grammarlab.language.syntax.keywords import (
    BINARY_PRECEDENCE,
    FLOATING_PRECEDENCE,
    POSTFIX_PRECEDENCE,
    PREFIX_PRECEDENCE,
)
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Array,
    Attribute,
    Binary,
    Block,
    Boolean,
    Call,
    Case,
    Choice,
    Components,
    Expression,
    Floating,
    Function,
    Group,
    Import,
    Index,
    Inline,
    Invoke,
    Item,
    Name,
    Number,
    Part,
    Relative,
    Rule,
    Scatter,
    Scoped,
    Sequence,
    Span,
    Stochastic,
    String,
    Style,
    Unary,
)

_CHOICE_PRECEDENCE = -1
_ESCAPES = str.maketrans({"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t"})


def expression(node: Expression, least: int = FLOATING_PRECEDENCE) -> str:
    """An expression; in parentheses if its precedence is less than `least`."""
    text = _PRINTERS[type(node)](node)
    return f"({text})" if _precedence(node) < least else text


def value(choice: Choice) -> str:
    """Value of a function, attribute or argument."""
    if isinstance(choice, Case | Stochastic):
        return " ".join(branch_head(choice, i) + _branch_value(choice, i) for i in range(len(choice.branches)))
    return sequence(choice) if isinstance(choice, Sequence) else expression(choice)


def body(choice: Choice) -> str:
    """Body of a rule or of a part of a block."""
    if isinstance(choice, Case | Stochastic):
        parts = []
        for i, branch in enumerate(choice.branches):
            opening, inner, closing = guarded(choice, i, branch)
            parts.append(f"{branch_head(choice, i)} {opening}{body(inner)}{closing}".rstrip())
        return " ".join(parts)
    return sequence(choice) if isinstance(choice, Sequence) else expression(choice)


def branch_head(choice: Case | Stochastic, index: int) -> str:
    """``case condition :``, ``30% :`` or ``else :``."""
    head = choice.conditions[index] if isinstance(choice, Case) else choice.percentages[index]
    if head is None:
        return "else :"
    if isinstance(choice, Case):
        return f"case {expression(head)} :"
    # Only its form distinguishes a percentage from the operation before it.
    plain = isinstance(head, Name | Call) or (isinstance(head, Number) and head.value >= 0)
    return f"{expression(head)}% :" if plain else f"({expression(head)})% :"


def guarded(choice: Case | Stochastic, index: int, branch: Choice) -> tuple[str, Choice, str]:
    """A branch of operations, written so that the branches after it are not parsed as its own.

    CGA cannot express a choice without ``else`` inside another one that continues. The last branch of such a
    stochastic choice is written as ``else``; such cases, and empty branches, are written in brackets. Parsed trees
    never need this.
    """
    if index + 1 == len(choice.branches):
        return "", branch, ""
    if isinstance(branch, Sequence) and not branch.items and _mark(choice, index + 1) != "else":
        return "[ ", branch, "]"
    if _mark(choice, index + 1) in open_marks(branch):
        if isinstance(branch, Stochastic) and branch.percentages[-1] is not None:
            closed = Stochastic((*branch.percentages[:-1], None), branch.branches, location=branch.location)
            return guarded(choice, index, closed)
        return "[ ", branch, " ]"
    return "", branch, ""


def open_marks(choice: Choice) -> frozenset[str]:
    """Words that would continue a choice if written after it: ``case``, ``%``, ``else``."""
    if not isinstance(choice, Case | Stochastic):
        return frozenset()
    last = open_marks(choice.branches[-1])
    return last if _mark(choice, -1) == "else" else last | {_mark(choice, -1), "else"}


def _mark(choice: Case | Stochastic, index: int) -> str:
    heads = choice.conditions if isinstance(choice, Case) else choice.percentages
    return "else" if heads[index] is None else "case" if isinstance(choice, Case) else "%"


def _branch_value(choice: Case | Stochastic, index: int) -> str:
    branch = choice.branches[index]
    ambiguous = index + 1 < len(choice.branches) and _mark(choice, index + 1) in open_marks(branch)
    return f" ({value(branch)})" if ambiguous else f" {value(branch)}"


# Expressions


def _precedence(node: Expression) -> int:
    if isinstance(node, Case | Stochastic):
        return _CHOICE_PRECEDENCE
    if isinstance(node, Floating | Components):
        # A star directly after the braces of a block would be parsed as their repetition.
        return FLOATING_PRECEDENCE
    if isinstance(node, Binary):
        return BINARY_PRECEDENCE[node.operator]
    if isinstance(node, Unary | Relative) or (isinstance(node, Number) and _is_negative(node)):
        return PREFIX_PRECEDENCE
    return POSTFIX_PRECEDENCE


def _is_negative(node: Number) -> bool:
    return str(node.value).startswith("-")


def _number(node: Number) -> str:
    if not isfinite(node.value):
        raise ValueError(f"expected a finite number, found {node.value}: it has no form in CGA")
    whole = float(node.value).is_integer() and abs(node.value) < 1e16
    return str(int(node.value)) if whole and str(node.value) != "-0.0" else repr(float(node.value))


def _string(node: String) -> str:
    return f'"{node.value.translate(_ESCAPES)}"'


def _prefixed(node: Unary | Relative) -> str:
    sign = node.operator if isinstance(node, Unary) else "'"
    return sign + expression(node.operand, PREFIX_PRECEDENCE)


def _binary(node: Binary) -> str:
    level = BINARY_PRECEDENCE[node.operator]
    return f"{expression(node.left, level)} {node.operator} {expression(node.right, level + 1)}"


def _array(node: Array) -> str:
    return f"[{'; '.join(', '.join(map(expression, row)) for row in node.rows)}]"


def _span(node: Span) -> str:
    parts = (node.first, node.last) if node.step is None else (node.first, node.step, node.last)
    return " : ".join(map(expression, parts))


def _components(node: Components) -> str:
    parts = [f"{part_head(part)} {value(part.body)}" for part in node.parts]
    return f"comp({arguments(node.arguments)}) {{ {' | '.join(parts)} }}"


def arguments(nodes: Iterable[Expression]) -> str:
    """Text between the parentheses of a call."""
    return ", ".join(map(value, nodes))


_PRINTERS: dict[type, Callable[[Any], str]] = {
    Number: _number,
    String: _string,
    Boolean: lambda node: "true" if node.value else "false",
    Name: lambda node: node.identifier,
    Call: lambda node: f"{node.function}({arguments(node.arguments)})",
    Unary: _prefixed,
    Relative: _prefixed,
    Floating: lambda node: f"~{expression(node.operand)}",
    Binary: _binary,
    Index: lambda node: f"{expression(node.array, POSTFIX_PRECEDENCE)}[{', '.join(map(expression, node.indices))}]",
    Array: _array,
    Span: _span,
    Components: _components,
    Case: value,
    Stochastic: value,
}


# Operations


def sequence(node: Sequence) -> str:
    """Operations, one after another."""
    return " ".join(map(item, node.items))


def item(node: Item) -> str:
    """One operation, with its block."""
    match node:
        case Invoke():
            return invoke(node)
        case Scoped():
            return f"[ {body(node.body)} ]" if body(node.body) else "[ ]"
        case Block():
            remainder = f" {group(node.remainder)}" if node.remainder is not None else ""
            return f"{item_head(node)} {group(node.group)}{remainder}"
    if isinstance(node, Inline) and node.second is not None:
        return f"{item_head(node)} {{ {body(node.body)} | {body(node.second)} }}"
    return (
        f"{item_head(node)} {{ {body(node.body)} }}" if needs_braces(node) else f"{item_head(node)} {body(node.body)}"
    )


def item_head(node: Block | Scatter | Inline) -> str:
    """Text before the braces."""
    if isinstance(node, Inline):
        return f"{node.operation}({node.strategy})" if node.strategy else node.operation
    name = node.name if isinstance(node, Block) else "scatter"
    return f"{name}({arguments(node.arguments)})" if node.arguments else name


def needs_braces(node: Scatter | Inline) -> bool:
    """Whether the body needs braces; one inlined rule or block does not."""
    if isinstance(node, Scatter) or node.second is not None:
        return True
    items = node.body.items
    return len(items) != 1 or not isinstance(items[0], Invoke | Block | Scatter)


def invoke(node: Invoke) -> str:
    """An operation without a block, or a symbol."""
    argument_list = f"({arguments(node.arguments)})" if node.arguments or node.parenthesised else ""
    if node.overrides is None:
        return node.name + argument_list
    alias, _, rule = node.name.partition(".")
    return f"{alias}({', '.join(map(override, node.overrides))}).{rule}{argument_list}"


def override(node: Attribute | Rule) -> str:
    """Redefinition of an import."""
    if isinstance(node, Attribute):
        return f"{node.name} = {value(node.value)}"
    return f"{signature(node)} --> {body(node.body)}".rstrip()


def group(node: Group) -> str:
    """Braces with parts."""
    return f"{{ {' | '.join(map(member, node.parts))} }}{'*' if node.repeated else ''}"


def member(node: Part | Group) -> str:
    """A part, or braces inside braces."""
    return group(node) if isinstance(node, Group) else f"{part_head(node)} {body(node.body)}".rstrip()


def part_head(node: Part) -> str:
    """``size :`` or ``selector :``."""
    separator = "=:" if node.connected else "=" if node.inclusive else ":"
    depth = f" : {expression(node.depth)}" if node.depth is not None else ""
    return f"{expression(node.head)}{depth} {separator}"


# Definitions


def signature(node: Attribute | Function | Rule) -> str:
    """Name, parameters and local variables."""
    names = () if isinstance(node, Attribute) else node.parameters
    # Without its parentheses, a constant function without parameters would be parsed as an attribute.
    empty = isinstance(node, Function) and node.constant
    variables = " ".join(f"{variable.name} := {expression(variable.value)}" for variable in node.variables)
    return (
        node.name
        + (f"({', '.join(names)})" if names or empty else "")
        + (f" with ({variables})" if node.variables else "")
    )


def annotation(node: Annotation) -> str:
    """``@Range(min=1, max=5)``."""
    argument_list = ", ".join(
        f"{keyword}={_cell(node)}" if keyword else _cell(node) for keyword, node in node.arguments
    )
    return f"@{node.name}({argument_list})" if node.arguments else f"@{node.name}"


def _cell(node: Expression) -> str:
    """Argument of an annotation; its arrays are written in braces."""
    return f"{{{', '.join(map(expression, node.rows[0]))}}}" if isinstance(node, Array) and node.rows else value(node)


def import_statement(node: Import) -> str:
    """``import alias : "file.cga" (height = 20)``."""
    styles = f"({', '.join(node.styles)})" if node.styles else ""
    items = [f"{name} = {value(argument)}" for name, argument in node.arguments]
    items += [*(node.protected or ()), *map(override, node.rules)]
    tail = f" ({', '.join(items)})" if items or node.protected is None else ""
    return f"import {node.alias}{styles} : {_string(String(node.path))}{tail}"


def style_statement(node: Style) -> str:
    """``style Name extends Base``."""
    return f"style {node.name} extends {node.base}" if node.base else f"style {node.name}"
