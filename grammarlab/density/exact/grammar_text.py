"""Text of a grammar from a splitting, with its attributes and their new distributions."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.exact.attributes import AttributeParts, drawn_range, leaf_at
from grammarlab.density.exact.inside import InsideWeights
from grammarlab.density.exact.naming import AbstractNames, SplitNames
from grammarlab.density.exact.splitting import PLAIN, Splitting, Variant, Way
from grammarlab.density.exact.written_rules import WrittenRules
from grammarlab.density.grammar_skeleton import Alternative, Cases, Chance, leaves
from grammarlab.density.grammar_skeleton import Body as Original
from grammarlab.density.rounding import EXACT, are_equal, rounded, rounded_parts
from grammarlab.features.columns.formula_names import MOST_NAMED
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Branch, SymbolKey
from grammarlab.language.rewriting import (
    Body,
    Chances,
    Conditions,
    RuleCopy,
    Same,
    Text,
    choice_text,
    likely_last,
    rewrite,
)
from grammarlab.language.syntax import printing
from grammarlab.language.syntax.syntax_tree import Choice

_INDENT = "    "
_WORD = re.compile(r"[^\W\d]\w*(?:\.\w+)*")


@dataclass(frozen=True, slots=True)
class Origin:
    """Origin of the branches of a learned rule."""

    key: SymbolKey
    """The rule of the original grammar."""
    branches: Mapping[Branch, Branch | None]
    """Original branch of each of its branches; None if no case of the original holds."""


@dataclass(frozen=True, slots=True)
class Mixed:
    """One component of a learned grammar."""

    probability: float
    attributes: tuple[Floats, ...]
    """Probabilities [parts] of the parts of each attribute of the splitting."""
    start: int
    """Variant of the start symbol, or `PLAIN`."""


@dataclass(frozen=True, slots=True)
class WrittenGrammar:
    """A learned grammar and its origins."""

    text: str
    """A rule file."""
    origins: Mapping[SymbolKey, Origin]
    """Origin of each rule that is new or changed; all others are those of the original grammar."""
    start: SymbolKey
    """The start rule."""
    components: tuple[Mixed, ...]
    """Components; if their starts differ, the start rule has one branch for each."""


def write(
    grammar: Grammar,
    splitting: Splitting,
    weights: InsideWeights,
    header: Sequence[str],
    names: Callable[[Splitting, Collection[str]], AbstractNames] = SplitNames,
    step: float = EXACT,
    min_share: float = 0.0,
) -> WrittenGrammar:
    """The grammar of a splitting.

    Args:
        grammar: the original grammar.
        splitting: split symbols of the grammar.
        weights: inside weights of the split symbols; the total is above 0.
        header: lines of a comment at the top of the file.
        names: finds names for variants, given the used names.
        step: probabilities are multiples of this (`grammarlab.density.rounding`).
        min_share: less probable branches may be left out (`grammarlab.density.exact.trimming`).
    """
    words, rules = names(splitting, _identifiers(grammar)), WrittenRules(splitting, weights, min_share)
    return _GrammarWriter(grammar, splitting, weights, words, step, rules).run(header)


class _GrammarWriter:
    def __init__(
        self,
        grammar: Grammar,
        splitting: Splitting,
        weights: InsideWeights,
        words: AbstractNames,
        step: float,
        rules: WrittenRules,
    ) -> None:
        self.grammar = grammar
        self.rules = rules
        self.step = step
        self.splitting = splitting
        self.weights = weights
        self.tree = splitting.automaton.components.tree
        self.components = tuple(_components(splitting, weights, step, rules))
        self.mixed = len(self.components) > 1
        self.branching = len({component.start for component in self.components}) > 1
        """Whether the start rule has a branch for each component; otherwise they differ in attributes only."""
        self.plain: dict[SymbolKey, None] = {}
        """Unchanged symbols that occur."""
        self.parents: dict[int, dict[int, None]] = {}
        """Variants that occur as successors, with their parent variants."""
        self._follow()
        self.name: dict[int, str] = {}
        """The name of each variant with its own rule."""
        self.named: dict[SymbolKey, list[int]] = {}
        """Numbers of the named variants by symbol, in the order of their rules."""
        self.words = words
        self.mixture = self.words.fresh("component") if self.mixed else ""
        """The attribute with the number of a model's component."""
        self._find_names()

    def run(self, header: Sequence[str]) -> WrittenGrammar:
        copies: dict[SymbolKey, list[RuleCopy]] = {}
        origins: dict[SymbolKey, Origin] = {}
        reachable = set(self.tree.reachable)
        for key in self.tree.bodies:
            rule_copies = self._copies(key)
            # A rule that no plain symbol needs is kept if its only variant is equal to it.
            if rule_copies or (key in reachable and key not in self.plain and key not in self.named):
                copies[key] = rule_copies
            for copy in rule_copies:
                if copy.body is not None:
                    origins[copy.name, key[1]] = Origin(key, dict(_origins(copy.body, ())))
        drawn = [[c.attributes[index] for c in self.components] for index in range(len(self.splitting.attributes))]
        attributes = {
            parts.name: text
            for parts, probabilities in zip(self.splitting.attributes, drawn, strict=True)
            if (text := _attribute_text(self.grammar, parts, probabilities, self.mixture))
        }
        definitions = [_mixture_text(self.mixture, [c.probability for c in self.components])] if self.mixed else []
        text = rewrite(self.grammar, copies, attributes, definitions, header)
        return WrittenGrammar(text, origins, (self.start_name, 0), self.components)

    # What occurs

    def _follow(self) -> None:
        """Find the variants and the plain symbols that the learned grammar needs."""
        marked = {(rule.name, 0) for rule in self.grammar.start_rules if not rule.parameters} - {self.tree.start}
        for key in marked & self.tree.bodies.keys():
            self._follow_plain(key)
        queue: list[int] = []
        for component in self.components:
            if component.start == PLAIN:
                self._follow_plain(self.tree.start)
            else:
                queue.append(component.start)
        done = set(queue)
        while queue:
            number = queue.pop()
            variant = self.splitting.variants[number]
            for child in self._children(variant, self.tree.body(variant.key)):
                self.parents.setdefault(child, {})[number] = None
                if child not in done:
                    done.add(child)
                    queue.append(child)

    def _children(self, variant: Variant, body: Original) -> Iterator[int]:
        """The variants below a variant; plain symbols are recorded."""
        if self.weights.body(variant, body) == 0.0:
            # A case that no model of the sample reached.
            self._follow_plain(*_keys_below(body))
        elif isinstance(body, Alternative):
            for way in self.rules.ways_of(variant, body.branch):
                yield from way.children.values()
                self._follow_plain(*(s.key for index, s in enumerate(body.successors) if index not in way.children))
        else:
            dropped = isinstance(body, Chance) and body.probabilities is not None
            for branch in body.branches:
                if not dropped or self.rules.has(variant, branch):
                    yield from self._children(variant, branch)

    def _follow_plain(self, *keys: SymbolKey) -> None:
        queue = [key for key in keys if key not in self.plain]
        while queue:
            key = queue.pop()
            self.plain[key] = None
            queue += [below for below in _keys_below(self.tree.body(key)) if below not in self.plain]

    def _find_names(self) -> None:
        start = self.tree.start
        lone_start = self._lone_start()
        for number in sorted({*self.parents, *lone_start}):
            self.named.setdefault(self.splitting.variants[number].key, []).append(number)
        for key, numbers in self.named.items():
            free = key not in self.plain and not (key == start and self.branching)
            numbers.sort(key=lambda number: number not in lone_start)
            alone = [n for n in numbers if free and (len(numbers) == 1 or n in lone_start)]
            self.name |= dict.fromkeys(alone, key[0])
            others = [number for number in numbers if number not in alone]
            variants = [self.splitting.variants[number] for number in others]
            names = self.words.names(variants, [self.rules.ways(variant) for variant in variants])
            self.name |= dict(zip(others, names, strict=True))
        if self.branching:
            self.start_name = self.words.fresh(f"{start[0]}_mixture") if start in self.plain else start[0]
        else:
            self.start_name = self.name.get(self.components[0].start, start[0])

    def _lone_start(self) -> tuple[int, ...]:
        """The start variant, if it is the same in all components."""
        starts = dict.fromkeys(component.start for component in self.components if component.start != PLAIN)
        return () if self.branching else tuple(starts)

    # Rules

    def _copies(self, key: SymbolKey) -> list[RuleCopy]:
        """Copies that replace a rule; None if it is kept or removed."""
        numbers = self.named.get(key, [])
        changed = [number for number in numbers if not self._unchanged(number)]
        is_start = key == self.tree.start
        if not changed and not (is_start and self.branching):
            return []
        moved = is_start and self.start_name != key[0]
        copies = [RuleCopy(key[0])] if key in self.plain else []
        if is_start and self.branching:
            bodies = [self._start_body(component.start) for component in self.components]
            cases = Conditions(tuple((f"{self.mixture} == {i + 1}", body) for i, body in enumerate(bodies)))
            copies.append(RuleCopy(self.start_name, cases, start=moved))
        for number in numbers:
            variant = self.splitting.variants[number]
            comment = "" if self.name[number] == key[0] else self._comment(number)
            body = self._body(variant, self.tree.body(key))
            copies.append(RuleCopy(self.name[number], body, comment, moved and self.name[number] == self.start_name))
        return copies

    def _start_body(self, start: int) -> Body:
        body = self.tree.body(self.tree.start)
        return _plain_body(body) if start == PLAIN else self._body(self.splitting.variants[start], body)

    def _comment(self, number: int) -> str:
        variant = self.splitting.variants[number]
        inside = list(dict.fromkeys(self.name.get(p, self.start_name) for p in self.parents.get(number, ())))
        more = " and others" if len(inside) > MOST_NAMED else ""
        where = f" in {', '.join(inside[:MOST_NAMED])}{more}:" if inside else ""
        return f"{variant.key[0]}{where} {self.words.condition(variant)}"

    def _unchanged(self, number: int) -> bool:
        variant = self.splitting.variants[number]
        return self.name[number] == variant.key[0] and self._same(variant, self.tree.body(variant.key))

    def _same(self, variant: Variant, body: Original) -> bool:
        """Whether a body keeps its probabilities and the names of its successors."""
        if isinstance(body, Alternative):
            ways = self.rules.ways_of(variant, body.branch)
            return body.branch is None or (
                len(ways) == 1
                and all(self.name[child] == body.successors[index].key[0] for index, child in ways[0].children.items())
            )
        branches = list(body.branches)
        if isinstance(body, Chance) and body.probabilities is not None:
            old, new = np.array(body.probabilities), self.rules.branch_weights(variant, body)
            if not are_equal(new / new.sum(), old):
                return False
            branches = [branch for branch, p in zip(branches, old, strict=True) if p > 0.0]
        return all(self._same(variant, branch) for branch in branches)

    def _body(self, variant: Variant, body: Original) -> Body:
        """The choices of a rule in a variant."""
        if self.weights.body(variant, body) == 0.0:
            return _plain_body(body)
        if isinstance(body, Alternative):
            ways = [(self.weights.way(way), way) for way in self.rules.ways_of(variant, body.branch)]
            return _choice([(weight, self._text(body, way)) for weight, way in ways], self.step)
        if isinstance(body, Chance) and body.probabilities is not None:
            weights = self.rules.branch_weights(variant, body).tolist()
            return _choice(
                [(w, self._body(variant, b)) for w, b in zip(weights, body.branches, strict=True) if w > 0.0], self.step
            )
        return _pruned(body, [self._body(variant, branch) for branch in _written(body)])

    def _text(self, alternative: Alternative, way: Way) -> Text:
        names = {
            alternative.successors[index].location: self.name[child]
            for index, child in way.children.items()
            if self.name[child] != alternative.successors[index].key[0]
        }
        return Text(alternative.branch or (), names)


