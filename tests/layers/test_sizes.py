from importlib import import_module
from typing import Any

import numpy as np
import pytest
from scipy import sparse

from grammarlab.layers.alignment.align import alignments
from grammarlab.layers.alignment_equations import demands, equations, least_error
from grammarlab.layers.design import Letter, Weights
from grammarlab.layers.symbol_sizes import Squares, size_letters
from tests.layers.matrices import random_case, word

clarabel: Any = import_module("clarabel")  # has no types

HOUSE = {"A": 1.0, "B": 1.6, "C": 1.1, "D": 1.0}
WALL, COLUMNS = word("ABABA", HOUSE), word("CeC", HOUSE, transparent="e", partial="C")
DOOR = word("fDf", HOUSE, transparent="f")


def sized(words, canvas=6.0, tolerance=0.5, **kwargs):
    (best,) = alignments(words, canvas, Weights(), tolerance=tolerance)
    found = size_letters([(best, canvas)], **kwargs)
    assert found is not None
    return found


@pytest.mark.parametrize(("copies", "error"), [(1, 1.152), (2, 0.04 / 13), (3, 0.3136)])
def test_errors_of_the_residential_walls(copies, error):
    found = sized([word("A" + "BA" * copies, HOUSE)], tolerance=3.0)
    assert found.error == pytest.approx(error, abs=1e-9)


def test_columns_of_the_residential_house():
    found = sized([COLUMNS, WALL])
    expected = {"C": 84 / 85, "e": 4.023529411764706, "A": 84 / 85, "B": 1.517647058823529}
    assert found.sizes == pytest.approx(expected, abs=1e-9)
    assert found.error == pytest.approx(0.019411764705882, abs=1e-9)


def test_door_of_the_residential_house():
    found = sized([DOOR, COLUMNS, WALL])
    expected = {"A": 104 / 105, "C": 104 / 105, "D": 104 / 105, "B": 1.514285714, "e": 4.019047619, "f": 2.504761905}
    assert found.sizes == pytest.approx(expected, abs=1e-9)
    assert found.error == pytest.approx(0.019523809523809, abs=1e-9)


def test_columns_that_are_not_opaque_may_stand_over():
    found = sized([COLUMNS, WALL], gaps=True)
    assert found.sizes == pytest.approx({"A": 12.4 / 13, "B": 20.4 / 13, "C": 1.1, "e": 53.2 / 13}, abs=1e-9)
    assert found.error == pytest.approx(0.04 / 13, abs=1e-9)
    place = found.placed[0]
    low, high = place.lower[0][0], place.upper[0][0]
    assert high - low - place.ends[1] == pytest.approx(0.146153846, abs=1e-9)
    assert low + high == pytest.approx(place.ends[1], abs=1e-12)


def test_split_letters_of_the_paper():
    sizes = {"A": 2.0, "B": 3.0, "C": 2.0, "e": 8.0, "f": 5.0}
    words = [
        word("fAf", sizes, transparent="f"), word("CeC", sizes, transparent="e", partial="C"), word("ABABA", sizes)
    ]  # fmt: skip
    found = sized(words, 12.0)
    assert found.sizes == pytest.approx(sizes)
    assert np.diff(found.placed[0].ends) == pytest.approx([2, 3, 2, 3, 2])


def test_what_is_left_is_shared_equally():
    found = sized([word("fgA", HOUSE, transparent="fg"), word("BA", HOUSE)], 2.6)
    assert found.sizes["f"] == pytest.approx(found.sizes["g"])


def test_symbols_have_one_size_in_all_groups():
    one, other = ([word(text, HOUSE)] for text in ("ABA", "BAB"))
    aligned = [
        (alignments(each, 4.0, Weights(), tolerance=1.0)[0], canvas) for each, canvas in ((one, 4.0), (other, 4.0))
    ]
    found = size_letters(aligned)
    assert found is not None
    assert found.sizes == pytest.approx({"A": 4 / 3, "B": 4 / 3})


