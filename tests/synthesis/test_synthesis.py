import numpy as np
import pytest

from grammarlab.errors import FacadeError
from grammarlab.synthesis.label_grid import HOLE, Count, Fixed, LabelGrid, Only, Wishes
from grammarlab.synthesis.label_synthesis import synthesize
from tests.synthesis.grids import NAMES, checker, drawn, plain_house, shop_house


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (1, 12), (12, 1), (2, 2), (2, 9), (3, 3), (1, 2)])
@pytest.mark.parametrize("method", ["exact", "em"])
def test_grids_of_any_size(rows: int, columns: int, method: str) -> None:
    for example in (
        shop_house(),
        drawn(2, 2, 3, 1),
        LabelGrid.from_labels([[0]]),
        LabelGrid.from_labels([[0, 1, 1, 0]]),
    ):
        found = synthesize([example], rows, columns, method=method)[0]  # type: ignore[arg-type, ty:invalid-argument-type]  # one of both
        assert found.grid.labels.shape == (rows, columns)
        assert found.bound <= found.energy
        assert 0.0 <= found.quality.patch_similarity <= 1.0


def test_a_single_row_is_a_ground_floor_with_its_door() -> None:
    labels = synthesize([shop_house()], 1, 9)[0].grid.labels
    assert labels[0, 0] == labels[0, -1] == 1
    assert set(labels[0].tolist()) == {1, 2, 3}
    assert (labels == 3).sum() == 1


def test_a_single_column_has_a_ground_floor_and_a_roof() -> None:
    labels = synthesize([shop_house()], 9, 1)[0].grid.labels
    assert labels[0, 0] in (1, 2, 3)
    assert labels[-1, 0] in (4, 6)


def test_one_cell_fills_everything() -> None:
    found = synthesize([LabelGrid.from_labels([[0]], ["window"])], 4, 7)[0]
    assert (found.grid.labels == 0).all()
    assert (found.energy, found.proven, found.quality.histogram) == (0, True, 0.0)


def test_examples_without_repetition_give_something() -> None:
    example = LabelGrid.from_labels(np.arange(16).reshape(4, 4))
    found = synthesize([example], 5, 6)[0]
    assert 0 < found.bound <= found.energy
    assert synthesize([example], 4, 4)[0].grid.labels.tolist() == example.labels.tolist()


def test_holes_are_filled_and_never_chosen() -> None:
    labels = shop_house().labels.copy()
    labels[2, 2] = labels[0, 4] = labels[5, 0] = HOLE
    found = synthesize([LabelGrid.from_labels(labels, NAMES)], 6, 8, effort=0.2)[0]
    assert (found.grid.labels >= 0).all()
    assert (found.grid.labels == 3).sum() == 1
    nearly = np.full((3, 3), HOLE)
    nearly[1, 1] = 0
    assert (synthesize([LabelGrid.from_labels(nearly)], 4, 4)[0].grid.labels == 0).all()


def test_large_grids_take_bounded_work_and_say_the_gap() -> None:
    found = synthesize([shop_house()], 40, 40)[0]
    assert found.bound <= found.energy
    assert found.quality.novelty < 0.1
    assert (found.grid.labels == 3).sum() == 1


def test_regions_are_made_after_their_examples() -> None:
    brick = LabelGrid.from_labels(checker(4, 4).labels, ["brick", "brick-2"])
    stone = LabelGrid.from_labels(checker(4, 4).labels, ["stone", "stone-2"])
    regions = np.zeros((6, 10), dtype=np.int64)
    regions[:, 5:] = 1
    found = synthesize([brick, stone], 6, 10, regions=regions)[0]
    assert found.grid.names == ("brick", "brick-2", "stone", "stone-2")
    assert np.array_equal(found.grid.labels >= 2, regions == 1)
    mixed = synthesize([brick, stone], 6, 10)[0]
    assert mixed.energy <= found.energy
    for wrong in (np.zeros((2, 2), dtype=np.int64), np.full((6, 10), 2), np.full((6, 10), -1)):
        with pytest.raises(FacadeError, match="regions"):
            synthesize([brick, stone], 6, 10, regions=wrong)


