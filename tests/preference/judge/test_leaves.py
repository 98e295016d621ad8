"""Evidence of leaves: proper, independent of order, and equal to what brute force gives."""

from itertools import permutations, product

import numpy as np
import pytest
from scipy.special import ndtr

from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.judge.unexplained_scores import UnexplainedScores
from grammarlab.preference.person import DISLIKED, Person, possible_values


def of_all(scores):
    """Log-evidence of all scores together."""
    evidence = UnexplainedScores.of(np.array(scores, dtype=float))
    return float(evidence.log_evidence(evidence.members.sum(axis=0)[None])[0])


def test_unexplained_scores_are_a_distribution():
    evidence = UnexplainedScores.of(np.arange(101.0))
    single = evidence.members
    assert np.exp(evidence.log_evidence(single)).sum() == pytest.approx(1.0)
    pairs = single[:, None] + single[None]
    assert np.exp(evidence.log_evidence(pairs.reshape(-1, single.shape[1]))).sum() == pytest.approx(1.0)


@pytest.mark.parametrize("num_different", [2, 24, 25, 60])
def test_the_next_score_has_a_distribution_however_many_different_scores_there_are(num_different):
    """No rule changes when another score differs: the evidence with each possible next score sums to that without."""
    randomness = np.random.default_rng(num_different)
    scores = randomness.permutation(np.repeat(randomness.permutation(101)[:num_different], 3))
    following = [of_all([*scores, score]) - of_all(scores) for score in range(101)]
    assert np.exp(following).sum() == pytest.approx(1.0)


def test_the_order_of_unexplained_scores_does_not_matter():
    evidence = {round(of_all(scores), 9) for scores in permutations([0, 0, 40, 43, 100])}
    assert len(evidence) == 1


def test_each_score_is_predicted_from_those_before():
    """The evidence is a product of predictions of a Polya urn at every node, for each of four priors."""

    def urns(scores, power, narrowest):
        log_evidence = 0.0
        for number, score in enumerate(scores):
            before = np.array(scores[:number])
            for (low, high), sides, depth in nodes():
                if not low <= score <= high or low == high:
                    continue
                if high - low + 1 <= narrowest:
                    log_evidence -= np.log(high - low + 1) * (above[low, high] > narrowest)
                    continue
                counts = [((before >= a) & (before <= b)).sum() for a, b in sides]
                alpha = 0.5 * max(depth, 1) ** power
                side = next(index for index, (a, b) in enumerate(sides) if a <= score <= b)
                log_evidence += np.log((alpha + counts[side]) / (2.0 * alpha + sum(counts)))
        return log_evidence

    above = {}

    def nodes():
        yield (0, 100), [(0, 0), (1, 100)], 0
        yield (1, 100), [(100, 100), (1, 99)], 1
        waiting = [((1, 99), 2)]
        while waiting:
            (low, high), depth = waiting.pop()
            if low < high:
                middle = (low + high) // 2
                sides = [(low, middle), (middle + 1, high)]
                yield (low, high), sides, depth
                waiting += [(side, depth + 1) for side in sides]
                above.update(dict.fromkeys(sides, high - low + 1))

    scores = [0, 60, 62, 0, 100, 60]
    by_prior = [urns(scores, power, narrowest) for power in (0.0, 2.0) for narrowest in (1, 4)]
    assert of_all(scores) == pytest.approx(np.logaddexp.reduce(by_prior) - np.log(4.0))


def test_repeated_scores_and_smooth_ones_are_both_likely():
    """One value 20 times costs little more than the first time; 20 scores near each other less than 20 far ones."""
    assert of_all([50] * 20) > of_all([50]) + of_all([50] * 5)
    near, far = np.linspace(40, 60, 30).round(), np.linspace(1, 99, 30).round()
    assert of_all(near) > of_all(far)


@pytest.mark.parametrize(("noise", "blunders"), [(0.5, 0.002), (10.0, 0.1)])
def test_a_leaf_has_one_value_or_any(noise, blunders):
    scores = np.array([0.0, 0.0, 30.0, 100.0])
    unexplained = UnexplainedScores.of(scores)
    evidence = LeafEvidence.of(scores, Person(noise, blunders))
    for labels in ([0, 1], [2], [0, 2, 3], [0, 1, 2, 3]):
        total = 0.0
        for value in possible_values():
            prior = DISLIKED if value == 0.0 else (1.0 - DISLIKED) / (len(possible_values()) - 1)
            low = np.where(scores <= 0.0, -np.inf, (scores - 0.5 - value) / noise)
            high = np.where(scores >= 100.0, np.inf, (scores + 0.5 - value) / noise)
            chance = np.where((scores <= 0.0) | (scores >= 100.0), 0.005, 0.01)
            total += prior * np.prod(((1.0 - blunders) * (ndtr(high) - ndtr(low)) + blunders * chance)[labels])
        anything = unexplained.log_evidence(unexplained.members[labels].sum(axis=0)[None])[0]
        assert evidence.of_labels(np.array(labels)) == pytest.approx(np.log((total + np.exp(anything)) / 2.0), abs=1e-5)


def test_an_empty_leaf_is_certain():
    scores = np.array([0.0, 50.0])
    evidence = LeafEvidence.of(scores, Person(5.0, 0.03))
    assert evidence.of_sums(np.zeros((1, evidence.terms.shape[1])))[0] == pytest.approx(0.0)


def test_leaves_of_two_kinds_of_scores_are_worth_dividing():
    """All pairs of numbers of scores: a part of zeros and a part of eighties is better than both together."""
    for zeros, eighties in product((3, 8), repeat=2):
        scores = np.array([0.0] * zeros + [80.0] * eighties)
        evidence = LeafEvidence.of(scores, Person(5.0, 0.03))
        every = np.arange(len(scores))
        apart = evidence.of_labels(every[:zeros]) + evidence.of_labels(every[zeros:])
        assert apart > evidence.of_labels(every)
