"""Which models to ask about next: the five ways of section 4.4 of the paper, and the mix that learns fastest.

Every way is a pure function of a situation, a number of models and a seed. All but `already_ranked` choose among the
models of the pool that have no score yet.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Floats, Ints
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.observations import observe
from grammarlab.preference.processes.disagreement import (
    cautious_weights,
    doubtful_weights,
    given,
    joint,
    most_doubtful,
    most_telling,
    unexplained,
)
from grammarlab.preference.processes.grouped import GroupedPreference
from grammarlab.preference.processes.posterior import Hyperparameters, condition, squared_distances
from grammarlab.preference.questions.liked import EXACT, liked, liked_are_rare, noise_of

Way = Literal["default", "uniform", "grammar", "density", "uncertainty", "already ranked"]

LIKED_SHARE = 0.5
"""Part of a default batch that settles which of the models that seem liked are not."""
NOISE = 1e-2
"""Variance of a score around the function that `default` reckons with, as a share of the squared highest score."""
FEW_LIKED = 4
"""With fewer liked ones among rare ones, nothing is known but that others like them may be liked."""
LEAST_OF_PROCESS = 0.25, 0.5
"""Part of a default batch that a process chooses in any case, where a person errs and where they seem not to: what
cells are sure of may be wrong."""
LEAST_LIKED = 20.0
"""Points; if nothing seems better, that is thought possible."""
LIKED_PART = 0.25
"""From this part of the highest value on a model seems liked, to cells."""
SMALL_PART = 0.1
"""Part of the highest value below which an expected one is too small to divide by."""
LEAST_NOISE = 3.0
"""Standard deviation in points that cells reckon with at least."""
NOVELTY = 0.1
"""Variance of what cells cannot know yet, as a share of the squared highest value."""
_ALIKE_DISTANCE = 2.6
"""Weighted squared distance between two typical models where all columns matter alike."""
_ALIKE_NOISE = 1e-3
"""As a share of the amplitude."""
_CANDIDATES = (800, 200)
"""Models from the grammar and from elsewhere that `default` looks at, at most."""

_TOGETHER = 256
"""Known models that distances are measured to at a time."""


@dataclass(frozen=True, slots=True)
class Situation:
    """What is known when models are chosen.

    >>> nothing = np.empty(0)
    >>> start = Situation(np.eye(4), np.ones(4, bool), nothing.astype(int), nothing, preference=None)
    >>> len(propose("default", start, 2, seed=1))
    2
    """

    pool: Floats
    """[m, F] rows of all models there are to ask about."""
    from_grammar: NDArray[np.bool_]
    """[m] whether a model is a sample of the grammar itself; the others come from a flattened one."""
    asked: Ints
    """[n] pool indices of the models that have a score, in order."""
    scores: Floats
    """[n] their scores, 0 to 100."""
    preference: AbstractPreference | None
    """What is learned so far; None before the first label."""
    weights: Floats | None = None
    """[m] >= 0, the grammar's density by that of the whole pool, for each model; None to count on samples of the
    grammar alone."""

    @property
    def liked(self) -> NDArray[np.bool_]:
        """[n] which of the scored models seem liked."""
        return liked(self.scores, noise_of(self.preference))

    def stands_for(self, models: Ints) -> Floats:
        """How much some models of the pool count: samples of the grammar alike, all others for what those do not show.

        That is their weight, times the chance that a model like them was not drawn from the grammar.
        """
        share = float(self.from_grammar.mean())
        weights = np.zeros(len(self.pool)) if self.weights is None else self.weights
        return np.where(self.from_grammar, 1.0, weights * np.maximum(1.0 - share * weights, 0.0))[models]


def propose(way: Way, situation: Situation, num: int, seed: int) -> Ints:
    """Models to show next.

    Args:
        way: ``uniform`` (as unlike each other and what is known as possible), ``grammar`` (as the grammar makes them),
            ``density`` (one half liked, one half not), ``uncertainty``, ``already ranked`` (to check for mistakes), or
            ``default``.
        situation: the pool and what is known.
        num: how many, >= 0; fewer are given where there are no more.
        seed: the same seed gives the same models.

    Returns:
        [num] different indices into the pool.

    Raises:
        UsageError: for an unknown way.

    >>> known = Situation(np.eye(4), np.ones(4, bool), np.array([0]), np.array([70.0]), preference=None)
    >>> sorted(propose("uniform", known, 3, seed=1).tolist())
    [1, 2, 3]
    """
    if way not in WAYS:
        raise UsageError(f"no way to choose models is called {way!r}. There are: {', '.join(WAYS)}.")
    known = len(situation.asked) if way == "already ranked" else len(situation.pool) - len(np.unique(situation.asked))
    return WAYS[way](situation, min(num, known), np.random.default_rng(seed))


def _default(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """One part that looks for mistakes among models that seem liked, one that lowers the total uncertainty most.

    As long as nothing is liked the first part is about models from elsewhere, since what is liked may be too rare for
    the grammar to show. Where it has turned out to be rare, that part is all; then come models like the first few that
    are liked, since no explanation of so few is worth much.

    Scores that are doubtful are not asked for again. Doing so wherever cells expected it to tell more than the last new
    model did not help: the divergence after 64 scores was .080 instead of .076, the mean of three persons with noise of
    10 points on S1 and three with 5 % blunders on B1.
    """
    preference = situation.preference
    if preference is None:
        return _grammar(situation, num, randomness)
    if not isinstance(preference, BlendedPreference):
        return _mixed(preference, situation, num, randomness)
    rare = liked_are_rare(situation.scores, preference.noise)
    if rare and 0 < np.count_nonzero(situation.liked) < FEW_LIKED:
        return _resembling(situation, num, randomness)
    candidates = _candidates(situation, num, randomness)
    least = LEAST_OF_PROCESS[preference.partition.noise <= EXACT]
    if rare or not situation.liked.any():
        least = 1.0
    by_process = min(round(max(preference.share, least) * num), len(candidates))
    first = _of_process(preference.process, situation, candidates, by_process, rare)
    second = _of_cells(preference, situation, candidates, first, min(num, len(candidates)) - len(first))
    return candidates[np.concatenate((first, second))]


def _of_process(preference: GroupedPreference, situation: Situation, candidates: Ints, num: int, rare: bool) -> Ints:
    """Candidates that a process is in doubt about: a part that seems liked, and a part that tells most about all."""
    rows, typical = situation.pool[candidates], situation.stands_for(candidates)
    noise, open_ = NOISE * preference.highest**2, np.ones(len(candidates), dtype=bool)
    known = situation.pool[situation.asked]
    good = known[situation.liked]
    mean, covariance = joint(preference, rows, doubtful_weights(preference, good if len(good) else known))
    elsewhere = (~situation.from_grammar[candidates]).astype(np.float64)
    stakes = np.maximum(mean, 0.0) * typical if len(good) else elsewhere
    share = 1.0 if rare and not len(good) else LIKED_SHARE
    first = most_doubtful(covariance, round(share * num), noise, stakes, open_)
    open_[first] = False
    _, covariance = joint(preference, rows, cautious_weights(preference, rows))
    second = most_telling(given(covariance, first, noise), num - len(first), noise, typical, open_)
    return np.concatenate((first, second))


def _of_cells(preference: BlendedPreference, situation: Situation, candidates: Ints, chosen: Ints, num: int) -> Ints:
    """Candidates that cells are in doubt about, or that have something new; each variance counts beside its mean.

    A divergence between densities is, where it is small, a sum of squared errors beside what is expected.
    """
    if num <= 0:
        return np.zeros(0, dtype=np.int64)
    cells, process = preference.partition, preference.process
    rows, known = situation.pool[candidates], situation.pool[situation.asked]
    meant = cells.predict(known).mean
    highest = max(float(meant.max(initial=0.0)), LEAST_LIKED)
    good = known[meant > LIKED_PART * highest]
    noise = max(cells.noise, LEAST_NOISE) ** 2
    mean, covariance = cells.joint(rows)
    stakes = situation.stands_for(candidates) / (np.maximum(mean, 0.0) + SMALL_PART * highest)
    open_ = np.ones(len(candidates), dtype=bool)
    open_[chosen] = False
    cautious = cautious_weights(process, rows)
    doubtful = cautious + doubtful_weights(process, good if len(good) else known)
    amplitude = NOVELTY * highest**2
    unlike = [unexplained(known, rows, weights, amplitude, noise) for weights in (doubtful, cautious)]
    first = most_doubtful(given(covariance + unlike[0], chosen, noise), num // 2, noise, stakes, open_)
    open_[first] = False
    before = np.concatenate((chosen, first))
    second = most_telling(given(covariance + unlike[1], before, noise), num - len(first), noise, stakes, open_)
    return np.concatenate((first, second))


def _resembling(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """Models like the liked ones and unlike the others, under a Gaussian process to which all columns matter alike."""
    variance = situation.pool.var(axis=0)
    varies = variance > 0.0
    weights = np.zeros(len(variance))
    weights[varies] = _ALIKE_DISTANCE / (2.0 * varies.sum() * variance[varies])
    known = observe(situation.pool[situation.asked], situation.scores)
    alike = condition(Hyperparameters(MAX_SCORE**2, weights, _ALIKE_NOISE * MAX_SCORE**2), known)
    open_ = randomness.permutation(np.flatnonzero(_unasked(situation)))
    return open_[np.argsort(-alike.predict(situation.pool[open_]).mean, kind="stable")[:num]]


def _candidates(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """Unasked models to choose from: some from the grammar, some from elsewhere; more where they are needed.

    Where liked models are rare, those from elsewhere are the ones that seem to be liked most.
    """
    open_ = _unasked(situation)
    pools = [
        randomness.permutation(np.flatnonzero(open_ & kind))
        for kind in (situation.from_grammar, ~situation.from_grammar)
    ]
    rare = liked_are_rare(situation.scores, noise_of(situation.preference))
    if situation.preference is not None and rare and situation.liked.any():
        liking = situation.preference.predict(situation.pool[pools[1]]).mean
        pools[1] = pools[1][np.argsort(-liking, kind="stable")]
    chosen = [pool[:most] for pool, most in zip(pools, _CANDIDATES, strict=True)]
    missing = num - sum(len(part) for part in chosen)
    if missing > 0:
        chosen += [pool[most:] for pool, most in zip(pools, _CANDIDATES, strict=True)]
    return np.concatenate(chosen)


def _mixed(preference: AbstractPreference, situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """For preferences that know no covariances: one half of the current density, one half uncertain."""
    prediction, open_ = preference.predict(situation.pool), _unasked(situation)
    first = _drawn(open_, prediction.mean * situation.from_grammar, num // 2, randomness)
    open_[first] = False
    return np.concatenate((first, _drawn(open_, prediction.std, num - len(first), randomness)))


def _grammar(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    return _drawn(_unasked(situation), situation.from_grammar.astype(np.float64), num, randomness)


def _density(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """One half in proportion to the predicted score, one half to what it lacks of 100, among samples of the grammar."""
    preference = situation.preference
    if preference is None:
        return _grammar(situation, num, randomness)
    liking = np.clip(preference.predict(situation.pool).mean, 0.0, MAX_SCORE) / MAX_SCORE
    open_ = _unasked(situation)
    first = _drawn(open_, liking * situation.from_grammar, (num + 1) // 2, randomness)
    open_[first] = False
    second = _drawn(open_, (1.0 - liking) * situation.from_grammar, num - len(first), randomness)
    return np.concatenate((first, second))


def _uncertainty(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """In proportion to the standard deviation of the prediction, among samples of the grammar."""
    preference = situation.preference
    if preference is None:
        return _grammar(situation, num, randomness)
    deviation = preference.predict(situation.pool).std
    return _drawn(_unasked(situation), deviation * situation.from_grammar, num, randomness)


def _already_ranked(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """Scored models, those first whose score is farthest from what the others make one expect."""
    asked, first = np.unique(situation.asked[::-1], return_index=True)
    scores = situation.scores[::-1][first]
    order = randomness.permutation(len(asked))
    if situation.preference is not None:
        surprise = np.abs(situation.preference.predict(situation.pool[asked]).mean - scores)
        order = order[np.argsort(-surprise[order], kind="stable")]
    return asked[order[:num]]


def _uniform(situation: Situation, num: int, randomness: np.random.Generator) -> Ints:
    """Farthest points under the learned weights: each next model is the one least like all that are known or chosen."""
    preference, rows = situation.preference, situation.pool
    spread = np.ptp(rows, axis=0)
    weights = np.divide(1.0, spread**2, out=np.zeros(rows.shape[1]), where=spread > 0.0)
    learned = None if preference is None else preference.column_weights()
    weights = weights if learned is None or not learned.any() else learned
    scaled = rows[:, weights > 0.0] * np.sqrt(weights[weights > 0.0])
    chosen = np.empty(num, dtype=np.int64)
    nearest = np.full(len(rows), np.inf)
    for start in range(0, len(situation.asked), _TOGETHER):
        some = situation.asked[start : start + _TOGETHER]
        nearest = np.minimum(nearest, squared_distances(scaled, scaled[some]).min(axis=1))
    # Equal distances are common among counts; the seed decides between them.
    order = randomness.permutation(len(rows))
    open_ = _unasked(situation)
    for place in range(num):
        distance = np.where(open_, nearest, -1.0)[order]
        best = chosen[place] = order[np.argmax(distance)]
        open_[best] = False
        nearest = np.minimum(nearest, squared_distances(scaled, scaled[[best]])[:, 0])
    return chosen


def _unasked(situation: Situation) -> NDArray[np.bool_]:
    open_ = np.ones(len(situation.pool), dtype=bool)
    open_[situation.asked] = False
    return open_


def _drawn(open_: NDArray[np.bool_], weights: Floats, num: int, randomness: np.random.Generator) -> Ints:
    """Different open models, drawn one after the other in proportion to their weights; those of weight 0 come last."""
    # The largest of log weight + Gumbel noise are such a draw.
    with np.errstate(divide="ignore"):
        keys = np.log(np.maximum(weights, 0.0)) + randomness.gumbel(size=len(weights))
    keys = np.where(np.isfinite(keys), keys, -1e300 + randomness.random(len(weights)))
    candidates = np.flatnonzero(open_)
    return candidates[np.argsort(-keys[candidates], kind="stable")[:num]]


WAYS: dict[Way, Callable[[Situation, int, np.random.Generator], Ints]] = {
    "default": _default,
    "uniform": _uniform,
    "grammar": _grammar,
    "density": _density,
    "uncertainty": _uncertainty,
    "already ranked": _already_ranked,
}