def _components(splitting: Splitting, weights: InsideWeights, step: float, rules: WrittenRules) -> Iterator[Mixed]:
    """The components with a weight above 0 that are not left out, their probabilities summing to 1."""
    base_probabilities = [a.probabilities if splitting.base == "grammar" else a.shares for a in splitting.attributes]
    summands: list[tuple[float, tuple[Floats, ...], int]] = []
    outside: list[float] = []
    for component in splitting.components:
        drawn = [p * future for p, future in zip(base_probabilities, component.attributes, strict=True)]
        weight = component.weight * weights.of(component.start) * float(np.prod([d.sum() for d in drawn]))
        if weight > 0.0:
            futures = zip(drawn, component.attributes, strict=True)
            parts = tuple(rules.trimming.parts(d / d.sum(), future) for d, future in futures)
            summands.append((weight, parts, rules.of(component.start)))
            outside.append(component.weight)
    total = sum(weight for weight, _, _ in summands)
    probabilities = rules.trimming.parts(np.array([weight / total for weight, _, _ in summands]), np.array(outside))
    summands = [summand for summand, probability in zip(summands, probabilities, strict=True) if probability > 0.0]
    shares = rounded(probabilities[probabilities > 0.0].tolist(), step)
    for share, (_, drawn, start) in zip(shares, summands, strict=True):
        parts = zip(splitting.attributes, drawn, strict=True)
        yield Mixed(
            share, tuple(_round_parts(attribute, probabilities, step) for attribute, probabilities in parts), start
        )


