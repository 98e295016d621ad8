"""Grammar near a target density: exact, of ranges, or learned from samples with parameters, structure or S tied.

Section 4.6 of the paper. Models are drawn from the target density; their branches are counted; a mixture of
grammars is fitted to the counts. The methods differ in how symbols are split and in which choices are learned:

- *parameters*: no symbol is split, all choices are learned, one component;
- *structure*: symbols that relevant features name are split by the edges above them, all choices are learned, one
  component for each cluster of models that the preference hardly distinguishes;
- *tied*: only choices that the features can depend on are learned, all others do not change in any component;
  the number of components is the one that explains held-out models best. All
  other choices are independent of a preference that reads counts, so nothing is lost, and far fewer parameters are
  estimated.

`compile_nearest` takes an exact grammar if there is one, and otherwise states the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from scipy import sparse

from grammarlab.arrays import MANY, NUM_LEVELS, Floats, Ints
from grammarlab.density.exact.attributes import AttributeFeature, AttributeParts, attribute_parts
from grammarlab.density.exact.contexts import Contexts, NoContext, OpenPatterns, ParentEdges
from grammarlab.density.exact.grammar_text import Origin, write
from grammarlab.density.exact.inside import InsideWeights
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.grammar_skeleton import TreeGrammar
from grammarlab.density.rounding import EXACT
from grammarlab.density.samples.choices import Choices, relevant_choices
from grammarlab.density.samples.mixing import ContextNames, as_splitting
from grammarlab.density.samples.mixture import (
    HELD_OUT_STRIDE,
    SMOOTHING,
    Cells,
    Mixture,
    cluster,
    dense,
    fit_mixture,
    merged,
)
from grammarlab.density.targets.ranges import even_cuts, range_ends, with_ranges
from grammarlab.density.targets.rejection import MAX_PROPOSALS, Progress, silent
from grammarlab.density.targets.target import Target
from grammarlab.density.targets.target_samples import Candidates, draw
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.selection import select_models
from grammarlab.errors import InexactError, UsageError
from grammarlab.features.patterns.conditions import patterns_of
from grammarlab.features.patterns.pattern import Draw, Threshold

Method: TypeAlias = Literal["parameters", "structure", "tied"]
Header = Callable[[str], Sequence[str]]
"""Function from the name of a method to the comment lines at the top of a file."""
METHODS: tuple[Method, ...] = get_args(Method)
NUM_SAMPLES = 5_000
"""Default number of models to learn from, as in the paper."""
MAX_COMPONENTS = 128
"""Largest number of components at the start."""
_EM_TOLERANCE = 1e-4
"""Tolerance of EM, in nats, when mixtures are only compared."""
_MIN_GAIN = 1.0
"""Smallest gain of another component in nats, over all held-out models."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Sample of models to learn from."""

    counts: sparse.csr_array
    """[N, A] counts of the cells of choices."""
    features: Floats
    """[N, F] the features, scaled by their relevance."""
    reads: Floats
    """[N, R] readings of the preference: sums and capped counts."""
    weights: Floats
    """[N] weight of each model."""


def compile_nearest(
    target: Target,
    forest: Forest,
    header: Header = lambda method: (),
    *,
    num_samples: int = NUM_SAMPLES,
    seed: int = 0,
    on_progress: Progress = silent,
) -> LearnedGrammar:
    """Exact grammar of a density; otherwise one of sub-ranges or from samples, with a finding that states the reason.

    Args:
        target: the target density.
        forest: derivations of its grammar that show how often successors inside blocks occur.
        header: header of the new file.
        num_samples: number of samples if there is no exact grammar.
        seed: seed of these samples.
        on_progress: called with the progress of these samples.

    Raises:
        GrammarlabError: If the preference is 0 for every model.
    """
    try:
        return target.compiled(forest, header("compile"))
    except InexactError as error:
        reason = str(error)
    nearer = _with_ranges(target, forest, header("ranges"))
    if nearer is not None:
        return _explained(nearer, "numbers are drawn from ranges instead", reason)
    learned = learn(target, "tied", num_samples=num_samples, seed=seed, header=header("tied"), on_progress=on_progress)
    return _explained(learned, "one was learned from samples instead", reason)


