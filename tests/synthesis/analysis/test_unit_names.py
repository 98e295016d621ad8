"""Names of units: doors, tall windows and fronts of shops."""

import numpy as np
import pytest

from grammarlab.synthesis.analysis.unit_names import NamedOpenings, names_of

Opening = tuple[int, float, float, float]
"""Label, foot above the ground, width and height, metres."""
WINDOWS: list[Opening] = [(1, 0.95, 1.1, 1.5)] * 3 + [(1, 3.9, 1.1, 1.5)] * 4


def name(*kind: Opening, others: list[Opening] = WINDOWS) -> str:
    """Name of label 0 in a wall of these openings and others, beside each other."""
    openings = [*kind, *others]
    x = 2.0 * np.arange(len(openings))
    boxes = np.array(
        [
            (start, foot, start + width, foot + height)
            for start, (_, foot, width, height) in zip(x, openings, strict=True)
        ]
    )
    counts = [1] * (1 + max(label for label, *_ in openings))
    return names_of(NamedOpenings(boxes, np.array([label for label, *_ in openings]), 0.0), counts)[0]


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ([(0, 0.0, 1.0, 2.1)], "door"),
        ([(0, 0.15, 2.9, 3.3)], "door"),  # a gate
        ([(0, 0.5, 1.0, 2.0)], "door"),  # above three steps
        ([(0, 0.95, 1.0, 2.0)], "window"),  # as high as the windows beside it
        ([(0, 0.8, 1.0, 2.0)], "window"),  # less than a step lower
        ([(0, 0.0, 1.0, 1.2)], "window"),
        ([(0, 0.3, 2.6, 2.0)], "shop"),
        ([(0, 0.8, 2.3, 2.4)] * 4, "shop"),
        ([(0, 0.0, 1.0, 2.2), (0, 3.0, 1.0, 2.2)], "window"),  # French windows upstairs
        ([(0, 0.0, 1.0, 2.2)] * 5, "shop"),  # most of the storey
        ([(0, 0.5, 1.0, 2.0)] * 5, "window"),
    ],
)
def test_a_door_has_its_foot_at_the_ground_or_below_the_windows_beside_it(kind: list[Opening], expected: str) -> None:
    assert name(*kind) == expected


def test_two_doors_of_a_house_of_two_families_are_doors() -> None:
    assert name((0, 0.1, 1.0, 2.1), (0, 0.1, 1.0, 2.1)) == "door"


def test_a_wall_with_nothing_but_a_raised_door_has_a_door() -> None:
    assert name((0, 0.5, 1.0, 2.1), others=[]) == "door"


def test_names_are_unique_and_say_what_has_no_or_several_elements() -> None:
    openings = NamedOpenings(np.zeros((0, 4)), np.zeros(0, dtype=np.int64), 0.0)
    assert names_of(openings, [0, 1, 2, 0, 1]) == ["wall", "window", "unit", "wall-2", "window-2"]