def _round_parts(parts: AttributeParts, probabilities: Floats, step: float) -> Floats:
    return rounded_parts(probabilities, parts.probabilities, [part.branch for part in parts.parts], step)


def _origins(body: Body, path: Branch) -> Iterator[tuple[Branch, Branch | None]]:
    """The alternatives of a new body: their places and original alternatives."""
    if isinstance(body, Text):
        yield path, body.path
        return
    inner = body.branches if isinstance(body, Same) else [branch for _, branch in body.branches]
    for i, branch in enumerate(inner):
        yield from _origins(branch, (*path, i))
    if isinstance(body, Same) and body.closed:
        yield (*path, len(inner)), None


def _attribute_text(grammar: Grammar, parts: AttributeParts, probabilities: Sequence[Floats], mixture: str) -> str:
    """New value of an attribute; empty if it does not change.

    Args:
        grammar: the original grammar.
        parts: the attribute.
        probabilities: [parts] probabilities of the attribute's parts, for each component.
        mixture: the attribute with the number of a model's component.
    """
    if all(are_equal(p, parts.probabilities) for p in probabilities):
        return ""
    value = grammar.attributes[parts.name].value
    if all(are_equal(p, probabilities[0]) for p in probabilities):
        return _drawn(value, parts, probabilities[0], _INDENT)
    values = [_drawn(value, parts, p, 2 * _INDENT) for p in probabilities]
    heads = [*(f"case {mixture} == {i + 1} :" for i in range(len(values) - 1)), "else :"]
    return "".join(f"\n{_INDENT}{head}{text}" for head, text in zip(heads, values, strict=True))


