"""Allowed values of attributes: ``@Range(min=1, max=5)`` and ``@Enum("low", "high")``.

As in CityEngine, they restrict values entered by users, not values set by rules, and nothing with ``restricted=false``.
"""

from __future__ import annotations

from grammarlab.language.checking.percentages import constant
from grammarlab.language.syntax.printing import expression
from grammarlab.language.syntax.tree import Annotation, Attribute, Boolean, Expression, Number, String


def objection(attribute: Attribute, value: float | bool | str) -> str:
    """Message about a forbidden value of an attribute, such as ``expected 1 to 5, found 9``; empty if it is allowed.

    >>> from grammarlab.language.grammar import Grammar
    >>> grammar = Grammar.parse("@Range(min=1, max=5) attr floors = 2 Lot --> NIL")
    >>> objection(grammar.attributes["floors"], 9.0), objection(grammar.attributes["floors"], 3.0)
    ('expected 1 to 5, found 9', '')
    """
    for annotation in attribute.annotations:
        name = annotation.name.lower()
        if any(key == "restricted" and node == Boolean(False) for key, node in annotation.arguments):
            continue
        wanted = (
            _beyond(annotation, value) if name == "range" else _unlisted(annotation, value) if name == "enum" else ""
        )
        if wanted:
            return f"expected {wanted}, found {f'{value:g}' if isinstance(value, float) else value}"
    return ""


def _beyond(annotation: Annotation, value: float | bool | str) -> str:
    """The range that a number violates; empty if it is inside, or there is no range."""
    if isinstance(value, bool | str):
        return ""
    named = dict(annotation.arguments)
    plain = [node for key, node in annotation.arguments if not key]
    low, high = (named.get("min"), named.get("max")) if {"min", "max"} & named.keys() else (*plain, None, None)[:2]
    least, most = (None if node is None else constant(node) for node in (low, high))
    if (least is None or value >= least) and (most is None or value <= most):
        return ""
    if least is not None and most is not None:
        return f"{least:g} to {most:g}"
    return f"at most {most:g}" if least is None else f"at least {least:g}"


def _unlisted(annotation: Annotation, value: float | bool | str) -> str:
    """The values of an enumeration that lacks a value; empty if it has the value, or there is no enumeration."""
    listed = [node for key, node in annotation.arguments if not key]
    if not listed or value in [_plain(node) for node in listed]:
        return ""
    return "one of " + ", ".join(expression(node).strip('"') for node in listed)


def _plain(node: Expression) -> float | bool | str | None:
    return node.value if isinstance(node, String | Boolean | Number) else constant(node)