def learn(
    target: Target,
    method: Method,
    *,
    num_samples: int = NUM_SAMPLES,
    seed: int = 0,
    relevance: Floats | None = None,
    num_components: int | None = None,
    most_proposals: int = MAX_PROPOSALS,
    header: Sequence[str] = (),
    on_progress: Progress = silent,
) -> LearnedGrammar:
    """A grammar whose density is near a target density, learned from samples of it.

    Args:
        target: the target density.
        method: ``parameters``, ``structure`` or ``tied``, as described at the top of this module.
        num_samples: models to learn from.
        seed: seed of the samples.
        relevance: [features] factors of the features of the target that make differences comparable; 1 by
            default.
        num_components: largest number of components of the mixture; by default that of the method.
        most_proposals: largest number of proposed models for the samples.
        header: lines of a comment at the top of the new file.
        on_progress: called with the number of drawn models.

    Raises:
        UsageError: If there is less than one sample or component.
        GrammarlabError: If the preference is 0 for all drawn models.
    """
    if num_samples < 1 or (num_components is not None and num_components < 1):
        raise UsageError(f"expected at least one sample and one component, found {num_samples} and {num_components}")
    even = target.even
    if even is not None:
        _check_attributes(even)
        target = replace(target, grammar=even.grammar, base="grammar")
    learner = _Learner(target, method, relevance)
    drawn = draw(target, learner.keep, num_samples, seed, most_proposals=most_proposals, on_progress=on_progress)
    mixture = learner.fit(learner.sample(drawn.chunks), num_components)
    findings = [drawn.finding, *learner.findings]
    if drawn.num_models < num_samples:
        findings.append(f"only {drawn.num_models:,} models to learn from, {num_samples:,} were requested")
    learned = written(target, learner.choices, mixture, method, drawn.mean_preference, findings, header)
    return learned if even is None else _composed(even, learned)


def chosen_components(cells: Cells, sample: Sample, clusters: Sequence[Ints]) -> Ints:
    """Fewest components with which one part of a sample explains the rest as well as any, up to chance.

    Args:
        cells: cells of the learned choices.
        sample: the models.
        clusters: initial clusters [N] of each clustering; they are merged pairwise.

    Returns:
        [N] the component that each model belongs to most.
    """
    is_held_out = np.arange(len(sample.weights)) % HELD_OUT_STRIDE == HELD_OUT_STRIDE - 1
    if not is_held_out.any() or not sample.weights[is_held_out].any():
        return np.zeros(len(is_held_out), dtype=np.int64)
    counts, weights = sample.counts[~is_held_out], sample.weights[~is_held_out]
    candidates: list[tuple[int, Floats, Ints]] = []
    paths = (
        merged(cells, counts, weights, _consecutive(initial[~is_held_out]), MAX_COMPONENTS) for initial in clusters
    )
    for labels in chain.from_iterable(paths):
        if not _is_candidate(int(labels.max()) + 1):
            continue
        fit = fit_mixture(cells, counts, weights, labels, _EM_TOLERANCE)
        mixture = _smoothed(cells, fit.mixture, float(weights.sum()))
        log_joint = mixture.log_ratios(cells, sample.counts)
        explained = sample.weights[is_held_out] * np.logaddexp.reduce(log_joint[is_held_out], axis=1)
        candidates.append((len(mixture.weights), explained, _consecutive(log_joint.argmax(axis=1))))
    best = max(candidates, key=lambda candidate: float(candidate[1].sum()))[1]
    # One-standard-error rule: smaller differences may be chance.
    near = [
        candidate for candidate in candidates if (best - candidate[1]).sum() <= _spread(best - candidate[1]) + _MIN_GAIN
    ]
    return min(near, key=lambda candidate: (candidate[0], -float(candidate[1].sum())))[2]


def kinds(counts: sparse.csr_array) -> Ints:
    """Clusters [N] of models that took all choices alike."""
    table = dense(counts)
    if not table.shape[1]:
        return np.zeros(len(table), dtype=np.int64)
    return np.unique(table, axis=0, return_inverse=True)[1].reshape(-1)


