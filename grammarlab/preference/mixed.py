"""The default preference of labels of several kinds: scores, stars, thumbs and comparisons in one likelihood.

Under a kernel, sites replace labels that are not scores (`grammarlab.preference.processes.label_kinds`). Kernels and
sites are improved in turns. Cells get the intervals of values. If all labels are scores, `blended.py` handles them.

Both parts are believed by the likelihood of held-out labels, since comparisons appear in the evidence of cells twice.
If nothing is explained, comparisons are decided by chance, and values of other labels have one distribution.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.arrays import BATCH, ROUNDING, Flags, Floats, Ints
from grammarlab.preference.base import MANY_LABELS, MAX_SCORE, Rows
from grammarlab.preference.belief import belief, believed
from grammarlab.preference.blended import MIN_LABELS, BlendedPreference
from grammarlab.preference.cells import partition
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.held_out_share import EVIDENCE_POWER, NUM_FOLDS, PROCESS_SHARES, Sketch, mean_share
from grammarlab.preference.labels import Kind
from grammarlab.preference.observations import checked_groups, checked_kinds
from grammarlab.preference.person import MODEL_NOISE, START_BLUNDERS, START_NOISES, Intervals, Person, matched
from grammarlab.preference.processes import grouped
from grammarlab.preference.processes.grouped import GroupedPreference
from grammarlab.preference.processes.grouped_search import AMPLITUDE
from grammarlab.preference.processes.label_kinds import (
    Judgements,
    LabelObservations,
    judgements_of,
    label_observations,
    middle_of,
)
from grammarlab.preference.processes.posterior import Hyperparameters
from grammarlab.preference.unexplained import Unexplained, unexplained


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    kinds: Sequence[Kind],
    others: Rows,
    groups: ArrayLike | None = None,
    continuous: ArrayLike | None = None,
    seed: int = 0,
) -> BlendedPreference:
    """Both kinds of preference, the share of each by held-out labels, and how far they are believed.

    Args:
        rows: [n, F] finite numbers; of more than `BATCH` labels, so many count, an even selection by score.
        scores: [n] 0-100, as in label tables.
        kinds: [n] kinds of the labels.
        others: [n, F] rows of the other models of comparisons; arbitrary for other kinds.
        groups: [F] group numbers; by default every column is its own group.
        continuous: [F] whether columns are continuous instead of counts; by default none is.
        seed: seed of random starts and draws, and of the held-out labels.

    Raises:
        UsageError: If labels or groups are out of range.
    """
    # Sites take the third power of the number of labels, again and again.
    judgements = judgements_of(rows, scores, kinds, others).thinned(BATCH)
    numbers = checked_groups(groups, judgements.rows.shape[1])
    drawn = checked_kinds(continuous, len(numbers))
    with threadpool_limits(1, "blas"):
        observed, process = _in_turns(judgements, numbers, drawn, seed)
    cells = partition.fit(
        observed.rows, observed.scores, groups=numbers, continuous=drawn, seed=seed, intervals=observed.intervals
    )
    judged = _judged(judgements, observed, drawn, seed, process, cells)
    num_labels = len(judgements.scores)
    beliefs = [belief(gain, num_labels) for gain in (judged.process_gain, judged.cells_gain)]
    share, rest, handed = believed(1.0 if num_labels < MIN_LABELS else judged.share, *beliefs)
    sketches = () if num_labels < MIN_LABELS else judged.sketches
    return BlendedPreference(
        process=process,
        partition=cells,
        share=share,
        flat=judged.flat,
        handed=handed,
        unexplained=rest,
        sketches=tuple(
            BlendedPreference(process=part, partition=some_cells, share=share, flat=judged.flat, unexplained=rest)
            for part, some_cells in sketches
        ),
    )


class _Judged(NamedTuple):
    """What held-out labels say."""

    share: float
    """Share of the process, if both parts are believed."""
    process_gain: float
    """Half of the log-likelihood of held-out labels by the process, less that of nothing explained, in nats."""
    cells_gain: float
    """The same by the cells."""
    flat: Unexplained
    """Nothing explained."""
    sketches: tuple[Sketch, ...]
    """Fits without the held-out labels."""


def _in_turns(
    judgements: Judgements, groups: Ints, continuous: Flags, seed: int
) -> tuple[LabelObservations, GroupedPreference]:
    """Observations from labels under the best kernel, which is found from those under a kernel of equal weights."""
    spread = 2.0 * np.var(judgements.rows, axis=0).sum()
    varies = np.ptp(judgements.rows, axis=0) > 0.0
    kernel = Hyperparameters(AMPLITUDE[0] * MAX_SCORE**2, varies / max(float(spread), 1.0), START_NOISES[1] ** 2)
    observed = label_observations(judgements, kernel, MAX_SCORE / 2.0)
    process = grouped.fit_observed(
        observed.search_observations, groups=groups, continuous=continuous, seed=seed, starts=1
    )
    observed = _under(judgements, process)
    process = grouped.fit_observed(observed.search_observations, groups=groups, continuous=continuous, seed=seed)
    observed = _under(judgements, process)
    return observed, process.conditioned_on(observed.observations)


def _under(judgements: Judgements, process: GroupedPreference) -> LabelObservations:
    """Observations from labels under the best kernel of a process."""
    kernel = process.explanations[0].posterior.hyperparameters
    return label_observations(judgements, kernel, middle_of(judgements, kernel))


def _judged(
    judgements: Judgements,
    observed: LabelObservations,
    continuous: Flags,
    seed: int,
    process: GroupedPreference,
    cells: PartitionPreference,
) -> _Judged:
    """Share of the process by the likelihood of held-out labels, and what both parts gain."""
    randomness = np.random.default_rng(seed)
    num_rows, num_labels = len(judgements.rows), len(judgements.scores)
    # Labels of equal rows are held out together: otherwise one would predict the other.
    fold_of = randomness.permutation(NUM_FOLDS * (1 + num_rows // NUM_FOLDS))[:num_rows] % NUM_FOLDS
    first, compared = judgements.first, judgements.second >= 0
    second = np.where(compared, judgements.second, first)
    selected = np.sort(randomness.permutation(num_labels)[:MANY_LABELS])
    alone = _alone(observed.bounds, compared).take(selected)
    chance = _chance(judgements)
    flat = unexplained(alone, fold_of[first[selected]], cells.cells.grid, (_error(cells),))
    # Of the shares of the process, of a process with kernels found without the held-out labels, and of nothing.
    evidence, sketches = np.zeros(len(PROCESS_SHARES) + 2), list[Sketch]()
    evidence[-1] = flat.log_evidence
    # Comparisons alone leave the level of all values open.
    limits = (-np.inf, np.inf) if compared.all() else (0.0, MAX_SCORE)
    for number in range(NUM_FOLDS):
        out = (fold_of[first] == number) | (fold_of[second] == number)
        is_training, apart = ~out[observed.label], np.flatnonzero((fold_of[observed.row_pairs] != number).all(axis=1))
        held_out = selected[out[selected]]
        if not (len(held_out) and is_training.any() and len(apart)):
            continue
        with threadpool_limits(1, "blas"):
            known = observed.observations.take(apart)
            sketch = (
                process.conditioned_on(known),
                cells.without(
                    observed.rows[is_training],
                    observed.scores[is_training],
                    continuous,
                    observed.intervals.take(is_training),
                ),
            )
            refitted = grouped.fit_observed(
                observed.search_observations.take(apart),
                groups=process.groups,
                continuous=continuous,
                seed=seed,
                starts=1,
            ).conditioned_on(known)
            by_process, by_cells, by_refitted = (
                np.clip(part.predict(judgements.rows).mean, *limits) for part in (*sketch, refitted)
            )
        sketches.append(sketch)
        mixtures = [share * by_process + (1.0 - share) * by_cells for share in PROCESS_SHARES]
        bounds = observed.bounds.take(held_out)
        for index, values in enumerate((*mixtures, by_refitted)):
            differences = values[first[held_out]] - compared[held_out] * values[second[held_out]]
            evidence[index] += _log_likelihood(bounds, differences, cells)
        evidence[-1] += float(np.log(chance[held_out]).sum())
    # Cells are preferred for the divisions that they find. Undivided ones are the hypothesis that all designs are liked
    # equally, which explains no comparison: it has the same odds as any other share.
    undivided = compared.any() and cells.trees[0].split is None
    by_share = evidence[: len(PROCESS_SHARES)]
    share = mean_share(by_share, 0.0) if undivided else mean_share(by_share)
    price = flat.person.price
    return _Judged(
        share=share,
        process_gain=EVIDENCE_POWER * float(evidence[-2] - price - evidence[-1]),
        cells_gain=EVIDENCE_POWER * float(evidence[0] - price - evidence[-1]),
        flat=flat,
        sketches=tuple(sketches),
    )


def _chance(judgements: Judgements) -> Floats:
    """[n] probability of each comparison if nothing is explained: ties are as frequent as they are; 1 for others."""
    is_tie, is_rather = (np.array([kind == name for kind in judgements.kinds]) for name in ("tie", "rather"))
    ties = (1.0 + is_tie.sum()) / (2.0 + is_tie.sum() + is_rather.sum()) if is_tie.any() else 0.0
    return np.where(is_tie, ties, np.where(is_rather, (1.0 - ties) / 2.0, 1.0))


def _alone(bounds: Intervals, compared: Flags) -> Intervals:
    """Intervals of labels, with comparisons as labels that say nothing about a single value."""
    return Intervals(
        np.where(compared, -np.inf, bounds.low),
        np.where(compared, np.inf, bounds.high),
        np.where(compared, MAX_SCORE, bounds.length),
        np.where(compared, 1.0, bounds.looks),
        np.where(compared, 0.0, bounds.variance),
    )


def _error(cells: PartitionPreference) -> Person:
    """The person for the likelihood of held-out labels."""
    return Person(max(cells.noise, MODEL_NOISE), max(cells.blunders, START_BLUNDERS))


def _log_likelihood(intervals: Intervals, values: Floats, cells: PartitionPreference) -> float:
    """Log-likelihood of labels, given values [n], under the error model of the cells."""
    evidence, _, _ = matched(intervals, values, np.full(len(values), ROUNDING), *_error(cells))
    return float(evidence.sum())
