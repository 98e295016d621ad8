"""Checks that the symbols, branches and random expressions of features exist in a grammar."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches

from grammarlab.derivation.forest import RuleName, Site
from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Draw, Feature, Formula, Pattern, Present, Threshold

MAX_REMARKS = 10
"""Largest number of remarks in one error."""


def check(
    features: Iterable[Feature], symbols: Sequence[str], rules: Sequence[RuleName], sites: Sequence[Site]
) -> None:
    """Check that features can occur in the derivation trees of a grammar.

    Args:
        features: the features.
        symbols: all symbols of the grammar, those without rules included.
        rules: all rules of the grammar.
        sites: random expressions of the grammar.

    Raises:
        UsageError: If the grammar lacks a symbol, branch or random expression; it names each of them and the nearest
            existing one.
    """
    remarks: dict[str, None] = {}
    for feature in features:
        remarks |= dict.fromkeys(remark for remark in _remarks(feature, symbols, rules, sites) if remark)
    if remarks:
        raise UsageError("\n".join(list(remarks)[:MAX_REMARKS]))


def _remarks(
    feature: Feature, symbols: Sequence[str], rules: Sequence[RuleName], sites: Sequence[Site]
) -> Iterator[str]:
    """Messages about a feature; empty texts if it is valid."""
    match feature:
        case Present(inner):
            yield from _remarks(inner, symbols, rules, sites)
        case Formula():
            for inner in feature.features:
                yield from _remarks(inner, symbols, rules, sites)
        case Pattern():
            yield from (_pattern_remark(node, symbols, rules) for node in _nodes(feature))
        case Threshold():
            yield _site_remark(feature.site, None, sites)
        case Draw():
            yield _site_remark(feature.site, feature.branch, sites)


def _pattern_remark(node: Pattern, symbols: Sequence[str], rules: Sequence[RuleName]) -> str:
    """Message about one node of a pattern, without its conditions; empty if it is valid."""
    if node.symbol is not None and node.symbol not in symbols:
        return f"the grammar has no symbol {node.symbol!r}{_nearest(node.symbol, symbols)}"
    matching = [rule for rule in rules if node.symbol in {None, rule.symbol}]
    who = f"the symbol {node.symbol!r}" if node.symbol is not None else "the grammar"
    if node.branch is not None and not matching:
        return f"{who} has no rule, so it is always a leaf; leave the branch out"
    if node.parameters is not None:
        counts = sorted({rule.parameters for rule in matching})
        matching = [rule for rule in matching if rule.parameters == node.parameters]
        if not matching:
            available = ", ".join(f"/{count}" for count in counts) or "no rule at all"
            return f"{who} has no rule with {node.parameters} parameters; it has {available}"
        who += f" with {node.parameters} parameters"
    return _branch_remark(who, node.branch, matching) if node.branch else ""


def _nearest(name: str, names: Sequence[str]) -> str:
    near = get_close_matches(name, dict.fromkeys(names), n=3, cutoff=0.6)
    return f"; did you mean {' or '.join(repr(other) for other in near)}?" if near else ""


def _branch_remark(who: str, branch: tuple[int, ...], rules: Sequence[RuleName]) -> str:
    """Message about a branch of rules."""
    for level, number in enumerate(branch):
        here = [rule.branch for rule in rules if rule.branch[:level] == branch[:level]]
        numbers = sorted({path[level] for path in here if len(path) > level})
        if number in numbers:
            continue
        before = ".".join(str(i) for i in branch[:level])
        if not numbers:
            ending = f"branch :{before} of {who} has no branches of its own" if before else f"{who} has no branches"
            return f"{ending}; leave {'.' + str(number) if before else ':' + str(number)} out"
        prefix = f":{before}." if before else ":"
        last = f" to {prefix}{numbers[-1]}" if len(numbers) > 1 else ""
        return f"{who} has no branch {prefix}{number}; it has {len(numbers)}, {prefix}{numbers[0]}{last}"
    return ""


def _nodes(pattern: Pattern) -> Iterator[Pattern]:
    stack = [pattern]
    while stack:
        node = stack.pop()
        yield node
        stack.extend(part for below in reversed(node.below) for part in reversed(below.run))


def _site_remark(name: str, branch: int | None, sites: Sequence[Site]) -> str:
    matching = [site for site in sites if site.name == name]
    if not matching:
        return f"the grammar has no random expression {name!r}{_nearest(name, [site.name for site in sites])}"
    if branch is not None and all(branch >= site.choices for site in matching):
        choices = max(site.choices for site in matching)
        return f"${name} has no branch :{branch}; " + (
            f"it is a choice of {choices}, :0 to :{choices - 1}" if choices else "it is not a choice"
        )
    return ""