def written(
    target: Target,
    choices: Choices,
    mixture: Mixture,
    method: str,
    mean_preference: float,
    findings: Sequence[str],
    header: Sequence[str],
    step: float = EXACT,
) -> LearnedGrammar:
    """The grammar of a mixture, with probabilities that are multiples of a step."""
    splitting = as_splitting(choices, mixture)
    result = write(target.grammar, splitting, InsideWeights(splitting), header, ContextNames, step)
    return LearnedGrammar(
        text=result.text,
        original=target.grammar,
        method=method,
        base="grammar",
        origins=result.origins,
        start=result.start,
        components=result.components,
        attributes=choices.attributes,
        mean_preference=mean_preference,
        findings=tuple(findings),
        assets=target.assets,
    )


def _with_ranges(target: Target, forest: Forest, header: Sequence[str]) -> LearnedGrammar | None:
    """Grammar of the narrowest sub-ranges that is not too large; None if drawn numbers are not the reason."""
    number = MANY
    while number > 1:
        try:
            reads, preference = with_ranges(target.grammar, target.reads, target.preference, number)
            if preference is target.preference:
                return None
            learned = replace(target, reads=reads, preference=preference).compiled(forest, header)
        except InexactError:
            number //= 2
            continue
        return replace(learned, method="ranges")
    return None


def _explained(learned: LearnedGrammar, what: str, reason: str) -> LearnedGrammar:
    return replace(learned, findings=(f"no exact grammar, so {what}: {reason}", *learned.findings))


def _check_attributes(even: LearnedGrammar) -> None:
    """Check that the evened grammar has the original drawn attributes."""
    for parts in even.attributes:
        if even.grammar.attributes[parts.name].value != even.original.attributes[parts.name].value:
            raise UsageError(f"an even base also evens out how {parts.name} is chosen: use the method compile")


class _Learner:
    """Choices to learn of a grammar, and the sample to learn from."""

    def __init__(self, target: Target, method: Method, relevance: Floats | None) -> None:
        self.target = target
        self.relevance = np.ones(len(target.features)) if relevance is None else relevance
        self.method = method
        self.findings: list[str] = []
        self.choices = self._choices(TreeGrammar.of(target.grammar).observed(target.first_look))
        self.cells = Cells(self.choices.original, self.choices.choice)

    def _choices(self, tree: TreeGrammar) -> Choices:
        attributes = self._attributes()
        if self.method == "parameters":
            return Choices.of(Contexts.of(tree, NoContext()), attributes)
        if self.method == "structure":
            return Choices.of(Contexts.of(tree, ParentEdges(tree, self.target.patterns)), attributes)
        contexts = Contexts.of(tree, opened := OpenPatterns(tree, self.target.patterns))
        return Choices.of(contexts, attributes, relevant_choices(contexts, opened))

    def _attributes(self) -> list[AttributeParts]:
        """Parts of the attributes that features read."""
        named: dict[str, list[AttributeFeature]] = {}
        for feature in self.target.features:
            if isinstance(feature, Threshold | Draw):
                named.setdefault(feature.site, []).append(feature)
        parts: list[AttributeParts] = []
        grammar = self.target.grammar
        for name, features in named.items():
            bounds = [feature for feature in features if isinstance(feature, Threshold)]
            by_value = range_ends(grammar, name) and len(bounds) < len(features)
            try:
                cuts = even_cuts(grammar, name, NUM_LEVELS, bounds) if by_value else features
                parts.append(attribute_parts(grammar, name, cuts))
            except InexactError as error:
                self.findings.append(f"${name} keeps its density: {error}")
        return parts

    def keep(self, models: Candidates, rows: Ints) -> _ModelData:
        """Fit from some of the models."""
        counts = self.choices.count(self.target.grammar, select_models(models.forest, rows))
        return _ModelData(counts, models.values[rows])

    def sample(self, chunks: Sequence[tuple[_ModelData, Ints]]) -> Sample:
        """The models to learn from: some rows of each chunk."""
        target = self.target
        counts = sparse.csr_array(sparse.vstack([data.counts[rows] for data, rows in chunks]))
        values = np.concatenate([data.values[rows] for data, rows in chunks])
        counted = [bool(patterns_of(feature)) for feature in target.features]
        summed = [not isinstance(item, Draw | Threshold) for item in target.reads]
        parts = dense(counts[:, min(self.choices.first_of_attribute, default=len(self.choices.original)) :])
        features = np.concatenate([(values * self.relevance)[:, counted], parts], axis=1)
        reads = np.concatenate([target.read(values)[:, summed], parts], axis=1)
        return Sample(counts, features, reads, np.ones(len(values)))

    def fit(self, sample: Sample, num_components: int | None) -> Mixture:
        """The mixture of the method."""
        if self.method == "parameters":
            clusters = np.zeros(len(sample.weights), dtype=np.int64)
        elif self.method == "structure":
            clusters = cluster(sample.features, sample.weights)
            if num_components is not None or clusters.max() >= MAX_COMPONENTS:
                clusters = _merged_to(self.cells, sample, clusters, num_components or MAX_COMPONENTS)
        elif num_components is not None:
            clusters = cluster(sample.features, sample.weights)
            clusters = _merged_to(self.cells, sample, clusters, num_components)
        else:
            begin = [cluster(rows, sample.weights) for rows in (sample.reads, sample.features)]
            clusters = chosen_components(self.cells, sample, _different([*begin, kinds(sample.counts)]))
        return fit_mixture(self.cells, sample.counts, sample.weights, clusters).mixture


