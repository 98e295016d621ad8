"""Bounds from alignments on sizes before these are solved for."""

import pytest

from grammarlab.layers.alignment.align import Alignment, align
from grammarlab.layers.design import Weights
from grammarlab.layers.symbol_sizes import size_letters
from tests.cases import some
from tests.layers.matrices import random_case, word

SIZES = {"D": 3.2, "J": 3.6, "C": 0.5}
GATE = [word("hDh", SIZES, transparent="h"), word("C" + "JC" * 3, SIZES)]


def sized(alignment: Alignment, canvas: float) -> tuple[float, tuple[float, ...]] | None:
    """Error of sizes, and positions of all visible letters; None if there are no sizes."""
    sizing = size_letters([(alignment, canvas)])
    if sizing is None:
        return None
    (placed,) = sizing.placed
    look = tuple(
        round(float(place[at]), 5)
        for letters, lower, upper in zip(alignment.words, placed.lower, placed.upper, strict=True)
        for at, letter in enumerate(letters)
        if not letter.transparent
        for place in (lower, upper)
    )
    return sizing.error, look


@pytest.mark.parametrize("block", some(range(5)))
def test_sizes_cost_at_least_the_strain_of_their_alignment(block: int) -> None:
    for seed in range(30 * block, 30 * block + 30):
        words, canvas, tolerance, merge = random_case(seed, most=4)
        for each in align(words, canvas, Weights(merge=merge), 8, tolerance=tolerance, sizing=1.0).best:
            found = sized(each, canvas)
            assert found is None or each.strain <= found[0] + 1e-6


def test_a_gate_that_is_not_in_the_middle_is_strained() -> None:
    """Both of its neighbours are of one symbol, so that bays would have size 0."""
    found = align(GATE, 12.8, Weights(), 40, tolerance=6.0, sizing=1.0).best
    middle = [each for each in found if [column for column in each.columns() if column[0] == "D"] == [["D", "J"]]]
    assert any(each.strain == pytest.approx(0.08) for each in middle)  # D and J become 3.4
    besides = [each for each in found if each not in middle]
    assert min(each.strain for each in besides) > 0.0


@pytest.mark.parametrize("block", some(range(4)))
def test_what_is_left_out_looks_like_something_better(block: int) -> None:
    for seed in range(20 * block, 20 * block + 20):
        words, canvas, tolerance, merge = random_case(seed, most=3)
        everything, finest = (
            align(words, canvas, Weights(merge=merge), 60, tolerance=tolerance, finest=each) for each in (False, True)
        )
        if len(everything.best) == 60:
            continue
        best: list[dict[tuple[float, ...], float]] = []
        for found in (everything, finest):
            looks: dict[tuple[float, ...], float] = {}
            for each in found.best:
                if made := sized(each, canvas):
                    looks.setdefault(made[1], each.energy)
            best.append(looks)
        assert best[0] == best[1]