def test_lengths_that_contradict_each_other_have_no_sizes():
    (best,) = alignments([word("AA", HOUSE)], 2.0, Weights(), tolerance=0.5)
    assert size_letters([(best, 2.0), (best, 2.5)]) is None


def test_nothing_has_no_sizes():
    found = size_letters([])
    assert found is not None
    assert (found.sizes, found.error) == ({}, 0.0)


def solved_by_clarabel(squares):
    num = squares.matrix.shape[1]
    quadratic, linear = np.zeros((num, num)), np.zeros(num)
    np.add.at(quadratic, (squares.index, squares.index), 2.0)
    np.add.at(linear, squares.index, -2.0 * squares.target)
    rows = sparse.csc_matrix(np.concatenate([squares.matrix, -np.eye(num)]))
    value = np.concatenate([squares.value, np.full(num, -squares.least)])
    cones = [clarabel.ZeroConeT(len(squares.value)), clarabel.NonnegativeConeT(num)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solution = clarabel.DefaultSolver(sparse.csc_matrix(quadratic), linear, rows, value, cones, settings).solve()
    if str(solution.status) not in {"Solved", "AlmostSolved"}:
        return None
    x = np.asarray(solution.x)
    return float(np.square(x[squares.index] - squares.target).sum())


def cases():
    for seed in range(300):
        words, canvas, tolerance, merge = random_case(seed)
        for best in alignments(words, canvas, Weights(merge=merge), 2, tolerance=tolerance):
            yield best, canvas


def test_sizes_are_those_of_clarabel_and_hold_all_equations():
    solved = pressed = 0
    for best, canvas in cases():
        system = equations([(best, canvas)], gaps=False)
        squares = Squares(
            system.matrix, system.value, system.target_index, system.target, 1e-6 * canvas, canvas
        )  # fmt: skip
        error = solved_by_clarabel(squares)
        found = size_letters([(best, canvas)])
        assert (found is None) == (error is None)
        if found is None:
            continue
        solved += 1
        pressed += min(found.sizes.values()) < 1e-5 * canvas
        assert found.error == pytest.approx(error, abs=1e-6)
        assert found.residual <= 1e-9
        assert least_error([demands(best, canvas, gaps=False)]) <= found.error + 1e-12
        check_places(found, best, canvas)
    assert solved > 150
    assert pressed > 3


def check_places(found, best, canvas):
    (place,) = found.placed
    assert place.ends[0] == 0.0
    assert place.ends[-1] == canvas
    assert (np.diff(place.ends) > 0.0).all()
    for each, row, lower, upper in zip(best.words, best.cells, place.lower, place.upper, strict=True):
        assert (upper > lower).all()
        for letter, low, high in zip(each, lower, upper, strict=True):
            assert high - low == pytest.approx(found.sizes[letter.symbol], abs=1e-9)
        for column, element in enumerate(row):
            whole = [at for at, _ in element]
            if whole and not any(part for _, part in element) and (whole[-1], 1) not in sum(row, ()):
                assert lower[whole[0]] == pytest.approx(place.ends[column], abs=1e-9)
                assert upper[whole[-1]] == pytest.approx(place.ends[column + 1], abs=1e-9)
            assert [lower[after] for after in whole[1:]] == pytest.approx([upper[at] for at in whole[:-1]], abs=1e-9)


def test_sizes_far_from_what_is_preferred_stay_positive():
    words = [(Letter("A", 1.0), Letter("B", 5.0), Letter("B", 5.0)), (Letter("A", 1.0), Letter("C", 1.0))]
    (best,) = alignments(words, 3.0, Weights(), tolerance=9.0)
    found = size_letters([(best, 3.0)])
    assert found is not None
    assert min(found.sizes.values()) > 0.0
    assert found.residual <= 1e-9