class _ModelData(NamedTuple):
    """Kept data of accepted models."""

    counts: sparse.csr_array
    values: Floats


def _merged_to(cells: Cells, sample: Sample, clusters: Ints, number: int) -> Ints:
    """The clusters [N] merged until at most a given number remains."""
    steps = merged(cells, sample.counts, sample.weights, clusters, MAX_COMPONENTS)
    return next(labels for labels in steps if labels.max() < number)


def _consecutive(labels: Ints) -> Ints:
    """Labels renumbered from 0 without gaps."""
    return np.unique(labels, return_inverse=True)[1].reshape(-1)


def _is_candidate(number: int) -> bool:
    """Whether a number of components is a candidate: all numbers up to 8 are, then steps of a quarter."""
    size = 8
    while size < number:
        size = size * 5 // 4
    return number <= 8 or size == number


def _smoothed(cells: Cells, mixture: Mixture, total: float) -> Mixture:
    """Components mixed with a little of the original grammar, so that none of its models is impossible."""
    mass = mixture.weights * total
    share = (SMOOTHING / (mass + SMOOTHING))[:, None]
    weights = (mass + SMOOTHING) / (mass + SMOOTHING).sum()
    return Mixture(weights, (1.0 - share) * mixture.probabilities + share * cells.original)


def _spread(values: Floats) -> float:
    """Standard deviation of the sum of independent values."""
    return float(np.sqrt(len(values)) * values.std())


def _different(clusterings: Sequence[Ints]) -> list[Ints]:
    """Clusterings without duplicates."""
    distinct: list[Ints] = []
    for labels in clusterings:
        size = labels.max() + 1
        same = [size == o.max() + 1 == np.unique(np.stack([labels, o]), axis=1).shape[1] for o in distinct]
        if not any(same):
            distinct.append(labels)
    return distinct


def _composed(even: LearnedGrammar, learned: LearnedGrammar) -> LearnedGrammar:
    """The result for an evened grammar, expressed with the original grammar."""
    origins = dict(learned.origins)
    for key in TreeGrammar.of(learned.grammar).bodies:
        origin = learned.origins.get(key)
        first = even.origins.get(key if origin is None else origin.key)
        if first is not None and origin is not None:
            branches = {b: first.branches.get(o) if o is not None else None for b, o in origin.branches.items()}
            origins[key] = Origin(first.key, branches)
        elif first is not None:
            origins[key] = first
    return replace(learned, original=even.original, base="uniform", origins=origins)
