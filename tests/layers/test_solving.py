import random
from itertools import combinations, product

import numpy as np
import pytest

from grammarlab.layers.alignment.align import alignments
from grammarlab.layers.design import Weights
from grammarlab.layers.solving import Candidate, solve
from grammarlab.layers.symbol_sizes import size_letters
from tests.cases import some
from tests.layers.alignment.checking import violations
from tests.layers.matrices import random_case, word

HOUSE = {"A": 1.0, "B": 1.6, "C": 1.1, "D": 1.0, "P": 2.0, "Q": 1.0, "R": 1.5}
TOLERANCES = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2)


def house(width, door=True):
    """Candidates of the residential house, by tolerance."""
    columns, front = word("CeC", HOUSE, transparent="e", partial="C"), word("fDf", HOUSE, transparent="f")
    roof, floors = word("PQR", HOUSE), word("PQ", HOUSE)

    def candidates(tolerance):
        for copies in range(1, 40):
            wall = word("A" + "BA" * copies, HOUSE)
            if abs(sum(letter.size or 0.0 for letter in wall) - width) <= tolerance:
                rows = (front, columns, wall) if door else (columns, wall)
                words = {(0, ""): rows, (0, "roof"): (word("H", {}),), (1, ""): (roof, *(floors for _ in rows))}
                yield Candidate({"k": copies}, words)

    return candidates


def test_the_residential_house():
    (best,) = solve(house(6.0), (6.0, 4.5), Weights(), tolerances=TOLERANCES)
    assert best.candidate.counters == {"k": 2}
    assert best.proven
    assert best.bound == best.energy == pytest.approx(0.2 + 0.019523809523809, abs=1e-9)
    expected = {"A": 104 / 105, "B": 1.514285714, "H": 6.0, "P": 2.0, "Q": 1.0, "R": 1.5}
    assert {symbol: best.sizing.sizes[symbol] for symbol in expected} == pytest.approx(expected, abs=1e-9)
    found = ["|".join(column) for column in best.alignments[0, ""].columns()]
    assert found == ["f1|C|A", "f2|e|B", "D|e|A", "f2|e|B", "f1|C|A"]


def test_another_canvas_changes_the_counter_only():
    small, large = (solve(house(width), (width, 4.5), Weights(), tolerances=TOLERANCES)[0] for width in (6.0, 12.0))
    assert (small.candidate.counters, large.candidate.counters) == ({"k": 2}, {"k": 4})
    assert small.groups == large.groups
    assert large.sizing.placed[0].ends[-1] == 12.0
    assert large.alignments[1, ""].cells == small.alignments[1, ""].cells


def test_a_door_stays_in_the_middle():
    for width in (6.0, 9.0, 14.0):
        (best,) = solve(house(width), (width, 4.5), Weights(), tolerances=TOLERANCES)
        place = best.sizing.placed[best.groups.index((0, ""))]
        assert place.lower[0][1] + place.upper[0][1] == pytest.approx(width)


def test_the_next_best_are_different_and_dearer():
    found = solve(house(6.0), (6.0, 4.5), Weights(), 5, tolerances=(1.6,))
    energies = [layout.energy for layout in found]
    assert energies == sorted(energies)
    looks = [np.concatenate([*layout.sizing.placed[0].lower, *layout.sizing.placed[2].lower]) for layout in found]
    assert len(found) == 5
    for one, other in combinations(looks, 2):
        assert one.shape != other.shape or not np.allclose(one, other, atol=1e-6)
    assert all(layout.bound <= layout.energy for layout in found)


def test_sizes_that_contradict_each_other_are_no_layout():
    def candidates(tolerance):
        for copies in range(1, 6):
            yield Candidate({"k": copies}, {(axis, ""): (word("A" * copies, HOUSE),) for axis in (0, 1)})

    # The same letters on sides of different lengths.
    assert solve(candidates, (4.0, 2.0), Weights(), tolerances=(4.0,)) == []
    (square,) = solve(candidates, (3.0, 3.0), Weights(), tolerances=(4.0,))
    assert square.candidate.counters == {"k": 3}


def test_no_candidates_no_layout():
    assert solve(lambda _: (), (4.0, 2.0), Weights(), tolerances=(1.0, 2.0)) == []


def test_without_effort_a_layout_is_not_proven():
    (best,) = solve(house(14.0), (14.0, 4.5), Weights(), tolerances=(0.8,))
    for hasty in solve(house(14.0), (14.0, 4.5), Weights(), tolerances=(0.8,), effort=10):
        assert not hasty.proven
        assert hasty.bound <= best.energy <= hasty.energy + 1e-9


def random_candidates(seed):
    """Some candidates of two groups that share symbols, with canvas and weights."""
    rng = random.Random(seed)
    words, canvas, tolerance, merge = random_case(seed, most=3, rows=(2,))
    found = []
    for copies in range(1, 4):
        wall = tuple(rng.choice(words[-1]) for _ in range(copies))
        found.append(Candidate({"k": copies}, {(0, ""): (words[0], wall), (1, ""): (words[-1] * copies,)}))
    return (
        found,
        (canvas, canvas + rng.choice([0.0, 2.0])),
        tolerance,
        Weights(merge=merge, sizing=rng.choice([0.1, 1.0])),
    )


@pytest.mark.parametrize("seed", some(range(60)))
def test_the_best_are_the_best_of_everything(seed):
    candidates, canvas, tolerance, weights = random_candidates(seed)
    energies = {}
    for number, candidate in enumerate(candidates):
        every = []
        for (axis, _), words in candidate.words.items():
            aligned = alignments(words, canvas[axis], weights, 500, tolerance=tolerance)
            assert all(not violations(each, canvas[axis], tolerance) for each in aligned)
            # All alignments of a single word look the same.
            every.append(aligned if len(set(words)) > 1 else aligned[:1])
        for together in product(*every):
            sizing = size_letters(list(zip(together, canvas, strict=True)))
            if sizing is not None:
                energy = sum(each.energy for each in together) + weights.sizing * sizing.error
                look = number, tuple(np.round(place / placed.ends[-1], 6).tobytes() for placed, alignment in
                                     zip(sizing.placed, together, strict=True)
                                     for word, lower, upper in zip(alignment.words, placed.lower, placed.upper,
                                                                   strict=True)
                                     for at, letter in enumerate(word) if not letter.transparent
                                     for place in (lower[at] + 0.0, upper[at] + 0.0))  # fmt: skip
                energies[look] = min(energy, energies.get(look, energy))
    found = solve(lambda _: candidates, canvas, weights, 3, tolerances=(tolerance,))
    assert [layout.energy for layout in found] == pytest.approx(sorted(energies.values())[:3])
    assert all(layout.proven for layout in found)


@pytest.mark.parametrize("seed", some(range(20)))
def test_the_same_question_has_the_same_answer(seed):
    candidates, canvas, tolerance, weights = random_candidates(seed)
    one, other = (solve(lambda _: candidates, canvas, weights, 3, tolerances=(tolerance,)) for _ in range(2))
    assert [layout.alignments for layout in one] == [layout.alignments for layout in other]
    assert [layout.sizing.sizes for layout in one] == [layout.sizing.sizes for layout in other]
