"""Orders of the alternatives of a rule that a person sees: from dark to light, from small to large.

Alternatives are in an order if each begins with a colour, or has a number at the same place of the same operation:

>>> grammar = Grammar.parse('''
... attr tone = rand(0.8, 1.2)
... Glass --> 50% : color(0.4 * tone, 0.5, 0.5) Pane 30% : color("#101010") Pane else : color("#808080") Pane
... Floors --> 50% : Body(3) 20% : Body(1) else : Body(2)
... ''')
>>> visible_orders(grammar)
{'Glass': (((1,), (0,), (2,)),), 'Floors': (((1,), (2,), (0,)),)}
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from operator import add, mul, sub, truediv
from typing import TypeAlias

from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Branch
from grammarlab.language.syntax import syntax_tree as cga
from grammarlab.language.syntax.outline import MAX_DEPTH

Orders: TypeAlias = Mapping[str, tuple[tuple[Branch, ...], ...]]
"""By symbol: orders of the branches of its rule, each from the smallest number to the largest."""
_CALCULATE: Mapping[str, Callable[[float, float], float]] = {"+": add, "-": sub, "*": mul, "/": truediv}
_COLOR = re.compile(r"#[0-9a-fA-F]{6}")


def visible_orders(grammar: Grammar) -> Orders:
    """Orders by what differs among all alternatives, other than that of the text and its reverse.

    Args:
        grammar: grammar with the rules of its default style.
    """
    typical, orders = _Typical(grammar), dict[str, tuple[tuple[Branch, ...], ...]]()
    for (symbol, _), rule in grammar.rules.items():
        branches = list(_branches((), rule.body))
        tables = [dict(_numbers(body, typical)) for _, body in branches]
        ascending: dict[tuple[int, ...], None] = {}
        for place in tables[0]:
            values = [numbers[place] for numbers in tables if place in numbers]
            if len(values) == len(set(values)) == len(branches) > 2:
                ascending[tuple(sorted(range(len(values)), key=values.__getitem__))] = None
        listed = [order for order in ascending if list(order) not in (sorted(order), sorted(order, reverse=True))]
        if listed:
            orders[symbol] = tuple(tuple(branches[index][0] for index in order) for order in listed)
    return orders


def _branches(path: Branch, choice: cga.Choice) -> Iterator[tuple[Branch, cga.Node]]:
    if isinstance(choice, cga.Case | cga.Stochastic):
        for number, branch in enumerate(choice.branches):
            yield from _branches((*path, number), branch)
    else:
        yield path, choice


def _numbers(body: cga.Node, typical: _Typical) -> Iterator[tuple[tuple[str, int, int], float]]:
    """Numbers of the operations of an alternative, by name, occurrence and argument; a colour has its lightness."""
    times: dict[str, int] = {}
    for item in body.items if isinstance(body, cga.Sequence) else ():
        if isinstance(item, cga.Invoke):
            time = times[item.name] = times.get(item.name, -1) + 1
            values = [typical.value(argument) for argument in item.arguments]
            if item.name == "color" and len(values) == 3:
                values = [None if None in values else _lightness(*(value or 0.0 for value in values))]
            yield from (((item.name, time, i), value) for i, value in enumerate(values) if value is not None)


def _lightness(red: float, green: float, blue: float) -> float:
    """Relative luminance, by the weights of ITU-R BT.709."""
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


class _Typical:
    """Typical values of expressions: random numbers have their mean, colours their lightness."""

    def __init__(self, grammar: Grammar) -> None:
        self._attributes = grammar.attributes
        self._values: dict[str, float | None] = {}

    def value(self, node: cga.Node, depth: int = 0) -> float | None:
        """The value of an expression; None if it has no typical one, or is in too many others."""
        if depth > MAX_DEPTH:
            return None
        match node:
            case cga.Number(value):
                return value
            case cga.String(text) if _COLOR.fullmatch(text):
                red, green, blue = bytes.fromhex(text[1:])
                return _lightness(red, green, blue) / 255.0
            case cga.Name(name) if name in self._attributes:
                return self._of_attribute(name, depth)
            case cga.Call("rand", (low, high)):
                total = self._calculated("+", low, high, depth)
                return None if total is None else total / 2.0
            case cga.Binary(("+" | "-" | "*" | "/") as operator, left, right):
                return self._calculated(operator, left, right, depth)
            case cga.Unary("-", operand):
                number = self.value(operand, depth + 1)
                return None if number is None else -number
            case cga.Relative(operand) | cga.Floating(operand):
                return self.value(operand, depth + 1)
            case _:
                return None

    def _of_attribute(self, name: str, depth: int) -> float | None:
        if name not in self._values:
            self._values[name] = None  # what depends on itself has no value
            self._values[name] = self.value(self._attributes[name].value, depth + 1)
        return self._values[name]

    def _calculated(self, operator: str, left: cga.Node, right: cga.Node, depth: int) -> float | None:
        first, second = self.value(left, depth + 1), self.value(right, depth + 1)
        if first is None or second is None or (operator == "/" and second == 0.0):
            return None
        return _CALCULATE[operator](first, second)
