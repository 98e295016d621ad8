import math
import random
from dataclasses import replace

import pytest

from grammarlab.errors import FacadeError
from grammarlab.layers.alignment.align import Alignment, align, alignments
from grammarlab.layers.design import Letter, Weights
from tests.cases import some
from tests.layers.alignment.checking import column_widths, violations
from tests.layers.cpsat import optimum
from tests.layers.matrices import all_matrices, random_case, word

HOUSE = {"A": 1.0, "B": 1.6, "C": 1.1, "D": 1.0, "P": 2.0, "Q": 1.0, "R": 1.5}


def columns_of(words, canvas, tolerance, merge=0.05, **kwargs):
    (best,) = alignments(words, canvas, Weights(merge=merge), tolerance=tolerance, **kwargs)
    assert best.proven
    assert violations(best, canvas, tolerance) == []
    return ["|".join(column) for column in best.columns()], best


def test_columns_and_door_of_the_residential_house():
    door, columns = word("fDf", HOUSE, transparent="f"), word("CeC", HOUSE, transparent="e", partial="C")
    found, best = columns_of([door, columns, word("ABABA", HOUSE)], 6.0, 0.5)
    assert found == ["f1|C|A", "f2|e|B", "D|e|A", "f2|e|B", "f1|C|A"]
    assert best.omega == pytest.approx(0.2, abs=1e-9)
    assert best.span == pytest.approx(6.4, abs=1e-9)


def test_roof_stands_above_what_is_below():
    found, best = columns_of([word(each, HOUSE) for each in ("PQR", "PQ", "PQ", "PQ")], 4.5, 0.1)
    assert found == ["P|P|P|P", "Q|Q|Q|Q", "R|ε|ε|ε"]
    assert best.omega == 0.0


def test_split_letters_of_the_paper():
    sizes = {"A": 2.0, "B": 3.0, "C": 2.0, "e": 8.0, "f": 5.0}
    words = [
        word("fAf", sizes, transparent="f"), word("CeC", sizes, transparent="e", partial="C"), word("ABABA", sizes)
    ]  # fmt: skip
    found, best = columns_of(words, 12.0, 0.1)
    assert found == ["f1|C|A", "f2|e1|B", "A|e2|A", "f2|e1|B", "f1|C|A"]
    assert best.omega == 0.0


def test_opaque_letters_push_what_is_below_aside():
    sizes = {"A": 4.0, "B": 4.0, "I": 1.0}
    found, best = columns_of([word("IBIBI", sizes, partial="B"), word("AA", sizes)], 12.0, 1.0)
    assert found == ["I|ε", "B|A", "I|ε", "B|A", "I|ε"]
    assert (best.omega, best.span) == (0.0, 11.0)


def test_transparent_letters_keep_to_themselves():
    words = [word("CeC", HOUSE, transparent="e", partial="C"), word("ABABA", HOUSE)]
    found = alignments(words, 6.0, Weights(), 20, tolerance=0.5)
    for each in found:
        assert [column[0] for column in each.columns()].count("C") == 2
        assert each.columns()[0][0] == each.columns()[-1][0] == "C"
    assert [["C", "A"], ["e", "BAB"], ["C", "A"]] in [each.columns() for each in found]


LAYERS = {"A": 1.0, "B": 2.0, "D": 1.5, "P": 1.5, "a": None, "b": None, "d": None}


def test_by_default_the_best_size_is_covered():
    below = word("ADBDA", LAYERS)
    found, _ = columns_of([word("aPbPa", LAYERS, transparent="ab", partial="P"), below], 7.0, 0.6)
    assert [column for column in found if column.startswith("P")] == ["P|D", "P|D"]


def test_what_is_unoccludable_is_not_covered():
    below = word("ADBDA", LAYERS, unoccludable="D")
    found, _ = columns_of([word("aPa", LAYERS, transparent="a", partial="P"), below], 7.0, 0.6)
    assert [column for column in found if column.startswith("P")] == ["P|B"]


def test_what_is_opaque_may_stand_between():
    below = word("ADBDA", LAYERS, unoccludable="DAB")
    found, _ = columns_of([word("aPdPa", LAYERS, transparent="ad"), below], 10.0, 0.6)
    assert [column for column in found if column.startswith("P")] == ["P|ε", "P|ε"]


