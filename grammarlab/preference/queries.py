"""Query strategies: the five of section 4.4 of the paper, and the mix that learns fastest.

Every strategy is a pure function of a situation, a number of models and a seed. All except `_already_ranked` choose
among the models of the pool without a score.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import BATCH, Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.preference.base import LIKED_SHARE, MAX_SCORE, NEGLIGIBLE_SHARE, AbstractPreference
from grammarlab.preference.blended import MIN_LABELS, BlendedPreference
from grammarlab.preference.cells.box_search import are_many
from grammarlab.preference.liked import (
    FEW_LIKED,
    MIN_SCORED,
    liked,
    liked_are_rare,
    most_similar,
    most_unexplained,
    noise_of,
    surely_liked,
)
from grammarlab.preference.person import EXACT_NOISE, MODEL_NOISE
from grammarlab.preference.processes.disagreement import (
    cautious_weights,
    conditional_covariance,
    doubtful_weights,
    joint,
    most_doubtful,
    most_telling,
    unexplained,
)
from grammarlab.preference.processes.grouped import GroupedPreference
from grammarlab.preference.processes.posterior import squared_distances

Way = Literal["default", "uniform", "grammar", "density", "uncertainty", "already ranked"]

_LIKING_SHARE = 0.5
"""Share of a default batch that checks models that seem liked."""
NOISE = 1e-2
"""Variance of a score in `default`, as a share of the squared highest score."""
MIN_PROCESS_SHARES = 0.25, 0.5
"""Share of a default batch that a process chooses, for persons with and without errors, since cells may be
overconfident."""
MIN_HIGHEST = 20.0
"""Smallest assumed highest value, in points."""
SMALL_PART = 0.1
"""Share of the highest value below which an expected value is too small as a divisor."""
NOVELTY_VARIANCE = 0.1
"""Variance of new effects unknown to cells, as a share of the squared highest value."""
_MAX_CANDIDATES = (800, 200)
"""Largest number of candidates of `default`, from the grammar and from elsewhere."""

_QUESTIONS_PER_RANDOM = 8
"""Number of questions of which one, rounded to the nearest number, is about a model at random, of those by cells, or
about one similar to an unexplained one, of all."""
_QUESTIONS_PER_OTHER = 4
"""Number of questions of which one is not about what boxes dispute, once some models are liked."""


@dataclass(frozen=True, slots=True)
class Situation:
    """State of knowledge when models are chosen.

    >>> import numpy as np
    >>> import grammarlab as gl
    >>> nothing = np.empty(0)
    >>> start = gl.Situation(np.eye(4), np.ones(4, bool), nothing.astype(int), nothing, preference=None)
    >>> len(gl.propose("default", start, 2, seed=1))
    2
    """

    pool: Floats
    """[m, F] rows of all models of the pool."""
    from_grammar: NDArray[np.bool_]
    """[m] whether a model is a sample of the grammar itself; the others come from a flattened one."""
    scored: Ints
    """[n] pool indices of the models that have a score, in order."""
    scores: Floats
    """[n] scores of these models, 0 to 100."""
    preference: AbstractPreference | None
    """Current preference; None before the first label."""
    weights: Floats | None = None
    """[m] >= 0, the grammar's density divided by that of the pool, for each model; None to use only samples of the
    grammar."""
    asked: Ints | None = None
    """[k] pool indices of further models that are not asked about, since they are on the page or since their scores do
    not count any more."""

    @property
    def liked(self) -> NDArray[np.bool_]:
        """[n] whether scored models seem liked."""
        return liked(self.scores, noise_of(self.preference))

    def stands_for(self, models: Ints) -> Floats:
        """Weights of models of the pool: equal for samples of the grammar, for others by their novelty.

        Novelty is their density weight, times the probability that no similar model was drawn from the grammar.
        """
        share = float(self.from_grammar.mean())
        weights = np.zeros(len(self.pool)) if self.weights is None else self.weights
        return np.where(self.from_grammar, 1.0, weights * np.maximum(1.0 - share * weights, 0.0))[models]


def propose(way: Way, situation: Situation, num: int, seed: int) -> Ints:
    """Models to show next.

    Args:
        way: ``uniform`` (as far apart and from known models as possible), ``grammar`` (as the grammar makes them),
            ``density`` (one half liked, one half not), ``uncertainty``, ``already ranked`` (to check for mistakes), or
            ``default``.
        situation: the pool and the state.
        num: number of models, >= 0; fewer if there are no more.
        seed: seed of the random choices; the same seed gives the same models.

    Returns:
        [num] different indices into the pool.

    Raises:
        UsageError: If the strategy is unknown.

    >>> import numpy as np
    >>> import grammarlab as gl
    >>> known = gl.Situation(np.eye(4), np.ones(4, bool), np.array([0]), np.array([70.0]), preference=None)
    >>> sorted(gl.propose("uniform", known, 3, seed=1).tolist())
    [1, 2, 3]
    """
    if way not in WAYS:
        raise UsageError(f"unknown query strategy {way!r}; expected one of {', '.join(WAYS)}.")
    if situation.preference is not None:
        situation = replace(situation, preference=situation.preference.explaining)
    available = len(situation.scored) if way == "already ranked" else int(np.count_nonzero(_is_unscored(situation)))
    return WAYS[way](situation, min(num, available), np.random.default_rng(seed))


def _default(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """One part checks models that seem liked for mistakes, the other lowers the total uncertainty most.

    One of about eight questions by cells is about a model of the grammar at random: cells are sure of what they have
    never seen, such as a second liked style among many disliked designs.

    While nothing is liked, the first part uses models from elsewhere, since liked models may be too rare in samples of
    the grammar. If liked models have been rare, all questions are of this kind. While few models are liked, half of the
    questions are about models similar to these, or all questions if liked models have been rare and cells do not take
    the scores of all of them for blunders. Later, one of eight questions is about a model similar to those with
    scores above what cells expect, if there are any. A larger share is worse if scores have noise, as cells of many
    scores of a rare kind are too large at first.

    Of continuous columns, models are chosen about which boxes disagree (`grammarlab.preference.cells.box_search`).

    Doubtful scores are not requested again. Repeating them whenever cells expected more gain from it than from the last
    new model did not lower the divergence of persons with noise of 10 points or with 5 % blunders.
    """
    preference = situation.preference
    if preference is None:
        return _grammar(situation, num, randomness)
    if not isinstance(preference, BlendedPreference):
        return _mixed(preference, situation, num, randomness)
    sure = surely_liked(preference, situation.pool[situation.scored], situation.scores)
    if preference.partition.boxes and sure.any():
        disputed = _disputed(preference, situation, num)
        scored = np.append(situation.scored, disputed)
        guesses = np.append(situation.scores, preference.predict(situation.pool[disputed]).mean)
        situation = replace(situation, scored=scored, scores=guesses)
        return np.append(disputed, _explaining(preference, situation, num - len(disputed), randomness))
    if not sure.any() and _is_continuous(situation.pool):
        # Noise has explanations as well. Every design is unlike all others, and the most unlike ones are extreme.
        return _drawn(_is_unscored(situation), np.ones(len(situation.pool)), num, randomness)
    return _explaining(preference, situation, num, randomness)


def _is_continuous(pool: Floats) -> bool:
    """Whether most columns of a pool have different values for nearly all models."""
    some = np.sort(pool[:BATCH], axis=0)
    is_continuous = np.count_nonzero(np.diff(some, axis=0) > 0.0, axis=0) > len(some) / 2
    return are_many(int(np.count_nonzero(is_continuous)), pool.shape[1])


def _disputed(preference: BlendedPreference, situation: Situation, num: int) -> Ints:
    """Models about which boxes and trees disagree most, each given the scores of those before.

    They lie near bounds that labels leave open. While few models are liked, all questions are about these.
    """
    cells = preference.partition
    if np.count_nonzero(surely_liked(preference, situation.pool[situation.scored], situation.scores)) >= FEW_LIKED:
        num = num - num // _QUESTIONS_PER_OTHER
    shares, values = cells.opinions(situation.pool)
    away = np.sqrt(shares)[:, None] * (values - shares @ values)
    stakes = np.ones(len(situation.pool)) if situation.weights is None else situation.weights
    is_open, noise = _is_unscored(situation), max(cells.noise, MODEL_NOISE) ** 2
    chosen = list[int]()
    for _ in range(num):
        doubt = np.where(is_open, (away**2).sum(axis=0) * stakes, 0.0)
        best = int(np.argmax(doubt))
        if doubt[best] < MODEL_NOISE**2 * NEGLIGIBLE_SHARE:
            break
        chosen.append(best)
        is_open[best] = False
        column = away[:, best].copy()
        away -= np.outer(column, (column @ away) / (column @ column + noise))
    return np.array(chosen, dtype=np.int64)


def _explaining(preference: BlendedPreference, situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """Models similar to liked ones, and those that tell most according to the preference."""
    if num <= 0:
        return situation.scored[:0]
    pool, scored, scores = situation.pool, situation.scored, situation.scores
    rare, similar = liked_are_rare(scores, preference.noise, preference.blunders), np.zeros(0, dtype=np.int64)
    sure = surely_liked(preference, pool[scored], scores)
    if len(scores) >= MIN_LABELS and situation.liked.any() and np.count_nonzero(sure) < FEW_LIKED:
        most = num if rare and sure.any() else num // 2
        similar = most_similar(pool, scored, scores, most, _is_unscored(situation), randomness)
        if not sure.any():
            # Probably all of them are blunders, and what is liked has still to be found.
            situation = replace(situation, scores=np.where(situation.liked, 0.0, scores))
    elif len(scores) >= MIN_LABELS:
        similar = most_unexplained(
            preference, pool, scored, scores, _one_in(_QUESTIONS_PER_RANDOM, num), _is_unscored(situation), randomness
        )
    return np.append(similar, _informative(preference, situation, num - len(similar), similar, rare, randomness))


def _informative(
    preference: BlendedPreference,
    situation: Situation,
    num: int,
    but: Ints,
    rare: bool,
    randomness: np.random.Generator,
) -> Ints:
    """Models that tell most, according to cells and to a process.

    Args:
        preference: the preference.
        situation: the pool and the state.
        num: number of models.
        but: models that are left out.
        rare: whether liked models have been rare.
        randomness: generator.
    """
    if num <= 0:
        return but[:0]
    scarce = _are_scarce(preference, situation)
    by_liking = scarce or (rare and bool(situation.liked.any()))
    candidates = _candidates(situation, num, but, by_liking, randomness)
    least = MIN_PROCESS_SHARES[preference.partition.noise <= EXACT_NOISE]
    if rare or not situation.liked.any():
        least = 1.0
    apart = _among_liked(preference, situation, candidates, num // 2 if scarce else 0)
    by_process = min(round(max(preference.share, least) * (num - len(apart))), len(candidates) - len(apart))
    first = np.append(apart, _of_process(preference.process, situation, candidates, apart, by_process, rare))
    remaining = min(num, len(candidates)) - len(first)
    by_chance = 0 if rare else _one_in(_QUESTIONS_PER_RANDOM, remaining)
    second = _of_cells(preference, situation, candidates, first, remaining - by_chance)
    is_open = np.ones(len(candidates), dtype=bool)
    is_open[np.concatenate((first, second))] = False
    third = _drawn(is_open, situation.from_grammar[candidates].astype(np.float64), by_chance, randomness)
    return candidates[np.concatenate((first, second, third))]


def _one_in(per: int, num: int) -> int:
    return (num + per // 2) // per


def _are_scarce(preference: BlendedPreference, situation: Situation) -> bool:
    """Whether hardly any model of the grammar seems liked, although some scores are high."""
    mean = preference.predict(situation.pool).mean
    highest = float(mean.max(initial=0.0))
    if not situation.liked.any() or highest < MIN_HIGHEST:
        return False
    return float(np.mean(mean[situation.from_grammar] > LIKED_SHARE * highest)) < 1.0 / MIN_SCORED


def _among_liked(preference: BlendedPreference, situation: Situation, candidates: Ints, num: int) -> Ints:
    """Candidates that seem liked, each weighted by its value: the grammar makes hardly any of them."""
    if num <= 0:
        return np.zeros(0, dtype=np.int64)
    rows, scored_rows = situation.pool[candidates], situation.pool[situation.scored]
    mean = preference.predict(rows).mean
    highest = float(mean.max(initial=0.0))
    seem = mean > LIKED_SHARE * highest
    noise = max(preference.partition.noise, MODEL_NOISE) ** 2
    good = scored_rows[preference.partition.predict(scored_rows).mean > LIKED_SHARE * highest]
    weights = cautious_weights(preference.process, rows)
    weights = weights + doubtful_weights(preference.process, good if len(good) else scored_rows)
    covariance = preference.partition.joint(rows)[1] + unexplained(
        scored_rows, rows, weights, NOVELTY_VARIANCE * highest**2, noise
    )
    return most_doubtful(covariance, min(num, int(seem.sum())), noise, mean * seem, seem)


def _of_process(
    preference: GroupedPreference, situation: Situation, candidates: Ints, chosen: Ints, num: int, rare: bool
) -> Ints:
    """Candidates that a process is uncertain about: some seem liked, and some lower the total variance most."""
    rows, typical = situation.pool[candidates], situation.stands_for(candidates)
    noise, is_open = NOISE * preference.highest**2, np.ones(len(candidates), dtype=bool)
    is_open[chosen] = False
    scored_rows = situation.pool[situation.scored]
    good = scored_rows[situation.liked]
    mean, covariance = joint(preference, rows, doubtful_weights(preference, good if len(good) else scored_rows))
    elsewhere = (~situation.from_grammar[candidates]).astype(np.float64)
    stakes = np.maximum(mean, 0.0) * typical if len(good) else elsewhere
    share = 1.0 if rare and not len(good) else _LIKING_SHARE
    first = most_doubtful(conditional_covariance(covariance, chosen, noise), round(share * num), noise, stakes, is_open)
    is_open[first] = False
    _, covariance = joint(preference, rows, cautious_weights(preference, rows))
    before = np.append(chosen, first)
    second = most_telling(conditional_covariance(covariance, before, noise), num - len(first), noise, typical, is_open)
    return np.concatenate((first, second))


def _of_cells(preference: BlendedPreference, situation: Situation, candidates: Ints, chosen: Ints, num: int) -> Ints:
    """Candidates that cells are uncertain about, or that have new properties; each variance is divided by its mean.

    A small divergence between densities is a sum of squared errors divided by expected values.
    """
    if num <= 0:
        return np.zeros(0, dtype=np.int64)
    cells, process = preference.partition, preference.process
    rows, scored_rows = situation.pool[candidates], situation.pool[situation.scored]
    scored_means = cells.predict(scored_rows).mean
    highest = max(float(scored_means.max(initial=0.0)), MIN_HIGHEST)
    good = scored_rows[scored_means > LIKED_SHARE * highest]
    noise = max(cells.noise, MODEL_NOISE) ** 2
    mean, covariance = cells.joint(rows)
    stakes = situation.stands_for(candidates) / (np.maximum(mean, 0.0) + SMALL_PART * highest)
    is_open = np.ones(len(candidates), dtype=bool)
    is_open[chosen] = False
    cautious = cautious_weights(process, rows)
    doubtful = cautious + doubtful_weights(process, good if len(good) else scored_rows)
    amplitude = NOVELTY_VARIANCE * highest**2
    unlike = [unexplained(scored_rows, rows, weights, amplitude, noise) for weights in (doubtful, cautious)]
    first = most_doubtful(
        conditional_covariance(covariance + unlike[0], chosen, noise), num // 2, noise, stakes, is_open
    )
    is_open[first] = False
    before = np.concatenate((chosen, first))
    second = most_telling(
        conditional_covariance(covariance + unlike[1], before, noise), num - len(first), noise, stakes, is_open
    )
    return np.concatenate((first, second))


def _candidates(situation: Situation, num: int, but: Ints, by_liking: bool, randomness: np.random.Generator) -> Ints:
    """Candidate models without a score: from the grammar and from elsewhere.

    Args:
        situation: the pool and the state.
        num: number of models that are needed at least.
        but: models that are left out.
        by_liking: whether those from elsewhere are the models with the highest predictions, not models at random.
        randomness: generator.
    """
    is_open = _is_unscored(situation)
    is_open[but] = False
    pools = [
        randomness.permutation(np.flatnonzero(is_open & kind))
        for kind in (situation.from_grammar, ~situation.from_grammar)
    ]
    if by_liking and situation.preference is not None:
        liking = situation.preference.predict(situation.pool[pools[1]]).mean
        pools[1] = pools[1][np.argsort(-liking, kind="stable")]
    chosen = [pool[:most] for pool, most in zip(pools, _MAX_CANDIDATES, strict=True)]
    missing = num - sum(len(part) for part in chosen)
    if missing > 0:
        chosen += [pool[most:] for pool, most in zip(pools, _MAX_CANDIDATES, strict=True)]
    return np.concatenate(chosen)


def _mixed(preference: AbstractPreference, situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """Strategy for preferences without covariances: one half by the current density, one half by uncertainty."""
    prediction, is_open = preference.predict(situation.pool), _is_unscored(situation)
    first = _drawn(is_open, prediction.mean * situation.from_grammar, num // 2, randomness)
    is_open[first] = False
    return np.concatenate((first, _drawn(is_open, prediction.std, num - len(first), randomness)))


def _grammar(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    return _drawn(_is_unscored(situation), situation.from_grammar.astype(np.float64), num, randomness)


def _density(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """One half in proportion to the predicted score, one half to 100 minus this score, among samples of the grammar."""
    preference = situation.preference
    if preference is None:
        return _grammar(situation, num, randomness)
    liking = np.clip(preference.predict(situation.pool).mean, 0.0, MAX_SCORE) / MAX_SCORE
    is_open = _is_unscored(situation)
    first = _drawn(is_open, liking * situation.from_grammar, (num + 1) // 2, randomness)
    is_open[first] = False
    second = _drawn(is_open, (1.0 - liking) * situation.from_grammar, num - len(first), randomness)
    return np.concatenate((first, second))


def _uncertainty(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """In proportion to the standard deviation of the prediction, among samples of the grammar."""
    preference = situation.preference
    if preference is None:
        return _grammar(situation, num, randomness)
    deviation = preference.predict(situation.pool).std
    return _drawn(_is_unscored(situation), deviation * situation.from_grammar, num, randomness)


def _already_ranked(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """Scored models, ordered by the difference of their score from its prediction by the others, largest first."""
    models, first = np.unique(situation.scored[::-1], return_index=True)
    scores = situation.scores[::-1][first]
    order = randomness.permutation(len(models))
    if situation.preference is not None:
        surprise = np.abs(situation.preference.predict(situation.pool[models]).mean - scores)
        order = order[np.argsort(-surprise[order], kind="stable")]
    return models[order[:num]]


def _uniform(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """Farthest points under the learned weights: each next model is the farthest from all known or chosen models."""
    preference, rows = situation.preference, situation.pool
    spread = np.ptp(rows, axis=0)
    weights = np.divide(1.0, spread**2, out=np.zeros(rows.shape[1]), where=spread > 0.0)
    learned = None if preference is None else preference.column_weights()
    weights = weights if learned is None or not learned.any() else learned
    scaled = rows[:, weights > 0.0] * np.sqrt(weights[weights > 0.0])
    chosen = np.empty(num, dtype=np.int64)
    nearest, scored = np.empty(len(rows)), scaled[situation.scored]
    for block in (slice(start, start + BATCH) for start in range(0, len(rows), BATCH)):
        nearest[block] = squared_distances(scaled[block], scored).min(axis=1, initial=np.inf)
    # Equal distances are common among counts; the seed decides between them.
    order = randomness.permutation(len(rows))
    is_open = _is_unscored(situation)
    for index in range(num):
        distance = np.where(is_open, nearest, -1.0)[order]
        best = chosen[index] = order[np.argmax(distance)]
        is_open[best] = False
        nearest = np.minimum(nearest, squared_distances(scaled, scaled[[best]])[:, 0])
    return chosen


def _is_unscored(situation: Situation) -> NDArray[np.bool_]:
    is_open = np.ones(len(situation.pool), dtype=bool)
    is_open[situation.scored] = False
    if situation.asked is not None:
        is_open[situation.asked] = False
    return is_open


def _drawn(is_open: NDArray[np.bool_], weights: Floats, num: int, randomness: np.random.Generator) -> Ints:
    """Different open models, drawn one after the other in proportion to their weights; those of weight 0 come last."""
    # The largest values of log weight + Gumbel noise are such a draw.
    with np.errstate(divide="ignore"):
        keys = np.log(np.maximum(weights, 0.0)) + randomness.gumbel(size=len(weights))
    keys = np.where(np.isfinite(keys), keys, -1e300 + randomness.random(len(weights)))
    candidates = np.flatnonzero(is_open)
    return candidates[np.argsort(-keys[candidates], kind="stable")[:num]]


WAYS: dict[Way, Callable[[Situation, int, np.random.Generator], Ints]] = {
    "default": _default,
    "uniform": _uniform,
    "grammar": _grammar,
    "density": _density,
    "uncertainty": _uncertainty,
    "already ranked": _already_ranked,
}
