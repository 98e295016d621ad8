"""One facade as a CGA split grammar that derives each of its leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.facade.grammar.derived_errors import leaf_error
from grammarlab.facade.grammar.leaf_looks import (
    OutlinedLeaf,
    ShownPictures,
    outlined_leaves,
    projection,
    shown_pictures,
)
from grammarlab.facade.grammar.rule_text import RuleNames, front_of_box, leaf_body, number, rule_name, split_body
from grammarlab.facade.looks import THICKNESS, look_of
from grammarlab.facade.tree import LEAF, Facade, X
from grammarlab.language.formatting import format_grammar
from grammarlab.language.grammar import Grammar

EXACT = 1e-9
"""Largest difference of a derived leaf and that of the facade, metres."""
_DIGITS = (3, 6, 9, 12, 15)


@dataclass(frozen=True, slots=True)
class WrittenFacade:
    """A grammar of one facade."""

    text: str
    """CGA text."""
    rules: int
    outlined: tuple[OutlinedLeaf, ...]
    """Leaves whose meshes it refers to."""
    error: float
    """Largest difference of the sides of derived leaves and those of the facade, metres."""


def write_exact(facade: Facade) -> WrittenFacade:
    """The grammar with the shortest numbers and the most repeats whose derivation has the leaves of the facade.

    Equal parts share a rule, runs of equal parts are repeats, walls have relative sizes and elements in them absolute
    ones. A leaf whose outline reaches all sides of its box is a mesh with wall around it, other outlines are their
    boxes.

    Raises:
        FacadeError: If no rules derive it to `EXACT`, for example with parts thinner than that.
    """
    errors, outlined = [], outlined_leaves(facade)
    for repeats in (True, False):
        for digits in _enough_digits(facade):
            text, labels = _text(facade, outlined, digits, repeats=repeats)
            error = leaf_error(facade, Grammar.parse(text), labels, outlined.values())
            if error <= EXACT:
                return WrittenFacade(text, len(Grammar.parse(text).rules), tuple(outlined.values()), error)
            errors.append(error)
    raise FacadeError(
        f"no split rules derive this facade exactly: the best miss a leaf by {min(errors):.3g} m, expected at most "
        f"{EXACT:g}. Parts of it may be too thin, or too small relative to its size."
    )


def _enough_digits(facade: Facade) -> tuple[int, ...]:
    """Numbers of decimals to try, the fewest first: those with negligible rounding of any size."""
    most_parts = max((len(parts) for parts in facade.children), default=0) + 1
    return tuple(
        digits
        for digits in _DIGITS
        if digits == _DIGITS[-1] or np.abs(facade.size - facade.size.round(digits)).max() * most_parts <= EXACT
    )


def flexible(facade: Facade) -> NDArray[np.bool_]:
    """[N, 2] whether a node can be stretched along x and along y with only walls changing."""
    is_flexible = np.ones((len(facade), 2), dtype=bool)
    for node in range(len(facade) - 1, -1, -1):
        along, parts = int(facade.axis[node]), facade.children[node]
        if along == LEAF:
            is_flexible[node] = look_of(facade.name_of(node)).is_flexible
        else:
            is_flexible[node, along] = is_flexible[parts, along].any()
            is_flexible[node, 1 - along] = is_flexible[parts, 1 - along].all()
    return is_flexible


def _text(
    facade: Facade, outlined: dict[int, OutlinedLeaf], digits: int, *, repeats: bool
) -> tuple[str, dict[str, str]]:
    """The grammar, and the label of each of its leaf rules."""
    shows = shown_pictures(facade)
    part, kinds = _parts(facade, outlined, shows, digits)
    names, used = [""] * len(kinds), RuleNames()
    labels: dict[str, str] = {}
    first: dict[int, int] = {}
    for node in range(len(facade)):
        first.setdefault(int(part[node]), node)
    for kind, node in first.items():
        names[kind] = "Facade" if not node else used.new(_preferred_name(facade, node))
    width, height = (number(size, digits) for size in (facade.width, facade.height))
    start = f"Lot --> {front_of_box(f'{width}, {height}, {THICKNESS}', 'Facade')}"
    title = f"// A facade of {len(facade.leaves)} leaves, {facade.width:.4g} m wide and {facade.height:.4g} m high"
    lines = [title, 'version "2023.0"', "@StartRule", start]
    for kind, node in first.items():
        setup, content = kinds[kind]
        if isinstance(content, str):
            # A leaf after an inserted part has no rule, only a name.
            terminal = used.new(f"{names[kind]}Shape") if node in outlined else names[kind]
            labels[terminal] = facade.name_of(node)
            body = f"{content} {terminal}." if node in outlined else content
        else:
            sizes = [(size, names[child]) for size, child in content]
            body = split_body("xy"[facade.axis[node]], sizes, repeats=repeats)
        lines.append(f"{names[kind]} --> {setup} {body}")
    return format_grammar(Grammar.parse("\n".join(lines))), labels


def _parts(
    facade: Facade, outlined: dict[int, OutlinedLeaf], shows: ShownPictures, digits: int
) -> tuple[NDArray[np.int64], list[tuple[str, str | tuple[tuple[str, int], ...]]]]:
    """Index of the distinct part of each node [N], and for each part its operations and its components.

    The components of a leaf are the operations that draw it, those of any other part are sizes and indices of its
    parts.
    """
    is_flexible, part = flexible(facade), np.zeros(len(facade), dtype=np.int64)
    kind_of_part: dict[tuple[object, ...], int] = {}
    kinds: list[tuple[str, str | tuple[tuple[str, int], ...]]] = []
    for node in range(len(facade) - 1, -1, -1):
        above, along = int(facade.parent[node]), int(facade.axis[node])
        pictured = shows.picture[node] >= 0
        begins = pictured and (above < 0 or shows.picture[above] < 0)
        setup = projection(facade, shows, node) if begins else ""
        if along == LEAF:
            label, pictured = facade.name_of(node), bool(pictured and (setup or not begins))
            shape = outlined.get(node)
            content = shape.body(label, pictured=pictured) if shape else leaf_body(label, pictured=pictured)
        else:
            parts = facade.children[node]
            floats = is_flexible[parts, along] | ~is_flexible[parts, along].any()
            content = tuple(
                (("~" if floating else "") + number(size, digits), kind)
                for floating, size, kind in zip(
                    floats.tolist(), facade.size[parts, along].tolist(), part[parts].tolist(), strict=True
                )
            )
        key = (along, facade.label[node], setup, content)
        if not node:
            key = (*key, "root")
        part[node] = kind_of_part.setdefault(key, len(kinds))
        if part[node] == len(kinds):
            kinds.append((setup, content))
    return part, kinds


def _preferred_name(facade: Facade, node: int) -> str:
    """The preferred rule name of a node: its label, or the labels inside it and the axis of its parts."""
    label, along = facade.name_of(node), int(facade.axis[node])
    if label or along == LEAF:
        return rule_name(label)
    inside = set(facade.label[node : facade.end[node]].tolist()) - {-1}
    things = [facade.labels[index] for index in sorted(inside) if not look_of(facade.labels[index]).is_flexible]
    kind = "Row" if along == X else "Bay"
    return rule_name(things[0]) + kind if len(things) == 1 else kind
