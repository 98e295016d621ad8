"""Ground floors, upper storeys and ends of grids after small examples of any size."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.synthesis.label_grid import HOLE, Count, Fixed, LabelGrid, Only, Wishes
from grammarlab.synthesis.label_synthesis import Synthesis, synthesize
from grammarlab.synthesis.labels.ground_floor import with_upper_storeys
from tests.synthesis.grids import all_grids, slow_energies

NAMES = ("window", "door", "shop", "window-2", "cornice")
LETTERS = {"w": 0, "d": 1, "s": 2, "v": 3, "c": 4}


def house(*rows: str) -> LabelGrid:
    """A grid of letters, the highest row first."""
    return LabelGrid.from_labels([[LETTERS[letter] for letter in row] for row in rows[::-1]], NAMES)


def letters(result: Synthesis) -> list[str]:
    """The rows of a result, the highest first."""
    return ["".join("wdsvc"[label] for label in row) for row in result.grid.labels[::-1].tolist()]


def houses(most: int = 4) -> st.SearchStrategy[LabelGrid]:
    sizes = st.tuples(st.integers(1, most), st.integers(1, most))
    return sizes.flatmap(
        lambda size: st.lists(
            st.lists(st.integers(0, len(NAMES) - 1), min_size=size[1], max_size=size[1]),
            min_size=size[0],
            max_size=size[0],
        )
    ).map(lambda labels: LabelGrid.from_labels(labels, NAMES))


def only_in(labels: np.ndarray, line: np.ndarray) -> set[int]:
    """The labels of a line of a grid that occur nowhere else in it."""
    return {label for label in line.tolist() if (labels == label).sum() == (line == label).sum()}


@settings(max_examples=25, deadline=None)
@given(example=houses(), rows=st.integers(1, 5), columns=st.integers(1, 5), keep=st.booleans())
def test_units_of_ground_top_and_ends_stay_there(example: LabelGrid, rows: int, columns: int, keep: bool) -> None:
    result = synthesize([example], rows, columns, wishes=Wishes(keep=keep), effort=0.02)[0]
    old, new = example.labels, result.grid.labels
    if example.rows > 1:
        assert not only_in(old, old[0]) & set(new[1:].ravel().tolist())
    if example.rows > 2:
        assert not only_in(old, old[-1]) & set(new[:-1].ravel().tolist())
    if example.rows > 1 and example.columns > 2 and columns > 1:
        assert not only_in(old, old[:, 0]) & set(new[:, 1:].ravel().tolist())
        assert not only_in(old, old[:, -1]) & set(new[:, :-1].ravel().tolist())
    assert set(new.ravel().tolist()) <= set(old.ravel().tolist())
    assert result.proven == (result.energy == result.bound)


@settings(max_examples=25, deadline=None)
@given(example=houses(), seed=st.integers(0, 3))
def test_an_example_is_reproduced_at_its_own_size(example: LabelGrid, seed: int) -> None:
    result = synthesize([example], example.rows, example.columns, seed=seed)[0]
    assert np.array_equal(result.grid.labels, example.labels)
    assert (result.energy, result.bound, result.proven, result.notes) == (0, 0, True, ())


@pytest.mark.parametrize("seed", range(10))
def test_grids_after_two_storeys_are_proven_least(seed: int) -> None:
    """Compared with all grids whose upper storeys are those of the example and which have its door once."""
    generator = np.random.default_rng(seed)
    labels = generator.integers(0, 2, (2, int(generator.integers(3, 6)))) * 3  # two kinds of windows
    labels[0, 1] = 1
    example = LabelGrid.from_labels(labels, NAMES)
    grids = all_grids(3, 3, 3)
    grids = np.array([0, 3, 1])[grids[((grids == 2).sum(axis=(1, 2)) == 1) & (grids[:, 1:] < 2).all(axis=(1, 2))]]
    energies = slow_energies(np.vstack([labels[:1], *[labels[1:]] * 3]), grids)
    result = synthesize([example], 3, 3, seed=seed)[0]
    assert result.energy == result.bound == energies.min()
    assert (result.grid.labels[0] == 1).sum() == (result.grid.labels == 1).sum() == 1


@pytest.mark.parametrize(
    ("rows", "size", "result"),
    [
        (("wwww", "wdww"), (5, 7), ["wwwwwww"] * 4 + ["wdwwwww"]),
        (("wwww", "wdww"), (1, 1), ["d"]),
        (("vvvv", "wdww"), (4, 4), ["vvvv"] * 3 + ["wdww"]),
        (("cccc", "vvvv", "sdss"), (5, 6), ["cccccc"] + ["vvvvvv"] * 3 + ["sdssss"]),
        (("ww", "dw"), (3, 6), ["wwwwww"] * 2 + ["dwwwww"]),
        (("ww", "ds"), (3, 6), ["wwwwww"] * 2 + ["dsssss"]),
        (("w", "w", "d"), (5, 1), ["w"] * 4 + ["d"]),
        (("wdwww",), (3, 8), ["wwwwwwww"] * 2 + ["wdwwwwww"]),
        (("dw",), (2, 4), ["wwww", "dwww"]),
        (("vw",), (3, 2), ["vw"] * 3),
    ],
)
def test_houses_that_have_one_answer(rows: tuple[str, ...], size: tuple[int, int], result: list[str]) -> None:
    assert letters(synthesize([house(*rows)], *size)[0]) == result


@pytest.mark.parametrize(
    ("rows", "size"),
    [
        (("wwww", "wdww"), (2, 2)),  # no column between the ends
        (("www", "wdw"), (4, 7)),  # every column between the ends has a door
        (("www", "sds"), (3, 7)),
        (("wvw", "sds"), (3, 7)),  # shops are repeated, although the ends have windows of their own
        (("w", "d"), (3, 4)),  # every column has one
        (("w", "d"), (1, 4)),
        (("wwww", "dwww"), (3, 1)),
    ],
)
def test_a_single_door_stays_single_on_the_ground_floor(rows: tuple[str, ...], size: tuple[int, int]) -> None:
    result = synthesize([house(*rows)], *size)[0]
    assert (result.grid.labels == 1).sum() == (result.grid.labels[0] == 1).sum() == 1
    assert set(letters(result)[-1]) <= ({"d", "s"} if "s" in rows[-1] else {"d", "w"})
    assert not result.notes


def test_doors_that_the_example_repeats_are_repeated() -> None:
    assert letters(synthesize([house("ww", "dd")], 2, 4)[0]) == ["wwww", "dddd"]
    result = synthesize([house("wwwww", "wdwdw")], 2, 9)[0]
    assert (result.grid.labels[0] == 1).sum() == 4


def test_what_the_ground_floor_lacks_is_said() -> None:
    result = synthesize([house("d")], 2, 3)[0]
    assert letters(result) == ["ddd", "ddd"]
    assert any("repeated above the ground floor" in note for note in result.notes)
    assert any("no other unit for the ground floor" in note for note in result.notes)
    assert any("one storey" in note for note in synthesize([house("wdw")], 2, 3)[0].notes)


def test_wishes_move_units_off_the_ground() -> None:
    example = house("wwww", "wdww")
    result = synthesize([example], 4, 5, wishes=Wishes(only=(Only("door", "top"),)))[0]
    assert (result.grid.labels == 1).sum() == (result.grid.labels[3] == 1).sum() == 1
    result = synthesize([example], 4, 5, wishes=Wishes(fixed=(Fixed(2, 3, "door"),)))[0]
    assert result.grid.labels[2, 3] == 1
    assert (result.grid.labels == 1).sum(axis=1).tolist() == [1, 0, 1, 0]


def test_counts_and_rows_of_wishes_keep_ground_and_top() -> None:
    """Cells that lose their only label get others, but none of the ground floor above it, and no cornice below."""
    example = house("ccc", "www", "wdw")
    for wishes in (Wishes(counts=(Count("door", 1, 1),)), Wishes(only=(Only("door", "top"),))):
        labels = synthesize([example], 4, 6, wishes=wishes)[0].grid.labels
        assert (labels == 1).sum() == 1
        assert not (labels[:-1] == 4).any()
    with pytest.raises(FacadeError, match="window only ground: no label is left for row 1"):
        synthesize([house("www", "wdw")], 3, 5, wishes=Wishes(only=(Only("window", "ground"),)))


def test_a_map_puts_a_storey_of_shops_where_it_says() -> None:
    """Between storeys of windows: the only storey of its example is used, with its door."""
    regions = np.repeat([[0], [0], [1], [0]], 4, axis=1)
    result = synthesize([house("wwww", "vdvv"), house("sdss")], 4, 4, regions=regions, wishes=Wishes(keep=False))[0]
    assert letters(result) == ["wwww", "sdss", "wwww", "vdvv"]
    again = synthesize([house("wwww", "vdvv"), house("sdss")], 4, 4, regions=regions)[0]
    assert letters(again) == letters(result)
    mixed = synthesize([house("wwww", "vdvv"), house("sdss")], 4, 4)[0]
    assert set("".join(letters(mixed)[:-1])) == {"w"}


def test_upper_storeys_of_one_row_have_the_nearest_other_units() -> None:
    example = LabelGrid.from_labels([[1, 0, 2, 2, 3, HOLE]], NAMES)
    upper = with_upper_storeys([example], np.full((2, 6), -1))[0].labels[1:]
    assert (upper == [0, 0, 0, 3, 3, HOLE]).all()
    assert with_upper_storeys([example], np.full((1, 6), -1)) == [example]


def test_holes_at_a_border_are_not_filled_from_the_ground_floor() -> None:
    labels = house("wwww", "vvvv", "sdss").labels.copy()
    labels[2] = HOLE
    result = synthesize([LabelGrid.from_labels(labels, NAMES)], 4, 5)[0]
    assert set("".join(letters(result)[:-1])) == {"v"}
