"""Learning from finished models: the maximum-likelihood grammar near a given one.

Nothing but the examples shows which choices matter. Symbols are split by the edge above them if their choices differ
between edges. With S tied, probabilities are shrunk towards the grammar and those of choices that probably do not
matter are unchanged (`levels.py`); some choices depend on the branch of another one (`blocks.py`). With many examples,
a mixture from EM is used if it explains held-out examples better. With *structure*, all choices are learned, by EM
alone; with *parameters* too, but nothing is split, and one component has the frequencies of the examples. Otherwise,
differences must justify their number of parameters by the Bayesian information criterion (Schwarz, Estimating the
dimension of a model, 1978).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

import numpy as np
from scipy import sparse
from scipy.special import xlogy

from grammarlab.arrays import Flags, Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.density.exact.attributes import AttributeParts, attribute_parts, drawn_range, parts_taken
from grammarlab.density.exact.automaton import InexactError
from grammarlab.density.exact.contexts import Contexts, NoContext, ParentEdges
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.grammar_skeleton import TreeGrammar
from grammarlab.density.rounding import learnable_step
from grammarlab.density.samples.blocks import BlockFit, Gated, dependent_choices, fit_blocks, gated
from grammarlab.density.samples.choices import Choices
from grammarlab.density.samples.levels import Shrinkage
from grammarlab.density.samples.mixture import HELD_OUT_STRIDE, SMOOTHING, Cells, Mixture, fit_mixture
from grammarlab.density.samples.sampled import written
from grammarlab.density.targets.target import Target
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Below, Pattern, Threshold
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import SymbolKey

ExampleMethod: TypeAlias = Literal["tied", "structure", "parameters"]
EXAMPLE_METHODS: tuple[ExampleMethod, ...] = get_args(ExampleMethod)

_BINS = (1, 2, 4, 8, 16)
"""Numbers of equal ranges into which a drawn number may be cut."""
_NUM_RANGES = _BINS[-1]
"""Number of ranges of a drawn number if probabilities are shrunk."""
_MIN_HELD_OUT_EXAMPLES = 50
"""Number of examples from which some are held out to judge a mixture."""
_MAX_GROWTH = 2
"""Largest ratio of the number of rules to that of the original grammar, if any of the candidates satisfies it."""
_EXTRA_DERIVATIONS = 20.0
"""Number of assumed additional derivations in the BIC, since a few examples are weak evidence."""


def learn_from_examples(
    grammar: Grammar,
    forest: Forest,
    method: ExampleMethod = "tied",
    *,
    weights: Floats | None = None,
    header: Sequence[str] = (),
    assets: AssetRoot | None = None,
) -> LearnedGrammar:
    """The maximum-likelihood grammar of some models, among those near a grammar that can derive them.

    Args:
        grammar: the original grammar.
        forest: the models, as trees of that grammar.
        method: ``tied``, ``structure`` or ``parameters``, as described at the top of this module.
        weights: [models] weight of each model, finite and >= 0; 1 by default.
        header: lines of a comment at the top of the new file.
        assets: folder of meshes and images.

    Raises:
        UsageError: If there are no models, all weights are 0, or models are of another grammar.
    """
    mass = np.ones(forest.num_models) if weights is None else np.asarray(weights, dtype=np.float64)
    _check(grammar, forest, mass)
    bins = (_NUM_RANGES,) if method == "tied" else _BINS
    attributes = [parts for name in grammar.attributes if (parts := _histogram(grammar, name, forest, mass, bins))]
    tree = TreeGrammar.of(grammar).observed(forest)
    plain = Choices.of(Contexts.of(tree, NoContext()), attributes)
    fits = [_fitted(plain, grammar, forest, mass, method)]
    split = _split_symbols(grammar, tree, forest, mass) if method != "parameters" else []
    if split:
        patterns = [Pattern(below=(Below((Pattern(symbol=name),)),)) for name, _ in split]
        contexts = Contexts.of(tree, ParentEdges(tree, patterns))
        candidate = _fitted(Choices.of(contexts, attributes), grammar, forest, mass, method)
        fits.append(
            replace(candidate, criterion=candidate.criterion - len(split) * np.log(2.0 * max(len(tree.bodies), 1)))
        )
    fits.sort(key=lambda fit: -fit.criterion)
    if method == "tied":
        # The smallest candidate: no choice depends on another one.
        fits.append(_fitted(plain, grammar, forest, mass, method, together=False))
    target = Target(grammar, (), lambda values: np.ones(len(values)), assets=assets)
    of_examples = "1 example" if forest.num_models == 1 else f"{forest.num_models:,} examples"
    step = learnable_step(forest.num_models)
    for fit in fits:
        findings = (
            f"choices learned from {of_examples}: {fit.learned} of {fit.number}",
            f"components: {len(fit.mixture.weights)}",
            f"on average, an example is {np.exp(fit.mean_log_ratio):.3g} times as likely as before",
        )
        learned = written(target, fit.choices, fit.mixture, method, 1.0, findings, header, step)
        if method != "tied" or fit is fits[-1] or learned.rules_after <= _MAX_GROWTH * learned.rules_before:
            return learned
    raise AssertionError("there is always a last candidate")


@dataclass(frozen=True, slots=True)
class _Fit:
    """Result of learning for one way of splitting symbols."""

    choices: Choices
    mixture: Mixture
    number: int
    """Number of choices."""
    mean_log_ratio: float
    """Mean log of the density divided by the original density, in nats."""
    criterion: float
    """Sum of `mean_log_ratio` over all examples, minus the BIC penalty of the parameters, in nats."""

    @property
    def learned(self) -> int:
        """Number of learned choices."""
        return len(np.unique(self.choices.choice))


def _fitted(
    choices: Choices, grammar: Grammar, forest: Forest, weights: Floats, method: ExampleMethod, *, together: bool = True
) -> _Fit:
    number, counts = int(choices.choice.max(initial=-1)) + 1, choices.count(grammar, forest)
    cells = Cells(choices.original, choices.choice)
    if method == "tied" and number:
        mixture, evidence = _tied(choices, counts, weights, choices.extents(forest, weights), together)
        chosen = np.zeros(number, dtype=bool)
        chosen[cells.choice[(mixture.probabilities != cells.original).any(axis=0)]] = True
        choices = _only(choices, chosen)
        mixture = Mixture(mixture.weights, mixture.probabilities[:, chosen[cells.choice]])
        counts = counts[:, chosen[cells.choice]]
        return _Fit(choices, mixture, number, _mean_log_ratio(choices, mixture, counts, weights), evidence)
    if method == "structure":
        fit = fit_blocks(cells, counts, weights, dependent_choices(cells, counts, weights))
    else:
        fit = BlockFit(fit_mixture(cells, counts, weights, np.zeros(len(weights), dtype=np.int64)).mixture, 0)
    mean_log_ratio = _mean_log_ratio(choices, fit.mixture, counts, weights)
    total = float(weights.sum())
    return _Fit(
        choices,
        fit.mixture,
        number,
        mean_log_ratio,
        total * mean_log_ratio - 0.5 * fit.num_parameters * np.log(total + _EXTRA_DERIVATIONS),
    )


def _mean_log_ratio(choices: Choices, mixture: Mixture, counts: sparse.csr_array, weights: Floats) -> float:
    counted = weights > 0.0
    ratio = mixture.log_ratio(Cells(choices.original, choices.choice), counts)
    return float(weights[counted] @ ratio[counted]) / float(weights.sum())


def _tied(
    choices: Choices, counts: sparse.csr_array, weights: Floats, extents: Floats, together: bool
) -> tuple[Mixture, float]:
    """A mixture of shrunk probabilities, and the log-evidence for it."""
    fit = _shrunk(choices, counts, weights, extents, together)
    if not together or len(weights) < _MIN_HELD_OUT_EXAMPLES:
        return fit.mixture, fit.evidence
    cells, is_held_out = (
        Cells(choices.original, choices.choice),
        np.arange(len(weights)) % HELD_OUT_STRIDE == HELD_OUT_STRIDE - 1,
    )
    rivals = (
        _shrunk(choices, counts[~is_held_out], weights[~is_held_out], extents, True).mixture,
        _by_em(cells, counts[~is_held_out], weights[~is_held_out]),
    )
    shrunk_ratios, em_ratios = (
        weights[is_held_out] * mixture.log_ratio(cells, counts[is_held_out]) for mixture in rivals
    )
    gain = em_ratios - shrunk_ratios
    # The rule of one standard error: smaller gains may be random.
    if gain.sum() <= np.sqrt(len(gain)) * gain.std() or not weights[~is_held_out].any():
        return fit.mixture, fit.evidence
    return _by_em(cells, counts, weights), fit.evidence + float(gain.sum()) * HELD_OUT_STRIDE


def _by_em(cells: Cells, counts: sparse.csr_array, weights: Floats) -> Mixture:
    """A mixture of the informative choices, mixed with a little of the original grammar."""
    chosen = _informative(cells, counts, weights)[cells.choice]
    informative_cells = Cells(
        cells.original[chosen], np.unique(cells.choice[chosen], return_inverse=True)[1].reshape(-1)
    )
    informative_counts = sparse.csr_array(counts[:, chosen])
    fit = fit_blocks(
        informative_cells,
        informative_counts,
        weights,
        dependent_choices(informative_cells, informative_counts, weights),
    ).mixture
    share = (SMOOTHING / (fit.weights * weights.sum() + SMOOTHING))[:, None]
    probabilities = np.repeat(cells.original[None], len(fit.weights), axis=0)
    probabilities[:, chosen] = (1.0 - share) * fit.probabilities + share * informative_cells.original
    return Mixture(fit.weights, probabilities)


def _shrunk(choices: Choices, counts: sparse.csr_array, weights: Floats, extents: Floats, together: bool) -> Gated:
    """Shrunk probabilities for few examples."""
    cells, number = Cells(choices.original, choices.choice), int(choices.choice.max(initial=-1)) + 1
    drawn, ordered = np.zeros(number, dtype=bool), np.zeros(number, dtype=bool)
    for parts, first in zip(choices.attributes, choices.first_of_attribute, strict=True):
        drawn[choices.choice[first]] = True
        ordered[choices.choice[first]] = bool(np.isfinite(parts.parts[0].low)) or len(parts.parts) > _NUM_RANGES
    shrinkage = Shrinkage.of(cells, ordered, drawn, counts, weights, extents)
    if not together:
        mixture = Mixture(np.ones(1), shrinkage.probabilities[None])
        return Gated(mixture, float(shrinkage.evidence.sum()))
    return gated(shrinkage, counts, weights, ordered)


def _check(grammar: Grammar, forest: Forest, weights: Floats) -> None:
    program = compile_grammar(grammar)
    if (program.symbols, program.rule_names) != (forest.symbols, forest.rules):
        raise UsageError("the examples are not models of this grammar: its symbols or rules differ")
    if weights.shape != (forest.num_models,) or not np.isfinite(weights).all() or (weights < 0.0).any():
        raise UsageError(f"expected a weight for each of {forest.num_models} examples, finite and at least 0")
    if not weights.any():
        raise UsageError("expected examples to learn from, found none with a weight above 0")


def _histogram(
    grammar: Grammar, name: str, forest: Forest, weights: Floats, numbers: Sequence[int]
) -> AttributeParts | None:
    """The parts of a drawn attribute, a number cut into as many ranges as the examples justify.

    None if it is not drawn, or has a given value in some examples.
    """
    sites = [i for i, site in enumerate(forest.sites) if site.definition == name]
    drawn = forest.nodes.model[forest.draws.node[np.isin(forest.draws.site, sites)]]
    if len(np.unique(drawn)) < forest.num_models:
        return None
    ends = drawn_range(grammar.attributes[name].value)
    best, chosen = -np.inf, None
    for bins in numbers if ends is not None else (1,):
        cuts = np.linspace(*ends, bins + 1)[1:-1].tolist() if ends is not None else []
        try:
            parts = attribute_parts(grammar, name, [Threshold(name, cut) for cut in cuts])
        except InexactError:
            return None
        counts = np.bincount(parts_taken(parts, grammar, forest), weights=weights, minlength=len(parts.parts))
        gain = _gain(counts.astype(np.float64), parts.probabilities)
        if gain > best:
            best, chosen = gain, parts
    return chosen if chosen is not None and len(chosen.parts) > 1 else None


def _gain(counts: Floats, original: Floats) -> float:
    """Gain of own probabilities in likelihood over the original ones, minus their BIC penalty."""
    total = counts.sum()
    likelihood = float((xlogy(counts, counts) - xlogy(counts, np.where(counts > 0.0, original, 1.0))).sum())
    return likelihood - float(xlogy(total, total)) - 0.5 * (len(counts) - 1) * float(np.log(total + _EXTRA_DERIVATIONS))


def _split_symbols(grammar: Grammar, tree: TreeGrammar, forest: Forest, weights: Floats) -> list[SymbolKey]:
    """The symbols whose choices differ between the edges above them."""
    anywhere = Pattern(below=(Below((Pattern(),)),))
    choices = Choices.of(Contexts.of(tree, ParentEdges(tree, [anywhere])))
    total = np.asarray(weights @ choices.count(grammar, forest))
    tables: dict[SymbolKey, dict[tuple[int, ...], list[Floats]]] = {}
    for (symbol, path), first in choices.first.items():
        cell_counts = total[first : first + int((choices.choice == choices.choice[first]).sum())]
        tables.setdefault(choices.contexts.symbols[symbol][0], {}).setdefault(path, []).append(cell_counts)
    symbols: list[SymbolKey] = []
    for key, by_path in tables.items():
        gain = 0.0
        for rows in by_path.values():
            used_rows = [row for row in rows if row.any()]
            gain += (
                sum(_gain(row, np.sum(used_rows, axis=0) / np.sum(used_rows)) for row in used_rows)
                if len(used_rows) > 1
                else 0.0
            )
        if gain > 0.0:
            symbols.append(key)
    return symbols


def _informative(cells: Cells, counts: sparse.csr_array, weights: Floats) -> Flags:
    """[choices] whether each differs from the grammar, or is correlated with others."""
    size = int(cells.choice.max(initial=-1)) + 1
    total = np.asarray(weights @ counts)
    chosen = np.array([_gain(total[cells.choice == i], cells.original[cells.choice == i]) > 0.0 for i in range(size)])
    return chosen.astype(bool) | dependent_choices(cells, counts, weights).any(axis=1)


def _only(choices: Choices, chosen: Flags) -> Choices:
    """The selected choices."""
    rules = {key for key, first in choices.first.items() if chosen[choices.choice[first]]}
    pairs = zip(choices.attributes, choices.first_of_attribute, strict=True)
    attributes = [parts for parts, first in pairs if chosen[choices.choice[first]]]
    return Choices.of(choices.contexts, attributes, lambda symbol, chance: (symbol, chance.path) in rules)