def test_what_is_attached_stays_beside_its_neighbours():
    words = [word("aPdPa", LAYERS, transparent="ad"), word("ADBDA", LAYERS, unoccludable="DAB", attached="B")]
    found, _ = columns_of(words, 10.0, 0.6)
    assert found.index("P|ε") not in {1 + at for at, column in enumerate(found[:-1]) if column.endswith("B")}
    at = next(at for at, column in enumerate(found) if column.endswith("B"))
    assert [found[at - 1][-1], found[at + 1][-1]] == ["D", "D"]


def test_merged_letters_have_a_price():
    sizes = {"I": 0.5, "J": 3.5, "G": 2.0, "C": 1.0, "A": 0.8, "B": 1.2}
    words = [word("I" + "JI" * 5, sizes), word("GCA" + "BA" * 7 + "CG", sizes)]
    free, _ = alignments(words, 21.0, Weights(merge=0.0), tolerance=0.6), None
    (dear,) = alignments(words, 21.0, Weights(merge=1.0), tolerance=0.6)
    assert (free[0].num_columns, free[0].omega) == (1, pytest.approx(0.3))
    assert dear.merged < free[0].merged
    assert dear.omega > free[0].omega


@pytest.mark.parametrize("block", some(range(25)))
def test_energy_is_that_of_cp_sat(block):
    for seed in range(20 * block, 20 * block + 20):
        words, canvas, tolerance, merge = random_case(seed, most=8 if seed % 20 == 0 else 5)
        found = alignments(words, canvas, Weights(merge=merge), tolerance=tolerance)
        least = optimum(words, int(canvas), int(tolerance), 100, round(100 * merge))
        assert [each.energy for each in found] == ([] if least is None else [pytest.approx(least / 100, abs=1e-9)])
        assert all(each.proven and not violations(each, canvas, tolerance) for each in found)


def brute_force(words, canvas, tolerance, merge):
    """Energies of all matrices that the checker accepts, ascending."""
    energies = []
    for cells in all_matrices(words):
        blank = Alignment(tuple(words), cells, 0.0, 0.0, 0, 0.0, 0.0, 0.0, proven=False)
        columns = [column_widths(words, cells, at) for at in range(blank.num_columns)]
        omega, span = math.fsum(error for error, _, _ in columns), math.fsum(width for _, width, _ in columns)
        span = span if all(exact for _, _, exact in columns) else max(span, canvas)
        merged = sum(len(element) - 1 for row in cells for element in row if element)
        if not violations(replace(blank, omega=omega, span=span, merged=merged), canvas, tolerance):
            energies.append(omega + merge * merged)
    return sorted(energies)


@pytest.mark.parametrize("block", some(range(6)))
def test_the_best_are_those_of_all_matrices(block):
    for seed in range(20 * block, 20 * block + 20):
        words, canvas, tolerance, merge = random_case(seed, most=4 if seed % 16 < 8 else 3, rows=(1, 2, 2))
        everything = brute_force(words, canvas, tolerance, merge)
        found = align(words, canvas, Weights(merge=merge), 6, tolerance=tolerance)
        assert [each.energy for each in found.best] == pytest.approx(everything[:6])
        assert found.done
        assert len({each.cells for each in found.best}) == len(found.best)


@pytest.mark.parametrize("seed", some(range(40)))
def test_mirrored_words_cost_the_same(seed):
    words, canvas, tolerance, merge = random_case(seed)
    mirrored = [each[::-1] for each in words]
    one, other = (alignments(each, canvas, Weights(merge=merge), tolerance=tolerance) for each in (words, mirrored))
    assert [each.energy for each in one] == [each.energy for each in other]


@pytest.mark.parametrize("seed", some(range(40)))
def test_longer_metres_scale_errors(seed):
    words, canvas, tolerance, merge = random_case(seed)
    large = [
        tuple(replace(letter, size=None if letter.size is None else 16.0 * letter.size) for letter in each)
        for each in words
    ]
    one = alignments(words, canvas, Weights(merge=merge), tolerance=tolerance)
    other = alignments(large, 16.0 * canvas, Weights(merge=16.0 * merge), tolerance=16.0 * tolerance)
    assert [16.0 * each.energy for each in one] == pytest.approx([each.energy for each in other])


