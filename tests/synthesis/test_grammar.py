from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from grammarlab.cli import app
from grammarlab.derivation import derive
from grammarlab.errors import FacadeError
from grammarlab.facade.grammar.rule_text import leaf_body
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED
from grammarlab.synthesis.grid_grammar import Units, write_label_family
from grammarlab.synthesis.label_grid import HOLE, LabelGrid
from tests.synthesis.grids import NAMES, plain_house, shop_house

WIDTH, HEIGHT = 2.0, 3.0


def units(grid: LabelGrid, bodies: tuple[str, ...] | None = None) -> Units:
    return Units(
        np.full(grid.columns, WIDTH),
        np.full(grid.rows, HEIGHT),
        bodies or tuple(leaf_body(name) for name in grid.names),
    )


def sampled(text: str, names: list[str], num: int = 40) -> list[np.ndarray]:
    """The grids of labels of derivations."""
    forest = derive(Grammar.parse(text), num, seed=5)
    symbols = np.array([forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]])
    model = forest.nodes.model[forest.leaves.node]
    grids = []
    for each in range(num):
        place = forest.leaves.position[model == each]
        column, row = (np.rint(place[:, axis] / size).astype(int) for axis, size in ((0, WIDTH), (1, HEIGHT)))
        grid = np.full((row.max() + 1, column.max() + 1), -1)
        grid[row, column] = [names.index(symbol) for symbol in symbols[model == each]]
        assert (grid >= 0).all()
        assert grid.size == (model == each).sum()
        grids.append(grid)
    return grids


SYMBOLS = ["Window", "Corner", "Shop", "Door", "Quoin", "Window2", "Roof"]


@pytest.mark.parametrize("house", [shop_house(), plain_house()], ids=["shop", "plain"])
def test_every_sample_keeps_ground_floor_corners_and_door(house: LabelGrid) -> None:
    written = write_label_family(house, units(house), (8.0, 40.0), (9.0, 40.0))
    assert check_text(written.text, supported=SUPPORTED) == ()
    grids = sampled(written.text, SYMBOLS)
    for grid in grids:
        assert grid[0, 0] == grid[0, -1] == 1
        assert (grid[1:, [0, -1]] == 4).all()
        assert (grid[1:, 1:-1] != 4).all()
        assert (grid[-1, 1:-1] == 6).all()
        assert set(grid[0, 1:-1].tolist()) <= {2, 3}
        assert (grid == 3).sum() == 1
        assert set(map(tuple, grid.T.tolist())) >= {tuple(grid[:, 0].tolist())}
    assert len({grid.shape for grid in grids}) > 5


def test_columns_follow_each_other_as_in_the_example() -> None:
    """Columns that are never adjacent in the example are never adjacent in a sample, unless a column repeats."""
    house = LabelGrid.from_labels(
        [[0, 1, 2, 3, 1, 2, 3, 1, 4], [5, 6, 7, 8, 6, 7, 8, 6, 9], [5, 6, 7, 8, 6, 7, 8, 6, 9]]
    )
    written = write_label_family(house, units(house), (8.0, 60.0), (6.0, 6.0))
    pairs = set(zip(house.labels[0, :-1].tolist(), house.labels[0, 1:].tolist(), strict=True))
    seen = set()
    for grid in sampled(written.text, [f"Part{k}" for k in range(10)]):
        seen |= set(zip(grid[0, :-1].tolist(), grid[0, 1:].tolist(), strict=True))
    assert seen == pairs


def test_one_size_alone_gives_back_the_example() -> None:
    house = LabelGrid.from_labels(np.arange(9).reshape(3, 3))
    written = write_label_family(house, units(house), (6.0, 6.0), (9.0, 9.0))
    for grid in sampled(written.text, [f"Part{k}" for k in range(9)], num=3):
        assert np.array_equal(grid, house.labels)


def test_units_are_meshes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Sampled from the command line, the models are as large as their cells."""
    house = LabelGrid.from_labels(shop_house().labels, (*NAMES[:-1], "wall"))
    (tmp_path / "assets").mkdir()
    for k in range(len(NAMES)):
        trimesh.creation.box((1.0, 1.0, 0.5)).export(tmp_path / "assets" / f"unit-{k}.glb")
    bodies = tuple(f"s('1, '1, 0.3) i(\"unit-{k}.glb\")" for k in range(len(NAMES)))
    written = write_label_family(house, units(house, bodies), (12.0, 24.0), (12.0, 24.0))
    rules = tmp_path / "family.cga"
    rules.write_text(written.text, encoding="utf-8")
    out = tmp_path / "out"
    with pytest.raises(SystemExit) as ended:
        app(["sample", str(rules), "-n", "4", "-o", str(out), "--no-image", "--jobs", "1"])
    assert ended.value.code in (0, None)
    capsys.readouterr()
    for file in sorted(out.glob("*.glb")):
        size = np.ptp(trimesh.load(file).bounds, axis=0)
        assert np.allclose(size[:2] / [WIDTH, HEIGHT], np.rint(size[:2] / [WIDTH, HEIGHT]), atol=1e-4)
        assert size[2] == pytest.approx(0.3, abs=1e-4)
    assert len(list(out.glob("*.glb"))) == 4


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"widths": np.full(5, 2.0)}, "6 widths"),
        ({"heights": np.full(6, 0.0)}, "6 heights above 0"),
        ({"heights": np.full(6, np.nan)}, "6 heights above 0"),
        ({"bodies": ("NIL",)}, "7 bodies"),
    ],
)
def test_units_that_do_not_fit_are_refused(change: dict[str, object], told: str) -> None:
    house = shop_house()
    given: dict[str, Any] = {"widths": np.full(6, 2.0), "heights": np.full(6, 3.0), "bodies": ("NIL",) * 7, **change}
    with pytest.raises(FacadeError, match=told):
        write_label_family(house, Units(**given), (8.0, 20.0), (9.0, 30.0))


def test_ranges_without_a_facade_say_what_there_is() -> None:
    with pytest.raises(FacadeError, match="columns make widths from"):
        write_label_family(shop_house(), units(shop_house()), (1.0, 2.0), (9.0, 30.0))
    with pytest.raises(FacadeError, match="rows"):
        write_label_family(shop_house(), units(shop_house()), (8.0, 30.0), (1.0, 2.0))
    labels = shop_house().labels.copy()
    labels[2, 2] = HOLE
    with pytest.raises(FacadeError, match="holes"):
        write_label_family(LabelGrid.from_labels(labels, NAMES), units(shop_house()), (8.0, 30.0), (9.0, 30.0))
