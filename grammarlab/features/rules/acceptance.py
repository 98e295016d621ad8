"""Acceptance rules: annotations of a rule file that decide which of its models are kept.

The rule is an expression over the features of a model; other engines ignore it::

    @Acceptance("choose({Balcony} >= 9, 1, 0.05)")
    const acceptance_rate = 0.31

The value of the expression, clipped to 0 to 1, is the probability with which a model is kept; a rejected model is drawn
again. So the density of the file is that of its rules times this value. Features count symbols of the grammar from
which the file was learned: if symbols are split, further texts of the annotation map the new ones to the old ones::

    "Block_box/0 Block *:0"        the only way to rewrite Block_box is the first branch of Block
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest, RuleName
from grammarlab.errors import UsageError
from grammarlab.features.counting.counts import count
from grammarlab.features.rules.expression import Expression
from grammarlab.language.numbering import Branch, SymbolKey
from grammarlab.language.syntax.tree import Annotation, RuleFile, String

Floats = NDArray[np.float64]

ANNOTATION = "Acceptance"
MOST_SYMBOLS = 10_000
"""Largest number of new symbols in one annotation."""
_SYMBOL = re.compile(r"([^\W\d]\w*)/(\d{1,3}) ([^\W\d]\w*)((?: \S+:\S+)*)")
_ROOT, _NONE = "*", "-"


@dataclass(frozen=True, slots=True)
class SplitSymbol:
    """A symbol of a learned grammar, mapped to a symbol of the original grammar."""

    symbol: str
    branches: Mapping[Branch, Branch | None]
    """Original branch of each of its branches; None if there is none. Other branches are the same."""


@dataclass(frozen=True)
class Acceptance:
    """Acceptance probability of models."""

    expression: Expression
    split: Mapping[SymbolKey, SplitSymbol]
    """Symbols whose names or branches differ from those in the expression."""

    @classmethod
    def of(cls, tree: RuleFile) -> Acceptance | None:
        """Acceptance rule of a rule file; None if it has none.

        Args:
            tree: syntax tree of the file.

        Raises:
            UsageError: If the annotation is not valid, or there are several.
        """
        found = annotations_of(tree)
        if not found:
            return None
        if len(found) > 1:
            raise UsageError(
                f"found {len(found)} annotations @{ANNOTATION}, the second in line {found[1].location.line}; expected "
                "one. Multiply their expressions"
            )
        rule, *split = _texts(found[0])
        return cls(Expression.parse(rule), _split(split))

    def probabilities(self, forest: Forest) -> Floats:
        """[num_models] probability with which each model is kept.

        Args:
            forest: models of the grammar.
        """
        values = count(self._unsplit(forest), self.expression.features)
        return np.clip(self.expression.evaluate(values), 0.0, 1.0)

    def annotation(self) -> str:
        """The rule as an annotation."""
        texts = [self.expression.text, *(_symbol_text(key, split) for key, split in sorted(self.split.items()))]
        listed = ", ".join(f'"{text}"' for text in texts)
        return f"@{ANNOTATION}({listed})"

    def _unsplit(self, forest: Forest) -> Forest:
        """The same trees with the symbols and branches that the expression counts."""
        if not self.split:
            return forest
        names = {name: split.symbol for (name, _), split in self.split.items()}
        symbols, symbol = _distinct(names.get(name, name) for name in forest.symbols)
        rules, rule = _distinct(self._rule(name) for name in forest.rules)
        nodes = forest.nodes
        # The last entry is for nodes that no rule rewrote.
        symbol = symbol.astype(nodes.symbol.dtype)[nodes.symbol]
        rule = np.append(rule, -1).astype(nodes.rule.dtype)[nodes.rule]
        return replace(forest, symbols=symbols, rules=rules, nodes=replace(nodes, symbol=symbol, rule=rule))

    def _rule(self, rule: RuleName) -> RuleName:
        split = self.split.get((rule.symbol, rule.parameters))
        if split is None:
            return replace(rule, line=0)
        branch = split.branches.get(rule.branch, rule.branch)
        # A case that no model of the original reaches has no branch there; no pattern uses a number this high.
        return RuleName(split.symbol, rule.parameters, (1 << 30,) if branch is None else branch, 0)


def annotations_of(tree: RuleFile) -> list[Annotation]:
    """Acceptance annotations of a rule file; at most one is allowed."""
    found = (annotation for definition in tree.definitions for annotation in definition.annotations)
    return [annotation for annotation in found if annotation.name.lower() == ANNOTATION.lower()]


def _distinct(items: Iterable) -> tuple[tuple, NDArray[np.int64]]:
    """The different items, and the index of each among them."""
    listed = list(items)
    places = {item: place for place, item in enumerate(dict.fromkeys(listed))}
    return tuple(places), np.array([places[item] for item in listed], dtype=np.int64)


def _texts(annotation: Annotation) -> list[str]:
    values = [value.value for keyword, value in annotation.arguments if not keyword and isinstance(value, String)]
    if not values or len(values) < len(annotation.arguments):
        raise UsageError('expected texts: @Acceptance("an expression"), such as "choose({Balcony} >= 9, 1, 0.05)"')
    return values


def _split(texts: list[str]) -> dict[SymbolKey, SplitSymbol]:
    if len(texts) > MOST_SYMBOLS:
        raise UsageError(f"expected at most {MOST_SYMBOLS:,} split symbols, found {len(texts):,}")
    found: dict[SymbolKey, SplitSymbol] = {}
    for text in texts:
        match = _SYMBOL.fullmatch(text)
        if match is None:
            raise UsageError(f"expected a split symbol such as 'Block_box/0 Block *:0', found {text[:60]!r}")
        pairs = [pair.split(":", 1) for pair in match[4].split()]
        branches = {_branch(new) or (): _branch(old) for new, old in pairs}
        found[match[1], int(match[2])] = SplitSymbol(match[3], branches)
    return found


def _symbol_text(key: SymbolKey, split: SplitSymbol) -> str:
    pairs = (f" {_branch_text(new)}:{_branch_text(old)}" for new, old in split.branches.items())
    return f"{key[0]}/{key[1]} {split.symbol}{''.join(pairs)}"


def _branch(text: str) -> Branch | None:
    if text in (_ROOT, _NONE):
        return () if text == _ROOT else None
    if re.fullmatch(r"\d{1,6}(\.\d{1,6}){0,99}", text) is None:
        raise UsageError(f"expected a branch such as 0 or 1.2, found {text[:60]!r}")
    return tuple(map(int, text.split(".")))


def _branch_text(branch: Branch | None) -> str:
    return _NONE if branch is None else ".".join(map(str, branch)) or _ROOT
