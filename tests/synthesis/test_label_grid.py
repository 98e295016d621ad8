import numpy as np
import pytest

from grammarlab.errors import FacadeError
from grammarlab.synthesis.label_grid import HOLE, LabelGrid, joined


@pytest.mark.parametrize(
    ("labels", "told"),
    [
        ([], "at least one cell"),
        ([[]], "at least one cell"),
        ([1, 2], "rows and columns"),
        ([[1], [1, 2]], "equal length"),
        ([[0.5]], "whole numbers"),
        ([["a"]], "whole numbers"),
        ([[-2, 0]], "-1 for a hole"),
        ([[HOLE]], "all cells are holes"),
        ([[2**40]], "expected 0 to"),
        (np.zeros((300, 300), dtype=int), "at most 40,000"),
    ],
)
def test_what_is_no_grid_is_refused(labels: object, told: str) -> None:
    with pytest.raises(FacadeError, match=told):
        LabelGrid.from_labels(labels)  # type: ignore[arg-type, ty:invalid-argument-type]  # strangers give anything


def test_names_are_checked() -> None:
    with pytest.raises(FacadeError, match="label 1 has no name"):
        LabelGrid.from_labels([[0, 1]], ["a"])
    with pytest.raises(FacadeError, match="twice"):
        LabelGrid.from_labels([[0, 1]], ["a", "a"])
    with pytest.raises(FacadeError, match="expected one of a, b"):
        LabelGrid.from_labels([[0, 1]], ["a", "b"]).label("c")


def test_grids_do_not_change() -> None:
    given = np.array([[0, 1]])
    grid = LabelGrid.from_labels(given)
    given[0, 0] = 1
    assert grid.labels.tolist() == [[0, 1]]
    with pytest.raises(ValueError, match="read-only"):
        grid.labels[0, 0] = 1


def test_joined_grids_keep_their_names() -> None:
    one, other = (
        LabelGrid.from_labels([[0, 1, HOLE]], ["a", "b"]),
        LabelGrid.from_labels([[0, 1], [1, 2]], ["c", "a", "b"]),
    )
    new = joined([one, other])
    assert new[0].names == new[1].names == ("a", "b", "c")
    for old, grid in zip((one, other), new, strict=True):
        for label, number in zip(old.labels.ravel(), grid.labels.ravel(), strict=True):
            assert (label == HOLE) == (number == HOLE)
            assert label == HOLE or old.names[label] == grid.names[number]
