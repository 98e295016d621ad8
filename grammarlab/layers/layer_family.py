"""Solved layouts of many canvases as one stochastic CGA grammar, each of whose samples is one of them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from grammarlab.facade.grammar.exact_grammar import write_exact
from grammarlab.facade.grammar.rule_text import RuleNames, front_of_box, number
from grammarlab.facade.looks import THICKNESS
from grammarlab.facade.tree import Facade
from grammarlab.language.formatting import format_grammar
from grammarlab.language.grammar import Grammar

_DIGITS = 9
_RULE = re.compile(r"^(\w+) -->", re.MULTILINE)
_WORD = re.compile(r'"[^"]*"|\b[A-Za-z_]\w*')
_START, _FRONT = "Lot", "Facade"


@dataclass(frozen=True, eq=False)
class FamilyVariant:
    """A layout of one canvas."""

    canvas: tuple[float, float]
    """Requested width and height, metres."""
    facade: Facade
    probability: float
    """Its probability among the layouts of its canvas, > 0."""


@dataclass(frozen=True, slots=True)
class WrittenVariants:
    """A grammar of layouts."""

    text: str
    """CGA text."""
    rules: int
    alone: int
    """Total number of rules of separate grammars of the layouts."""


def write_variants(variants: Sequence[FamilyVariant], title: str) -> WrittenVariants:
    """A grammar that draws a canvas uniformly, then one of its layouts; equal parts share their rules.

    Args:
        variants: the layouts, at least one.
        title: title of the grammar, one line.

    Raises:
        FacadeError: If a facade has parts that are too thin for rules.
    """
    names, rule_names, lines, alone = RuleNames(), dict[tuple[str, str], str](), list[str](), 0
    fronts = []
    for variant in variants:
        rules = _rules(write_exact(variant.facade).text)
        alone += len(rules)
        fronts.append(_added(rules, names, rule_names, lines))
    canvases = list(dict.fromkeys(variant.canvas for variant in variants))
    starts = [
        names.new(f"Canvas{number(width, 2)}by{number(height, 2)}".replace(".", "_")) for width, height in canvases
    ]
    head = [f"// {' '.join(title.split())}", 'version "2023.0"', "@StartRule"]
    head += [_choice(_START, [1.0] * len(canvases), starts)]
    for canvas, start in zip(canvases, starts, strict=True):
        size = ", ".join(number(side, _DIGITS) for side in canvas)
        canvas_fronts = [
            (variant.probability, front)
            for variant, front in zip(variants, fronts, strict=True)
            if variant.canvas == canvas
        ]
        bodies = [front_of_box(f"{size}, {THICKNESS}", front) for _, front in canvas_fronts]
        head.append(_choice(start, [probability for probability, _ in canvas_fronts], bodies))
    text = format_grammar(Grammar.parse("\n".join([*head, *lines])))
    return WrittenVariants(text, len(Grammar.parse(text).rules), alone)


def _rules(text: str) -> dict[str, str]:
    """Bodies of the rules of a text, by name, in its order."""
    starts = [*_RULE.finditer(text)]
    ends = [match.start() for match in starts[1:]] + [len(text)]
    return {
        match[1]: " ".join(text[match.end() : end].replace("@StartRule", "").split())
        for match, end in zip(starts, ends, strict=True)
    }


def _added(rules: Mapping[str, str], names: RuleNames, rule_names: dict[tuple[str, str], str], lines: list[str]) -> str:
    """The name of the rule of a facade; its rules are added to the lines."""
    renamed: dict[str, str] = {}

    def add(name: str) -> str:
        if name not in renamed:
            body = _WORD.sub(lambda match: add(match[0]) if match[0] in rules else match[0], rules[name])
            plain = "Front" if name == _FRONT else re.sub(r"_?\d+$", "", name)
            if (plain, body) not in rule_names:
                rule_names[plain, body] = names.new(plain)
                lines.append(f"{rule_names[plain, body]} --> {body}")
            renamed[name] = rule_names[plain, body]
        return renamed[name]

    return add(_FRONT)


def _choice(name: str, weights: Sequence[float], bodies: Sequence[str]) -> str:
    """A rule with alternatives of probabilities in proportion to weights."""
    if len(bodies) == 1:
        return f"{name} --> {bodies[0]}"
    total = sum(weights)
    lines = [f"{number(100.0 * weight / total, 6)}% : {body}" for weight, body in zip(weights, bodies, strict=True)]
    return f"{name} -->\n" + "\n".join([*lines[:-1], f"else : {bodies[-1]}"])
