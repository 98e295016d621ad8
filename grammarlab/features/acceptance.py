"""Acceptance rules: annotations of a rule file that decide which of its models are kept, and the accepted models.

The rule is an expression over the features of a model; other engines ignore it::

    @Acceptance("choose({Balcony} >= 9, 1, 0.05)")
    const acceptance_rate = 0.31

The value of the expression, clipped to 0 to 1, is the probability with which a model is kept; a rejected model is drawn
again. So the density of the file is that of its rules times this value. Features count symbols of the grammar from
which the file was learned: if symbols are split, further texts of the annotation map the new ones to the old ones::

    "Block_box/0 Block *:0"        the only way to rewrite Block_box is the first branch of Block

An accepted model is the first one kept of a sequence of candidates. The seed of candidate t follows from the model's
own seed and t; the first candidate has the model's own seed. So a model is the same alone, in a batch of any size, and
on any number of workers.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import BATCH, Floats, Ints
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation.derive import derive, derive_chunks
from grammarlab.derivation.forest import Forest, RuleName
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.program import Program
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.features.accepted_models import ANNOTATION, Accepted, annotations_of
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.counts import count
from grammarlab.language.numbering import Branch, SymbolKey
from grammarlab.language.syntax.syntax_tree import Annotation, RuleFile, String
from grammarlab.randomness import fold, root_keys, uniforms

MAX_USUAL_TRIES = 1_000
"""Largest number of candidates of one model, if one of them has a probability above 0."""
_RARE_FACTOR = 20
"""Factor of `MAX_USUAL_TRIES` if all candidates have probability 0, so that a rule may keep one model in 1,000."""
MAX_TRIES = _RARE_FACTOR * MAX_USUAL_TRIES
"""Largest number of candidates of one model."""
_MAX_SYMBOLS = 10_000
"""Largest number of new symbols in one annotation."""
_CANDIDATES, _DECISIONS = int.from_bytes(b"ACCEPT"), int.from_bytes(b"DECIDE")
"""Lanes of random numbers: seeds of candidates, and decisions about them."""
_SYMBOL = re.compile(r"([^\W\d][\w.]*)/(\d{1,3}) ([^\W\d][\w.]*)((?: \S+:\S+)*)")
_ROOT, _NONE = "*", "-"


@dataclass(frozen=True, slots=True)
class SplitSymbol:
    """A symbol of a learned grammar, mapped to a symbol of the original grammar."""

    symbol: str
    branches: Mapping[Branch, Branch | None]
    """Original branch of each branch of the symbol; None if there is none. Other branches are the same."""


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
        acceptances = annotations_of(tree)
        if not acceptances:
            return None
        if len(acceptances) > 1:
            raise UsageError(
                f"found {len(acceptances)} annotations @{ANNOTATION}, the second in line "
                f"{acceptances[1].location.line}; expected one. Multiply their expressions"
            )
        rule, *split = _texts(acceptances[0])
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


def derive_accepted(
    program: Program,
    acceptance: Acceptance | None,
    lots: Lots,
    assets: AssetFolder | None = None,
    enough_tries: int = MAX_USUAL_TRIES,
    *,
    leaves: bool = True,
) -> Accepted:
    """Accepted models of lots.

    Args:
        program: the compiled grammar.
        acceptance: acceptance rule of the grammar; None for a grammar that keeps all models.
        lots: the lots.
        assets: meshes and images.
        enough_tries: largest number of candidates of one model; 20 times as many if all have probability 0.
        leaves: whether to record leaves, see `derive`.

    Raises:
        GrammarlabError: If all candidates of a model have probability 0.
    """
    if acceptance is None or not len(lots):
        return Accepted.all_of(derive(program, lots, assets=assets, leaves=leaves))
    search = _AcceptingSearch(program, acceptance, lots, assets, enough_tries, leaves)
    return search.run()


def _texts(annotation: Annotation) -> list[str]:
    values = [value.value for keyword, value in annotation.arguments if not keyword and isinstance(value, String)]
    if not values or len(values) < len(annotation.arguments):
        raise UsageError('expected texts: @Acceptance("an expression"), such as "choose({Balcony} >= 9, 1, 0.05)"')
    return values


def _split(texts: list[str]) -> dict[SymbolKey, SplitSymbol]:
    if len(texts) > _MAX_SYMBOLS:
        raise UsageError(f"expected at most {_MAX_SYMBOLS:,} split symbols, found {len(texts):,}")
    symbols: dict[SymbolKey, SplitSymbol] = {}
    for text in texts:
        match = _SYMBOL.fullmatch(text)
        if match is None:
            raise UsageError(f"expected a split symbol such as 'Block_box/0 Block *:0', found {text[:60]!r}")
        pairs = [pair.split(":", 1) for pair in match[4].split()]
        branches = {_branch(new) or (): _branch(old) for new, old in pairs}
        symbols[match[1], int(match[2])] = SplitSymbol(match[3], branches)
    return symbols


def _branch(text: str) -> Branch | None:
    if text in (_ROOT, _NONE):
        return () if text == _ROOT else None
    if re.fullmatch(r"\d{1,6}(\.\d{1,6}){0,99}", text) is None:
        raise UsageError(f"expected a branch such as 0 or 1.2, found {text[:60]!r}")
    return tuple(map(int, text.split(".")))


def _symbol_text(key: SymbolKey, split: SplitSymbol) -> str:
    pairs = (f" {_branch_text(new)}:{_branch_text(old)}" for new, old in split.branches.items())
    return f"{key[0]}/{key[1]} {split.symbol}{''.join(pairs)}"


def _branch_text(branch: Branch | None) -> str:
    return _NONE if branch is None else ".".join(map(str, branch)) or _ROOT


def _distinct(items: Iterable) -> tuple[tuple, NDArray[np.int64]]:
    """The different items, and the index of each among them."""
    listed = list(items)
    index_of = {item: index for index, item in enumerate(dict.fromkeys(listed))}
    return tuple(index_of), np.array([index_of[item] for item in listed], dtype=np.int64)


class _AcceptingSearch:
    def __init__(
        self,
        program: Program,
        acceptance: Acceptance,
        lots: Lots,
        assets: AssetFolder | None,
        enough_tries: int,
        leaves: bool,
    ) -> None:
        self.program, self.acceptance, self.lots, self.assets = program, acceptance, lots, assets
        self.enough_tries, self.leaves = enough_tries, leaves
        self.tries = np.zeros(len(lots), dtype=np.int64)
        self.chunks: list[tuple[Ints, Forest]] = []
        """Models, and their candidates that were kept."""
        self.best = np.zeros((2, len(lots)))
        """Probability and number of the nearest candidate of each model."""

    def run(self) -> Accepted:
        num, enough = len(self.lots), self.enough_tries
        waiting = self._search(np.arange(num), 0, enough)
        possible = self.best[0, waiting] > 0.0
        # If no candidate of any model has a probability above 0, fewer are made for each of many models.
        most = _RARE_FACTOR * enough if self.best[0].any() else max(enough, _RARE_FACTOR * enough // num)
        rare = self._search(waiting[~possible], enough, most)
        self._settle(waiting[possible], enough)
        self._settle(rare, most)
        order = np.concatenate([models for models, _ in self.chunks])
        forest = join_forests([forest for _, forest in self.chunks])
        model = order.astype(forest.nodes.model.dtype)[forest.nodes.model]
        is_accepted = np.ones(num, dtype=bool)
        is_accepted[waiting[possible]] = is_accepted[rare] = False
        return Accepted(
            replace(forest, lots=self.lots, nodes=replace(forest.nodes, model=model)), self.tries, is_accepted
        )

    def _search(self, waiting: Ints, first: int, end: int) -> Ints:
        """Look for accepted candidates of models.

        Args:
            waiting: the models.
            first: number of their first candidate.
            end: number after the last one.

        Returns:
            Models without an accepted candidate.
        """
        num = 1
        while len(waiting) and first < end:
            num = min(num, end - first)
            for models in np.array_split(waiting, -(-len(waiting) * num // BATCH)):
                self._try(models, first, num)
            waiting = waiting[self.tries[waiting] == 0]
            first += num
            # The number doubles each time, as long as the candidates of a round fit into a few chunks.
            num = max(1, min(2 * num, BATCH // max(1, len(waiting))))
        return waiting

    def _try(self, models: Ints, first: int, num: int) -> None:
        """Make candidates of models, in the order of their numbers."""
        for candidates, index in self._derived(models, first, num):
            number, model = np.divmod(index, len(models))
            model, number = models[model], number + first
            chances = self.acceptance.probabilities(candidates)
            draws = self._draws(model, number)
            self._note(model, number, chances / np.maximum(draws, 1e-300))
            rows = np.flatnonzero((draws < chances) & (self.tries[model] == 0))
            rows = np.sort(rows[np.unique(model[rows], return_index=True)[1]])
            if len(rows):
                self.tries[model[rows]] = number[rows] + 1
                self.chunks.append((model[rows], select_models(candidates, rows)))

    def _derived(self, models: Ints, first: int, num: int) -> Iterator[tuple[Forest, Ints]]:
        """Candidates in chunks, and the index of each in the sequence of all."""
        lots = self.lots.take(np.tile(models, num))
        numbers = np.repeat(np.arange(first, first + num), len(models))
        done = 0
        for forest in derive_chunks(self.program, _candidates(lots, numbers), assets=self.assets, leaves=self.leaves):
            yield forest, np.arange(done, done + forest.num_models)
            done += forest.num_models

    def _draws(self, models: Ints, numbers: Ints) -> Floats:
        lots = self.lots
        keys = root_keys(_seeds(lots.seed[models], numbers), lots.model[models])
        return uniforms(fold(keys, _DECISIONS), 0)

    def _note(self, model: Ints, number: Ints, near: Floats) -> None:
        """Record the candidates with the highest probability; of equal ones the first."""
        for row in np.flatnonzero(near > self.best[0, model]).tolist():
            if near[row] > self.best[0, model[row]]:
                self.best[:, model[row]] = near[row], number[row]

    def _settle(self, models: Ints, tries: int) -> None:
        """Take the nearest candidates of models without accepted candidates, after a number of tries."""
        hopeless = models[self.best[0, models] <= 0.0]
        if len(hopeless):
            raise GrammarlabError(
                f"the acceptance rule keeps none of {tries:,} candidates of {self.lots.name(int(hopeless[0]))}, nor "
                "would it keep them more often: expected a rule that keeps about one model in 1,000 or more. Learn the "
                "file again, or change its @Acceptance"
            )
        if len(models):
            self.tries[models] = tries
            lots = _candidates(self.lots.take(models), self.best[1, models].astype(np.int64))
            self.chunks.append((models, derive(self.program, lots, assets=self.assets, leaves=self.leaves)))


def _candidates(lots: Lots, numbers: Ints) -> Lots:
    """Lots [n] with the seeds of their candidates of these numbers [n]."""
    return replace(lots, seed=_seeds(lots.seed, numbers))


def _seeds(seeds: NDArray[np.uint64], numbers: Ints) -> NDArray[np.uint64]:
    return np.where(numbers == 0, seeds, fold(fold(seeds, _CANDIDATES), numbers))
