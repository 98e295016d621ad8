"""Styles of rule files: sets of definitions that override those of the default style or of another style."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from difflib import get_close_matches

from grammarlab.errors import Finding, LanguageError, Location
from grammarlab.language.grammar import Grammar, default_style
from grammarlab.language.syntax.syntax_tree import Attribute, Definition, Function, Import, Rule, Style

DEFAULT = "Default"
"""Name of the definitions before the first style."""


def style_names(grammar: Grammar) -> tuple[str, ...]:
    """Names of the styles of a rule file, the default style first."""
    return (DEFAULT, *(node.name for node in grammar.tree.definitions if isinstance(node, Style)))


def styled(grammar: Grammar, name: str) -> Grammar:
    """A rule file in one of its styles, without the others.

    Definitions that the style overrides are replaced where they stand, so that random places keep their order; an
    attribute or rule keeps its annotations if its new definition has none. New definitions follow at the end.

    Args:
        grammar: a rule file.
        name: name of a style; ``Default`` is the part before the first one.

    Raises:
        LanguageError: If it has no such style.

    >>> grammar = Grammar.parse('attr h = 3  Lot --> extrude(h) A  style Tall  attr h = 9')
    >>> styled(grammar, "Tall").text.split()
    ['attr', 'h', '=', '9', 'Lot', '-->', 'extrude(h)', 'A']
    """
    slices = {
        id(node): grammar.text[start:end]
        for node, (start, end) in zip(grammar.tree.definitions, grammar.tree.spans, strict=True)
    }
    overrides = {_key(node): node for style in _chain(grammar, name) for node in _definitions(grammar, style)}
    parts, position = [], 0
    originals = list(default_style(grammar.tree))
    for node, (start, end) in zip(originals, grammar.tree.spans, strict=False):
        override = overrides.pop(_key(node), None)
        if override is not None:
            text = slices[id(override)]
            marks = "" if override.annotations else _annotations(slices[id(node)], node)
            parts += [grammar.text[position:start], marks + text]
            position = end
    last = grammar.tree.spans[len(originals) - 1][1] if originals else 0
    parts.append(grammar.text[position:last])
    new = [slices[id(node)] for node in overrides.values()]
    text = "\n\n".join(["".join(parts), *new]).rstrip() + "\n"
    if name == DEFAULT and len(originals) == len(grammar.tree.definitions):
        return grammar
    return replace(
        Grammar.parse(text, grammar.file),
        libraries=grammar.libraries,
        import_findings=grammar.import_findings,
        assets=grammar.assets,
    )


def _chain(grammar: Grammar, name: str) -> list[Style]:
    """The styles that a style consists of, from the base to itself."""
    styles = {node.name: node for node in grammar.tree.definitions if isinstance(node, Style)}
    chain: list[Style] = []
    while name != DEFAULT:
        style = styles.get(name)
        if style is None or style in chain:
            near = get_close_matches(name, style_names(grammar), n=1)
            hint = f"did you mean '{near[0]}'?" if near else f"expected one of {', '.join(style_names(grammar))}"
            message = f"unknown style '{name}'" if style is None else f"the style '{name}' extends itself"
            place = style.location if style is not None else Location(file=grammar.file)
            raise LanguageError((Finding("error", "unknown-name", message, place, hint),), grammar.text)
        chain.insert(0, style)
        name = style.base or DEFAULT
    return chain


def _definitions(grammar: Grammar, style: Style) -> Iterator[Definition]:
    """Definitions below a style, up to the next one."""
    is_inside = False
    for node in grammar.tree.definitions:
        if isinstance(node, Style):
            is_inside = node is style
        elif is_inside:
            yield node


def _key(node: Definition) -> tuple[type, str, int]:
    if isinstance(node, Rule):
        return Rule, node.name, len(node.parameters)
    if isinstance(node, Import):
        return Import, node.alias, 0
    return Attribute, node.name, len(node.parameters) if isinstance(node, Function) else 0


def _annotations(text: str, node: Definition) -> str:
    """The annotations at the beginning of the text of a definition."""
    if not node.annotations or isinstance(node, Import | Style):
        return ""
    word = r"(?:(?:attr|const|start|extension)\s+)?"
    match = re.search(rf"{word}{re.escape(node.name)}\s*(?:\([^()]*\)\s*)?(?:with\b|=|-->)", text)
    return text[: match.start()] if match else ""