@pytest.mark.parametrize(
    ("wishes", "told"),
    [
        (Wishes(counts=(Count("gate", 1, 1),)), "unknown label 'gate'"),
        (Wishes(counts=(Count("door", 2, 1),)), "the first at most the second"),
        (Wishes(counts=(Count("door", -1, 1),)), "counts of at least 0"),
        (Wishes(counts=(Count("door", 50, 90),)), "only .* cells may be door"),
        (Wishes(counts=(Count("door", 0, 0),), fixed=(Fixed(0, 2, "door"),)), "cells can only be door"),
        (Wishes(counts=(Count("window", 7, 9), Count("window-2", 7, 9))), "not enough room for all of these together"),
        (Wishes(counts=(Count("door", 1, 1),), symmetric=True), "symmetric .* contradict"),
        (Wishes(fixed=(Fixed(9, 0, "door"),)), "rows 0 to 4"),
        (Wishes(fixed=(Fixed(0, 1, "door"), Fixed(0, 1, "shop"))), "both door and shop"),
        (Wishes(fixed=(Fixed(0, 1, "door"), Fixed(0, 4, "shop")), symmetric=True), "to be equal"),
        (Wishes(fixed=(Fixed(0, 0, "door"), Fixed(0, 5, "shop")), equal_corners=True), "to be equal"),
        (Wishes(fixed=(Fixed(2, 1, "door"),), only=(Only("door", "ground"),)), "door only ground"),
    ],
)
def test_contradicting_wishes_are_named(wishes: Wishes, told: str) -> None:
    with pytest.raises(FacadeError, match=told):
        synthesize([shop_house()], 5, 6, wishes=wishes)


def test_labels_stay_in_the_rows_that_are_wished_for() -> None:
    wishes = Wishes(only=(Only("door", "top"), Only("window", "between")), counts=(Count("door", 2, 2),))
    labels = synthesize([shop_house()], 5, 8, wishes=wishes)[0].grid.labels
    assert (labels[:-1] != 3).all()
    assert (labels[-1] == 3).sum() == 2
    assert (labels[[0, -1]] != 0).all()
    with pytest.raises(FacadeError, match="no such row"):
        synthesize([shop_house()], 2, 8, wishes=wishes)


def test_a_wish_goes_before_the_border() -> None:
    """Only one label of the example occurs at corners: another replaces it if the wishes exclude it."""
    labels = synthesize([shop_house()], 5, 6, wishes=Wishes(counts=(Count("corner", 0, 0),)))[0].grid.labels
    assert (labels != 1).all()


def test_a_wish_goes_before_what_is_kept() -> None:
    """Shops everywhere between the corners leave no room for the door."""
    wishes = Wishes(counts=(Count("shop", 4, 4),))
    found = synthesize([shop_house()], 4, 6, wishes=wishes)[0]
    assert (found.grid.labels == 2).sum() == 4
    assert (found.grid.labels != 3).all()
    assert found.notes


def test_equal_corners_are_equal_where_the_example_leaves_a_choice() -> None:
    example = LabelGrid.from_labels([[0, 1], [1, 0], [0, 1]])
    for seed in range(4):
        labels = synthesize([example], 3, 5, wishes=Wishes(equal_corners=True), seed=seed)[0].grid.labels
        assert labels[0, 0] == labels[0, -1]
        assert labels[-1, 0] == labels[-1, -1]


def test_what_cannot_be_kept_is_noted() -> None:
    found = synthesize([plain_house()], 3, 2)[0]
    assert any("door" in note for note in found.notes)


@pytest.mark.parametrize(("rows", "columns", "count"), [(0, 3, 1), (3, -1, 1), (300, 300, 1), (3, 3, 0), (3, 3, 101)])
def test_sizes_out_of_range_are_refused(rows: int, columns: int, count: int) -> None:
    with pytest.raises(FacadeError, match="expected"):
        synthesize([checker()], rows, columns, count=count)
    with pytest.raises(FacadeError, match="examples"):
        synthesize([], 3, 3)