@pytest.mark.parametrize("seed", some(range(40)))
def test_names_of_symbols_do_not_matter(seed):
    words, canvas, tolerance, merge = random_case(seed)
    names = dict(zip("ABCDEF", "UTSRQP", strict=True))
    renamed = [tuple(replace(letter, symbol=names[letter.symbol]) for letter in each) for each in words]
    one, other = (alignments(each, canvas, Weights(merge=merge), tolerance=tolerance) for each in (words, renamed))
    assert [each.cells for each in one] == [each.cells for each in other]


def test_when_effort_runs_out_a_bound_says_what_is_possible():
    sizes = {"K": 0.6, "L": 3.35, "I": 0.5, "J": 3.5, "G": 2.0, "C": 1.0, "A": 0.8, "B": 1.2}
    words = [word("K" + "LK" * 5, sizes), word("I" + "JI" * 5, sizes), word("GCA" + "BA" * 7 + "CG", sizes)]
    (best,) = alignments(words, 21.0, Weights(), tolerance=1.0)
    (hasty,) = alignments(words, 21.0, Weights(), tolerance=1.0, effort=best.merged)
    assert not hasty.proven
    assert hasty.bound <= best.energy <= hasty.energy
    assert violations(hasty, 21.0, 1.0) == []


@pytest.mark.parametrize("opaque", [False, True])
def test_many_different_words_have_an_alignment_with_a_bound(opaque):
    """25 different layers over one wall: too many for a proof."""
    rng = random.Random(3)
    words = []
    for number in range(25):
        wide, narrow = round(rng.uniform(0.8, 2.5), 2), round(rng.uniform(0.4, 1.5), 2)
        window, pier = Letter(f"W{number}", wide), Letter(f"P{number}", narrow)
        left, right = (Letter(f"{side}{number}", None, opaque=False, transparent=True) for side in ("left", "right"))
        copies = max(round((20.0 - narrow) / (wide + narrow)), 1)
        words.append((pier, *(window, pier) * copies) if opaque else (left, window, right))
    words.append(word("A" + "BA" * 7, HOUSE))
    found = align(words, 20.0, Weights(), tolerance=4.0, effort=3_000)
    (best,) = found.best
    assert violations(best, 20.0, 4.0) == []
    assert not best.proven
    assert best.bound <= best.energy


def test_no_words_no_letters_and_no_room_have_no_alignment():
    wall = word("AB", HOUSE)
    assert alignments([], 3.0, Weights(), tolerance=1.0) == []
    assert alignments([()], 3.0, Weights(), tolerance=1.0) == []
    assert alignments([wall], 1.0, Weights(), tolerance=1.0) == []
    assert alignments([word("f", {}, transparent="f")], 1.0, Weights(), tolerance=1.0) == []


def test_an_empty_word_makes_space_everywhere():
    found, _ = columns_of([word("AB", HOUSE), ()], 2.6, 0.1)
    assert found == ["A|ε", "B|ε"]


def test_a_letter_without_size_fills_the_canvas():
    _, best = columns_of([(Letter("H", None),)], 6.0, 0.0)
    assert best.span == 6.0


@pytest.mark.parametrize("canvas", [1e-6, 1.0, 1e9])
def test_canvases_of_any_size(canvas):
    sizes = {"A": 0.2 * canvas, "B": 0.4 * canvas}
    found, best = columns_of([word("ABABA", sizes)], 1.4 * canvas, 0.1 * canvas)
    assert found == list("ABABA")
    assert best.span == pytest.approx(1.4 * canvas)


@pytest.mark.parametrize(
    ("canvas", "tolerance"), [(0.0, 1.0), (1e-320, 1.0), (math.inf, 1.0), (math.nan, 1.0), (1.0, -1.0)]
)
def test_what_is_no_length_is_refused(canvas, tolerance):
    with pytest.raises(FacadeError, match="expected a canvas above 0"):
        alignments([word("A", HOUSE)], canvas, Weights(), tolerance=tolerance)


@pytest.mark.parametrize("field", ["omega", "merge", "sizing"])
def test_weights_are_numbers(field):
    with pytest.raises(FacadeError, match=f"Weight {field}"):
        Weights(**{field: -1.0})
