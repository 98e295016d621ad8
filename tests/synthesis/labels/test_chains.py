from itertools import product

import numpy as np
import pytest

from grammarlab.synthesis.labels.strips import SequenceTally, cheapest, cheapest_palindrome
from tests.cases import some


def random_chain(generator: np.random.Generator, places: int, states: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    costs = [generator.integers(0, 9, (states, states, states)).astype(float) for _ in range(places)]
    costs[0] = costs[0][:1]
    costs[-1] = costs[-1][:, :, :1]
    own = [np.where(generator.random(states) < 0.15, np.inf, generator.random(states)) for _ in range(places)]
    return costs, own


def cost_of(costs: list[np.ndarray], own: list[np.ndarray], states: tuple[int, ...]) -> float:
    padded = (0, *states, 0)
    return sum(
        float(cost[padded[k], padded[k + 1], padded[k + 2]] + alone[states[k]])
        for k, (cost, alone) in enumerate(zip(costs, own, strict=True))
    )


@pytest.mark.parametrize("seed", some(range(12)))
def test_no_sequence_is_cheaper(seed: int) -> None:
    generator = np.random.default_rng(seed)
    places, states = int(generator.integers(1, 6)), int(generator.integers(1, 4))
    costs, own = random_chain(generator, places, states)
    every = list(product(range(states), repeat=places))
    least = min(cost_of(costs, own, each) for each in every)
    chain = cheapest(costs, own)
    assert chain.cost == pytest.approx(least)
    if np.isfinite(least):
        assert cost_of(costs, own, tuple(chain.states.tolist())) == pytest.approx(least)
    mirrored = cheapest_palindrome(costs, own)
    least = min(cost_of(costs, own, each) for each in every if each == each[::-1])
    assert mirrored.cost == pytest.approx(least)
    if np.isfinite(least):
        assert cost_of(costs, own, tuple(mirrored.states.tolist())) == pytest.approx(least)


@pytest.mark.parametrize("seed", some(range(12)))
def test_no_sequence_that_keeps_the_tally_is_cheaper(seed: int) -> None:
    generator = np.random.default_rng(100 + seed)
    places, states = int(generator.integers(1, 6)), 3
    costs, own = random_chain(generator, places, states)
    weight = generator.integers(0, 2, (states, 2))
    least, most = (1, 0), (2, 2)
    tally = SequenceTally((weight,) * places, least, most)

    def keeps(each: tuple[int, ...]) -> bool:
        sums = weight[list(each)].sum(axis=0)
        return bool((sums >= least).all() and (sums <= most).all())

    every = [each for each in product(range(states), repeat=places) if keeps(each)]
    for solve, kept in ((cheapest, every), (cheapest_palindrome, [each for each in every if each == each[::-1]])):
        chain = solve(costs, own, tally)
        best = min((cost_of(costs, own, each) for each in kept), default=np.inf)
        assert chain.cost == pytest.approx(best)
        if np.isfinite(best):
            found = tuple(chain.states.tolist())
            assert found in kept
            assert cost_of(costs, own, found) == pytest.approx(best)