def _drawn(value: Choice, parts: AttributeParts, probabilities: Floats, indent: str) -> str:
    """Text of a value whose parts have these probabilities; adjacent parts of unchanged proportions are joined."""
    runs: list[tuple[float, int, int]] = []
    ratios = probabilities / parts.probabilities
    for i, part in enumerate(parts.parts):
        same_branch = bool(runs) and part.branch == parts.parts[i - 1].branch
        if same_branch and are_equal(ratios[i - 1], ratios[i]):
            runs[-1] = (runs[-1][0] + float(probabilities[i]), runs[-1][1], i)
        else:
            runs.append((float(probabilities[i]), i, i))
    texts = [(p, _part_text(value, parts, first, last)) for p, first, last in runs if p > 0.0]
    return f" {texts[0][1]}" if len(texts) == 1 else choice_text(likely_last(texts), indent)


def _part_text(value: Choice, parts: AttributeParts, first: int, last: int) -> str:
    """Text of a run of parts of one branch."""
    leaf = leaf_at(value, parts.parts[first].branch)
    low, high = parts.parts[first].low, parts.parts[last].high
    ends = drawn_range(leaf)
    if ends is None or ends == (low, high):
        return printing.value(leaf)
    return f"rand({_number(low)}, {_number(high)})"


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")


def _mixture_text(name: str, probabilities: Sequence[float]) -> str:
    """Definition of the attribute with the number of a model's component, from 1.

    Args:
        name: name of the attribute.
        probabilities: probability of each component, at least two.
    """
    choice = [(probability, str(i + 1)) for i, probability in enumerate(probabilities)]
    return f"attr {name} ={choice_text(likely_last(choice), _INDENT)}"


def _keys_below(body: Original) -> list[SymbolKey]:
    return [successor.key for alternative in leaves(body) for successor in alternative.successors]


def _plain_body(body: Original) -> Body:
    """The unchanged choices of a rule."""
    if isinstance(body, Alternative):
        return Text(body.branch or (), {})
    if isinstance(body, Chance) and body.probabilities is not None:
        pairs = zip(body.probabilities, body.branches, strict=True)
        return _choice([(p, _plain_body(branch)) for p, branch in pairs if p > 0.0])
    return _pruned(body, [_plain_body(branch) for branch in _written(body)])


def _choice(branches: Sequence[tuple[float, Body]], step: float = EXACT) -> Body:
    """A choice of branches with these weights; choices directly inside it are merged into it."""
    total = sum(weight for weight, _ in branches)
    flat: list[tuple[float, Body]] = []
    for weight, body in branches:
        inner = body.branches if isinstance(body, Chances) else ((1.0, body),)
        flat += [(weight / total * probability, branch) for probability, branch in inner]
    if len(flat) == 1:
        return flat[0][1]
    shares = rounded([share for share, _ in flat], step)
    return Chances(likely_last([(share, body) for share, (_, body) in zip(shares, flat, strict=True)]))


def _pruned(body: Chance | Cases, branches: Sequence[Body]) -> Same:
    return Same(body.path, tuple(branches), closed=isinstance(body, Cases) and not body.complete and bool(body.path))


def _written(body: Chance | Cases) -> tuple[Original, ...]:
    """The branches in the text."""
    return body.branches[:-1] if isinstance(body, Cases) and not body.complete else body.branches


def _identifiers(grammar: Grammar) -> set[str]:
    """Every name of a rule file, comments included: scanning the text is much faster than walking the tree."""
    return set(_WORD.findall(grammar.text))
