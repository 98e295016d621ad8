"""Controls of attributes: sliders, menus, colours, switches and fields, from their annotations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from grammarlab.language.checking.percentages import constant
from grammarlab.language.dimensions import units_of_attributes
from grammarlab.language.display_names import DisplayNames
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Attribute,
    Boolean,
    Expression,
    Number,
    String,
    alternatives,
)

MAX_CONTROLS = 200
"""Largest number of controls of a page."""


@dataclass(frozen=True, slots=True)
class Control:
    """A way to enter the value of an attribute."""

    name: str
    label: str
    """Its name in words, with its unit if that is known."""
    group: str
    """First text of ``@Group``; empty without one."""
    kind: Literal["number", "text", "switch", "menu", "color"]
    value: str
    """Value in the rule file, as a text of `read_attributes`; empty if it is drawn or computed."""
    low: float | None = None
    """Ends of ``@Range``; a number with both is a slider."""
    high: float | None = None
    step: float | None = None
    choices: tuple[str, ...] = ()
    """Values of ``@Enum``."""


def controls_of(grammar: Grammar) -> tuple[Control, ...]:
    """The controls of a grammar's attributes, at most `MAX_CONTROLS`, group by group as ``@Group`` and ``@Order`` say.

    Attributes without a group come first, those with ``@Hidden`` have no control.

    >>> text = '@Range(min=1, max=5) attr numFloors = 2 @Enum("flat", "gable") attr roof = "flat" A --> NIL'
    >>> grammar = Grammar.parse(text)
    >>> [(control.label, control.kind, control.high, control.choices) for control in controls_of(grammar)]
    [('num floors', 'number', 5.0, ()), ('roof', 'menu', None, ('flat', 'gable'))]
    """
    names, units = DisplayNames.of(grammar.tree), units_of_attributes(grammar.tree)
    attributes = [each for each in grammar.attributes.values() if not each.constant and not _annotation(each, "hidden")]
    groups = {"": (-1.0, -1)}
    for place, attribute in enumerate(attributes):
        groups.setdefault(_group(attribute), (_number(_annotation(attribute, "group"), 1), place))
    # Of equal order as in the text.
    ordered = sorted(attributes, key=lambda each: (groups[_group(each)], _order(each)))
    return tuple(_control(attribute, names, units.get(attribute.name, "")) for attribute in ordered[:MAX_CONTROLS])


def _control(attribute: Attribute, names: DisplayNames, unit: str) -> Control:
    kind, value = _kind_and_value(attribute)
    choices = tuple(_texts(_annotation(attribute, "enum")))
    low, high, step = _range(_annotation(attribute, "range"))
    return Control(
        name=attribute.name,
        label=names.text(attribute.name) + (f" ({unit})" if unit else ""),
        group=_group(attribute),
        kind="menu" if choices else "color" if kind == "text" and _annotation(attribute, "color") else kind,
        value=value,
        low=low,
        high=high,
        step=step,
        choices=choices,
    )


def _kind_and_value(attribute: Attribute) -> tuple[Literal["number", "text", "switch"], str]:
    values = list(alternatives(attribute.value))
    value = values[0] if len(values) == 1 else None
    if isinstance(value, String):
        return "text", value.value
    if isinstance(value, Boolean):
        return "switch", str(value.value).lower()
    if any(isinstance(each, String) for each in values):
        return "text", ""
    number = constant(value) if isinstance(value, Expression) else None
    return "number", "" if number is None else f"{number:.12g}"


def _annotation(attribute: Attribute, name: str) -> Annotation | None:
    return next((each for each in attribute.annotations if each.name.lower() == name), None)


def _group(attribute: Attribute) -> str:
    return next(_texts(_annotation(attribute, "group")), "")


def _order(attribute: Attribute) -> float:
    return _number(_annotation(attribute, "order"), 0)


def _number(annotation: Annotation | None, place: int) -> float:
    """A number among the values of an annotation; infinite if there is none."""
    arguments = () if annotation is None else annotation.arguments
    number = constant(arguments[place][1]) if len(arguments) > place else None
    return float("inf") if number is None else number


def _texts(annotation: Annotation | None) -> Iterator[str]:
    """The values of an annotation without keywords, as texts."""
    for key, node in () if annotation is None else annotation.arguments:
        if key:
            continue
        if isinstance(node, String):
            yield node.value
        elif isinstance(node, Number | Boolean):
            yield f"{node.value:.12g}" if isinstance(node, Number) else str(node.value).lower()


def _range(annotation: Annotation | None) -> tuple[float | None, float | None, float | None]:
    if annotation is None:
        return None, None, None
    named = dict(annotation.arguments)
    plain = [node for key, node in annotation.arguments if not key]
    nodes = [
        named.get(name, node)
        for name, node in zip(("min", "max", "stepsize"), (*plain, None, None, None), strict=False)
    ]
    low, high, step = (None if node is None else constant(node) for node in nodes)
    return low, high, step
