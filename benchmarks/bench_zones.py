"""Learned zones beside their targets: three rings around a centre that nobody names, and zones by area.

Targets: Jensen-Shannon divergence of the zones of a parcel at most .02 nats after 64 answers and .005 after 256, as a
mean over towns. The divergences are in the column of extra information (`--benchmark-json`, or run this file).
"""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest

from grammarlab.city.zone_learning import LearnedZones, learned_zones
from grammarlab.city.zone_questions import first_questions, next_questions
from tests.city.towns import ZONES, Truth, by_area, counts, divergence, everywhere_alike, sampled, three_rings, town

TARGETS = {64: 0.02, 256: 0.005}
NUM_TOWNS = {64: 16, 256: 6}
_NUM_PARCELS, _FIRST, _BATCH = 2500, 16, 16


def learn(truth: Truth, num: int, seed: int, wrong: float = 0.0) -> LearnedZones:
    """Zones learned from answers about parcels chosen at random."""
    fields = town(_NUM_PARCELS, seed)
    fields = fields.take(sampled(_NUM_PARCELS, num, seed))
    return learned_zones(fields, counts(truth(fields), seed, wrong), ZONES, "0" * 64)


def learn_by_questions(truth: Truth, num: int, seed: int) -> LearnedZones:
    """Zones learned from answers to the questions that the learner asks."""
    fields = town(_NUM_PARCELS, seed)
    answers = counts(truth(fields), seed)
    row_of = {name: row for row, name in enumerate(fields.id.tolist())}
    asked = [row_of[name] for name in first_questions(fields, _FIRST)]
    while True:
        learned = learned_zones(fields.take(np.array(asked)), answers[asked], ZONES, "0" * 64)
        if len(asked) >= num:
            return learned
        asked += [row_of[name] for name in next_questions(learned, fields, min(_BATCH, num - len(asked)))]


def error(learned: LearnedZones, truth: Truth, seed: int) -> float:
    """Divergence of the learned zones of a town from the true ones."""
    fields = town(_NUM_PARCELS, seed)
    return divergence(learned.density.probabilities(fields), truth(fields))


@pytest.mark.parametrize("truth", [three_rings, by_area])
@pytest.mark.parametrize("num", TARGETS)
def test_learn_zones(benchmark, truth: Truth, num: int):
    benchmark.pedantic(learn, (truth, num, 0), rounds=2)
    errors = [error(learn(truth, num, seed), truth, seed) for seed in range(NUM_TOWNS[num])]
    benchmark.extra_info |= {"divergence": float(np.mean(errors)), "largest": max(errors)}
    assert np.mean(errors) <= TARGETS[num]


if __name__ == "__main__":
    for truth in (three_rings, by_area, everywhere_alike):
        for num in TARGETS:
            for way, learner in (("at random", learn), ("by questions", learn_by_questions)):
                start, errors = process_time(), []
                for seed in range(NUM_TOWNS[num]):
                    errors.append(error(learner(truth, num, seed), truth, seed))
                seconds = (process_time() - start) / NUM_TOWNS[num]
                print(f"{truth.__name__:18}{num:4} {way:14}{np.mean(errors):8.4f}{max(errors):8.4f}{seconds:7.2f} s")
    for truth in (three_rings, by_area):
        errors = [error(learn(truth, 64, seed, 0.1), truth, seed) for seed in range(NUM_TOWNS[64])]
        equal = [divergence(np.full((_NUM_PARCELS, 3), 1 / 3), truth(town(_NUM_PARCELS, seed))) for seed in range(4)]
        print(f"{truth.__name__:18}  64 10 % wrong   {np.mean(errors):8.4f}{max(errors):8.4f}")
        print(f"{truth.__name__:18}     no answers   {np.mean(equal):8.4f}{max(equal):8.4f}")
