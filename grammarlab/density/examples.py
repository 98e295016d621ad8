"""Learning from finished models: the grammar that is likeliest to have made them.

Nobody says what matters, so the examples must. With S tied, a choice is learned where its branches occur with other
frequencies than in the grammar, or where they go with those of another choice; all others stay. With *structure*,
symbols are moreover split by the edge above them where their choices differ between edges. How many components the
mixture has, held-out examples decide. Differences must be worth their numbers by the Bayesian information criterion
(Schwarz, Estimating the dimension of a model, 1978).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.special import xlogy

from grammarlab.density.attributes import AttributeParts, attribute_parts, drawn_range, parts_taken
from grammarlab.density.automaton import InexactError
from grammarlab.density.choices import Choices
from grammarlab.density.contexts import Contexts, NoContext, ParentEdges
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.mixture import Cells, dense, fit_mixture
from grammarlab.density.sampled import Sample, chosen_components, kinds, written
from grammarlab.density.skeleton import SymbolKey, TreeGrammar
from grammarlab.density.target import Target
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.features.pattern import Below, Pattern, Threshold
from grammarlab.language.grammar import Grammar

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
ExampleMethod: TypeAlias = Literal["structure", "tied"]

_BINS = (1, 2, 4, 8, 16)
"""Into how many equal ranges a drawn number may be cut."""
_FEW = 20.0
"""So many more derivations are assumed when numbers are weighed: a handful of examples proves little."""
_TOGETHER = 5.0
"""Standard deviations from which on two choices go together."""


def learn_from_examples(
    grammar: Grammar,
    forest: Forest,
    method: ExampleMethod = "tied",
    *,
    weights: Floats | None = None,
    header: Sequence[str] = (),
    assets: Path | None = None,
) -> LearnedGrammar:
    """The grammar that is likeliest to have made some models, among those near a grammar that can make them.

    Args:
        grammar: the original grammar.
        forest: the models, as trees of that grammar.
        method: see the head of this file.
        weights: [models] how much each counts, finite and >= 0; 1 by default.
        header: lines of a comment at the top of the new file.
        assets: folder of meshes and images.

    Raises:
        UsageError: for no models, weights that are none, or models of another grammar.
    """
    mass = np.ones(forest.num_models) if weights is None else np.asarray(weights, dtype=np.float64)
    _check(grammar, forest, mass)
    attributes = [found for name in grammar.attributes if (found := _histogram(grammar, name, forest, mass))]
    tree = TreeGrammar.of(grammar).observed(forest)
    plain = Choices.of(Contexts.of(tree, NoContext()), attributes)
    if method == "structure":
        split = _split_symbols(grammar, tree, forest, mass)
        patterns = [Pattern(below=(Below((Pattern(symbol=name),)),)) for name, _ in split]
        plain = Choices.of(Contexts.of(tree, ParentEdges(tree, patterns)), attributes)
    counts = plain.count(grammar, forest)
    chosen = _informative(Cells(plain.original, plain.choice), counts, mass)
    choices = _only(plain, chosen)
    cells = Cells(choices.original, choices.choice)
    counts = choices.count(grammar, forest)
    sample = Sample(counts, np.zeros((len(mass), 0)), np.zeros((len(mass), 0)), mass)
    fit = fit_mixture(cells, counts, mass, chosen_components(cells, sample, [kinds(counts)]))
    number, of = len(np.unique(choices.choice)), int(plain.choice.max(initial=-1)) + 1
    likelier = np.exp(fit.log_likelihoods[-1])
    findings = (
        f"learned from {forest.num_models:,} examples: {number} of {of} choices, {len(fit.mixture.weights)} components",
        f"on average, an example is {likelier:.3g} times as likely as before",
    )
    target = Target(grammar, (), lambda values: np.ones(len(values)), assets=assets)
    return written(target, choices, fit.mixture, f"examples ({method})", 1.0, findings, header)


def _check(grammar: Grammar, forest: Forest, weights: Floats) -> None:
    program = compile_grammar(grammar)
    if (program.symbols, program.rule_names) != (forest.symbols, forest.rules):
        raise UsageError("the examples are not models of this grammar: its symbols or rules are others")
    if weights.shape != (forest.num_models,) or not np.isfinite(weights).all() or (weights < 0.0).any():
        raise UsageError(f"expected a weight for each of {forest.num_models} examples, finite and at least 0")
    if not weights.any():
        raise UsageError("expected examples to learn from, found none that counts")


def _histogram(grammar: Grammar, name: str, forest: Forest, weights: Floats) -> AttributeParts | None:
    """The parts of a drawn attribute, a number cut into as many ranges as the examples justify; None without draws."""
    ends = drawn_range(grammar.attributes[name].value)
    best, chosen = -np.inf, None
    for bins in _BINS if ends is not None else (1,):
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
    """What own probabilities gain in likelihood over the original ones, less what they are worth by BIC."""
    total = counts.sum()
    likelihood = float((xlogy(counts, counts) - xlogy(counts, np.where(counts > 0.0, original, 1.0))).sum())
    return likelihood - float(xlogy(total, total)) - 0.5 * (len(counts) - 1) * float(np.log(total + _FEW))


def _split_symbols(grammar: Grammar, tree: TreeGrammar, forest: Forest, weights: Floats) -> list[SymbolKey]:
    """The symbols whose choices differ between the edges above them."""
    anywhere = Pattern(below=(Below((Pattern(),)),))
    choices = Choices.of(Contexts.of(tree, ParentEdges(tree, [anywhere])))
    total = np.asarray(weights @ choices.count(grammar, forest))
    tables: dict[SymbolKey, dict[tuple[int, ...], list[Floats]]] = {}
    for (symbol, path), first in choices.first.items():
        own = total[first : first + int((choices.choice == choices.choice[first]).sum())]
        tables.setdefault(choices.contexts.symbols[symbol][0], {}).setdefault(path, []).append(own)
    found: list[SymbolKey] = []
    for key, by_path in tables.items():
        gain = 0.0
        for rows in by_path.values():
            made = [row for row in rows if row.any()]
            gain += sum(_gain(row, np.sum(made, axis=0) / np.sum(made)) for row in made) if len(made) > 1 else 0.0
        if gain > 0.0:
            found.append(key)
    return found


def _informative(cells: Cells, counts: sparse.csr_array, weights: Floats) -> Flags:
    """Which choices [choices] are made otherwise than in the grammar, or go together with others."""
    size = int(cells.choice.max(initial=-1)) + 1
    total = np.asarray(weights @ counts)
    chosen = np.array([_gain(total[cells.choice == i], cells.original[cells.choice == i]) > 0.0 for i in range(size)])
    table = dense(counts)
    spread = np.zeros((size, len(cells.choice)))
    spread[cells.choice, np.arange(len(cells.choice))] = 1.0
    # How far each count is from what is expected where the choice is made: without correlation in a grammar.
    rest = (table - (table @ spread.T @ spread) * cells.normalised(total[None])) * np.sqrt(weights)[:, None]
    product, scale = rest.T @ rest, (rest**2).T @ (rest**2)
    score = np.abs(product) / np.sqrt(np.where(scale > 0.0, scale, np.inf))
    score[cells.choice[:, None] == cells.choice[None]] = 0.0
    together = np.bincount(cells.choice, weights=score.max(axis=1, initial=0.0) > _TOGETHER, minlength=size) > 0.0
    return chosen.astype(bool) | together


def _only(choices: Choices, chosen: Flags) -> Choices:
    """The choices that are chosen."""
    rules = {place for place, first in choices.first.items() if chosen[choices.choice[first]]}
    pairs = zip(choices.attributes, choices.first_of_attribute, strict=True)
    attributes = [parts for parts, first in pairs if chosen[choices.choice[first]]]
    return Choices.of(choices.contexts, attributes, lambda symbol, chance: (symbol, chance.path) in rules)
