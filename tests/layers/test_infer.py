"""Designs inferred from facades: their layouts are the facades."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from grammarlab.errors import FacadeError
from grammarlab.facade.file import load_facade
from grammarlab.facade.reading.cutting import cut
from grammarlab.facade.tree import Facade, plain
from grammarlab.layers.design import Design, design_text
from grammarlab.layers.file import MOST_LAYERS, load_design, parse_design
from grammarlab.layers.infer import infer
from grammarlab.runs.facade.layer_files import solve_design
from grammarlab.runs.facade.layer_inference import infer_design
from tests.layers.samples import DESIGNS


def labels(facade: Facade) -> dict[str, int]:
    found = [facade.name_of(leaf) for leaf in facade.leaves.tolist()]
    return {label: found.count(label) for label in sorted(set(found) - {"wall"})}


def texts(design: Design) -> dict[str, str]:
    return {name: pattern.text for name, pattern in design.patterns.items()}


@pytest.mark.parametrize("path", sorted(DESIGNS.glob("*.json")), ids=lambda path: path.stem)
def test_shipped_facades_come_back_and_repeat_at_other_sizes(path: Path) -> None:
    facade = load_facade(path)
    found = infer_design(facade)
    assert (found.score.area, found.score.iou, found.score.quality) == pytest.approx((1.0, 1.0, 1.0), abs=1e-6)
    assert parse_design(design_text(found.design)) == found.design
    (wide,) = solve_design(found.design, 2.0 * facade.width, 1.5 * facade.height)
    assert wide.layout.proven
    more, before = labels(wide.facade), labels(facade)
    assert more.keys() == before.keys()
    assert all(more[label] >= before[label] for label in before)
    window = max(before, key=lambda label: before[label])
    assert more[window] > 1.4 * before[window]


@pytest.mark.parametrize("path", sorted(DESIGNS.glob("*.toml")), ids=lambda path: path.stem)
def test_layouts_of_designs_give_designs_of_these_layouts(path: Path) -> None:
    facade = solve_design(load_design(path))[0].facade
    score = infer_design(facade).score
    assert (score.area, score.iou) == pytest.approx((1.0, 1.0), abs=1e-6)


def boxes(rows: list[list[float]], names: list[str]) -> Facade:
    """Left, bottom, right and top of each box."""
    table = np.array(rows)
    return cut(table[:, :2], table[:, 2:], names)[0]


def row_of_windows(num: int, noise: float = 0.0) -> Facade:
    """Windows of 1.2 m in bays of 2 m, over one storey, with a wall around."""
    rng = np.random.default_rng(5)
    rows, names = [], []
    sides = [0.0]
    for each in range(num):
        sides += [2.0 * each + 0.4 + rng.normal(0.0, noise), 2.0 * each + 1.6 + rng.normal(0.0, noise)]
    sides.append(2.0 * num)
    for at, (left, right) in enumerate(pairwise(sides)):
        if at % 2:
            rows += [[left, 0.0, right, 1.0], [left, 1.0, right, 2.4], [left, 2.4, right, 3.0]]
            names += ["wall", "window", "wall"]
        else:
            rows.append([left, 0.0, right, 3.0])
            names.append("wall")
    return boxes(rows, names)


def test_what_repeats_is_a_loop() -> None:
    design = infer_design(row_of_windows(5)).design
    assert texts(design)["bays"] == "aW(bW)^ka"
    solved = solve_design(design, 26.0)[0]
    assert labels(solved.facade) == {"window": 13}


def test_hand_drawn_windows_are_alike() -> None:
    """Sides with differences of centimetres have short descriptions, and the score includes the loss."""
    found = infer_design(row_of_windows(9, noise=0.02))
    assert texts(found.design)["bays"] == "aW(bW)^ka"
    assert 0.9 < found.score.iou < 1.0
    exact = infer_design(row_of_windows(9, noise=0.02), 0.0)
    assert exact.score.iou == pytest.approx(1.0, abs=1e-6)
    assert exact.length > 2 * found.length


def test_a_band_beside_a_portal_is_one_band_behind_it() -> None:
    rows = [[0, 0, 4, 2], [6, 0, 10, 2], [4, 0, 6, 4], [0, 2, 4, 3], [6, 2, 10, 3], [0, 3, 4, 4], [6, 3, 10, 4]]
    names = ["wall", "wall", "portal", "band", "band", "wall", "wall"]
    design = infer(boxes([list(map(float, row)) for row in rows], names), 1e-6)
    assert [layer.name for layer in design.layers] == ["portal", "band", "wall"]
    assert design.layers[1].masks[0] is None


def test_sills_keep_in_step_with_windows() -> None:
    """Strips without common lines share their loop."""
    rows, names = [], []
    for each in range(6):
        left = 2.0 * each
        for low, high, sides, name in ((0, 1, (), ""), (1, 1.2, (0.3, 1.7), "sill"), (1.2, 2.4, (0.4, 1.6), "window")):
            cuts = [0.0, *sides, 2.0]
            for at, (start, end) in enumerate(pairwise(cuts)):
                rows.append([left + start, low, left + end, high])
                names.append(name if at == 1 else "wall")
    facade = boxes(rows, names)
    found = infer_design(facade)
    assert found.score.iou == pytest.approx(1.0, abs=1e-6)
    for width in (6.1, 12.0, 24.4):
        shown = labels(solve_design(found.design, width)[0].facade)
        assert shown["sill"] == shown["window"] == round(width / 2.0)


@pytest.mark.parametrize("name", ["", "wall", "window", "odd\u0007label", 'quo"te\\', "x" * 500])
def test_a_facade_of_one_leaf(name: str) -> None:
    found = infer_design(plain(np.array([-1]), np.array([-1]), np.zeros((1, 2)), np.array([[4.0, 3.0]]), [name]))
    assert len(found.design.layers) == 1
    assert parse_design(design_text(found.design)) == found.design
    assert found.solved.facade.width == 4.0


@pytest.mark.parametrize("scale", [1e-6, 1e3])
def test_facades_of_any_size(scale: float) -> None:
    facade = row_of_windows(4)
    scaled = plain(
        facade.parent, facade.axis, facade.position * scale, facade.size * scale,
        [facade.name_of(node) for node in range(len(facade))],
    )  # fmt: skip
    score = infer_design(scaled).score
    assert (score.area, score.iou) == pytest.approx((1.0, 1.0), abs=1e-6)


def test_larger_than_a_canvas_is_refused() -> None:
    with pytest.raises(FacadeError, match="at most 10,000 m"):
        infer(plain(np.array([-1]), np.array([-1]), np.zeros((1, 2)), np.array([[4.0, 3e4]]), ["a"]), 1.0)


def test_without_any_order_the_largest_are_kept() -> None:
    """1,600 windows of different sizes: the largest number of layers of a design, and a correct score."""
    rng = np.random.default_rng(2)
    rows, names = [], []
    for column in range(40):
        for row in range(40):
            (x, y), (w, h) = (column + rng.uniform(0.05, 0.3), row + rng.uniform(0.05, 0.3)), rng.uniform(0.3, 0.6, 2)
            ends = [row, y, y + h, row + 1]
            rows += [[column, row, column + 1, y], [column, y + h, column + 1, row + 1]]
            rows += [[column, y, x, y + h], [x, y, x + w, y + h], [x + w, y, column + 1, y + h]]
            names += ["wall", "wall", "wall", "window", "wall"]
            assert ends == sorted(ends)
    facade = boxes([list(map(float, each)) for each in rows], names)
    design = infer(facade, 1e-6)
    assert len(design.layers) == MOST_LAYERS
