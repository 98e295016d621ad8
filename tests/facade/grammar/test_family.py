from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.errors import FacadeError
from grammarlab.facade.grammar.family import write_family
from grammarlab.facade.tree import LEAF, Facade, X, Y, laid_out, plain
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED
from tests.facade.grammar.houses import WIDTHS, house, of_columns
from tests.facade.strategies import trees


class Sample(NamedTuple):
    label: list[str]
    box: np.ndarray
    """[L, 4] left, bottom, width, height."""

    def of(self, label: str) -> np.ndarray:
        return self.box[[name == label for name in self.label]]

    @property
    def size(self) -> np.ndarray:
        return (self.box[:, :2] + self.box[:, 2:]).max(axis=0)


def samples(text: str, num: int = 24) -> list[Sample]:
    forest = derive(Grammar.parse(text), num, seed=3)
    model = forest.nodes.model[forest.leaves.node]
    box = np.concatenate([forest.leaves.position[:, :2], forest.leaves.size[:, :2]], axis=1)
    names = np.array([forest.symbols[symbol].lower() for symbol in forest.nodes.symbol[forest.leaves.node]])
    return [Sample(names[model == each].tolist(), box[model == each]) for each in range(num)]


def assert_tiles(sample: Sample) -> None:
    """The leaves fill the whole: their areas add up, and no two overlap."""
    low, high = sample.box[:, :2], sample.box[:, :2] + sample.box[:, 2:]
    assert np.allclose(low.min(axis=0), 0.0, atol=1e-9)
    assert np.isclose(sample.box[:, 2:].prod(axis=1).sum(), sample.size.prod(), rtol=1e-6)
    over = np.minimum(high[:, None], high[None]) - np.maximum(low[:, None], low[None])
    assert ((over > 1e-6).all(axis=2).sum(axis=1) == 1).all()


@pytest.mark.parametrize("widths", [(6.0, 10.0), (8.0, 16.0), (10.0, 40.0)])
@pytest.mark.parametrize("heights", [(6.0, 10.0), (8.0, 30.0)])
def test_every_sample_is_a_facade_of_the_same_grid(widths: tuple[float, float], heights: tuple[float, float]) -> None:
    written = write_family(house(columns=5, rows=4), widths, heights)
    assert check_text(written.text, supported=SUPPORTED) == ()
    seen = set()
    for sample in samples(written.text):
        assert_tiles(sample)
        width, height = sample.size
        assert widths[0] - 1e-9 <= width <= widths[1] + 1e-9
        assert heights[0] - 1e-9 <= height <= heights[1] + 1e-9
        assert len(sample.of("door")) == 1
        things = np.concatenate([sample.of("window"), sample.of("door")])
        assert np.allclose(things[:, 2:], [1.1, 1.5])
        columns, rows = (np.unique(things[:, axis].round(6)) for axis in (0, 1))
        assert len(things) == len(columns) * len(rows)
        assert columns[0] == 0.9
        assert np.isclose(columns[-1] + 1.1 + 0.9, width)
        assert sample.of("door")[0, 1] == 0.8
        assert columns[0] < sample.of("door")[0, 0] < columns[-1]
        seen.add((len(columns), len(rows)))
        assert written.columns[len(columns)][0] <= width + 1e-9
    assert len(seen) > 1


def walked(sample: Sample) -> str:
    """The columns of a sample, by their lowest element."""
    things = [(x, label, w) for label, (x, y, w, _) in zip(sample.label, sample.box, strict=True) if y == 0.8]
    letters = {("door", 1.1): "D", ("window", 1.1): "W", ("window", 1.6): "B", ("window2", 1.6): "B"}
    return "".join(letters[label, round(w, 6)] for _, label, w in sorted(things) if label != "wall")


def test_columns_follow_each_other_as_they_do_in_the_facade() -> None:
    facade = of_columns(["WBWDWBW", "WBWWWBW"])
    pairs = {a + b for a, b in zip("WBWDWB", "BWDWBW", strict=True)}
    walks = {walked(sample) for sample in samples(write_family(facade, (5.0, 40.0), (3.0, 9.0)).text, 60)}
    assert len(walks) > 10
    for walk in walks:
        assert walk[0] == walk[-1] == "W"
        assert walk.count("D") == 1
        assert {a + b for a, b in pairwise(walk)} <= pairs


def test_a_family_reads_as_bays_one_after_the_other() -> None:
    text = write_family(of_columns(["WBWDWBW", "WBWWWBW"]), (5.0, 20.0), (3.0, 9.0)).text
    rules = dict(line.split(" --> ", 1) for line in text.splitlines() if " --> " in line)
    bays = [body for name, body in rules.items() if "Bay" in name]
    assert len(bays) == len(set(bays)) == 3
    assert all("Pier" in body and "Column" in body for body in bays)
    states = [line.split(" -->")[0] for line in text.splitlines() if line.startswith("After")]
    assert len(states) > 10
    assert not any("_" in name for name in states)  # none needs a number to distinguish it


def test_two_doors_stay_two_in_their_order() -> None:
    text = write_family(of_columns(["WDWWDW", "WWWWWW"]), (5.0, 30.0), (3.0, 20.0)).text
    assert {walked(sample).count("D") for sample in samples(text, 40)} == {2}


def test_where_nothing_repeats_columns_and_rows_follow_themselves() -> None:
    found = write_family(of_columns(["WBD", "WBW"]), (4.0, 20.0), (4.0, 20.0))
    walks = {walked(sample) for sample in samples(found.text, 60)}
    assert len(walks) > 5
    for walk in walks:
        assert walk == "W" * walk.count("W") + "B" * walk.count("B") + "D"
    assert found.rows == {"windowRows": (1, 5)}


def test_widths_of_all_numbers_of_columns_are_equally_likely() -> None:
    text = write_family(house(columns=5, rows=4), (6.0, 20.0), (6.0, 20.0)).text
    counts = np.bincount([len(walked(sample)) for sample in samples(text, 800)])[3:]
    assert len(counts) == 7
    assert counts.min() > 800 / 7 * 0.7


def test_nearly_equal_things_are_equal_in_the_family() -> None:
    facade = of_columns(["WWWWW"] * 3)
    wanted, noise = facade.size.copy(), np.random.default_rng(0).uniform(0.98, 1.02, 11)
    for row in np.flatnonzero(facade.axis == X):
        wanted[facade.children[row], X] *= noise
    position, size = laid_out(facade.parent, facade.axis, wanted)
    names = [facade.name_of(node) for node in range(len(facade))]
    noisy = plain(facade.parent, facade.axis, position, size, names)
    assert len(np.unique(noisy.size[noisy.leaves, X].round(6))) > 10
    for sample in samples(write_family(noisy, (5.0, 20.0), (4.0, 20.0)).text):
        assert_tiles(sample)
        windows = sample.of("window")
        assert np.ptp(windows[:, 2]) < 1e-9
        assert len(np.unique(windows[:, 0].round(4))) * len(np.unique(windows[:, 1].round(4))) == len(windows)
    strict = samples(write_family(noisy, (10.0, 12.0), (4.0, 20.0), stretch=0.0).text)
    assert {tuple(np.unique(sample.of("window")[:, 2].round(6))) for sample in strict} == {
        tuple(np.unique(noisy.size[noisy.label == noisy.labels.index("window"), X].round(6)))
    }


def test_a_door_of_two_columns_and_two_rows_keeps_them_together() -> None:
    parent, axis, names, wanted = [-1], [Y], [""], [[0.0, 0.0]]

    def add(above: int, along: int, name: str = "", size: tuple[float, float] = (1.0, 1.0)) -> int:
        parent.append(above)
        axis.append(along)
        names.append(name)
        wanted.append(list(size))
        return len(parent) - 1

    lower = add(0, X)
    for part in ("side", "door", "side"):
        if part == "door":
            add(lower, LEAF, "door", (3.0, 6.0))
            continue
        side = add(lower, Y)
        for _ in range(2):
            row = add(side, X)
            for _ in range(2):
                add(row, LEAF, "window", (1.0, 2.0))
                add(row, LEAF, "wall", (1.0, 2.0))
            add(side, LEAF, "wall", (4.0, 1.0))
    for _ in range(3):
        row = add(0, X)
        for _ in range(5):
            add(row, LEAF, "wall", (1.0, 2.0))
            add(row, LEAF, "window", (1.2, 2.0))
        add(0, LEAF, "wall", (11.0, 1.0))
    position, size = laid_out(np.array(parent), np.array(axis, dtype=np.int8), np.array(wanted))
    facade = plain(np.array(parent), np.array(axis, dtype=np.int8), position, size, names)
    for sample in samples(write_family(facade, (6.0, 30.0), (6.0, 30.0)).text):
        assert_tiles(sample)
        assert len(sample.of("door")) == 1
        assert np.allclose(sample.of("door")[0, 2:], facade.size[names.index("door")])


@settings(max_examples=20, deadline=None)
@given(trees(), st.floats(0.5, 1.0), st.floats(1.0, 2.0))
def test_any_facade_has_a_family_or_an_explanation(facade: Facade, low: float, high: float) -> None:
    try:
        written = write_family(
            facade, (low * facade.width, high * facade.width), (low * facade.height, high * facade.height)
        )
    except FacadeError as error:
        if "family" not in str(error) and "narrower" not in str(error):
            raise
        return
    assert written.error is not None
    for sample in samples(written.text, 5):
        assert_tiles(sample)
        assert low * facade.width - 1e-6 <= sample.size[0] <= high * facade.width + 1e-6
        assert low * facade.height - 1e-6 <= sample.size[1] <= high * facade.height + 1e-6


@pytest.mark.parametrize(
    ("widths", "heights", "says"),
    [
        ((1.0, 2.0), (6.0, 20.0), "is 1 to 2 m wide: its columns make widths from"),
        ((6.0, 20.0), (1.0, 2.0), "is 1 to 2 m high: its fixed rows take 3.9 m, and rows of 2.7 m may be added"),
        ((6.0, 20.0), (6.0, 9e9), None),
        ((6.0, 9e9), (6.0, 20.0), None),
    ],
)
def test_ranges_without_any_facade_are_explained(
    widths: tuple[float, float], heights: tuple[float, float], says: str | None
) -> None:
    if says is None:
        assert write_family(house(columns=4, rows=3), widths, heights).facades > 100
        return
    with pytest.raises(FacadeError, match=says):
        write_family(house(columns=4, rows=3), widths, heights)


def test_the_facade_itself_is_in_its_family() -> None:
    text = write_family(house(columns=3, rows=2), (6.0, 7.0), (6.0, 7.0)).text
    assert len({tuple(sample.box.ravel().round(9).tolist()) for sample in samples(text, 5)}) == 1
    windows = samples(text, 1)[0].of("window")
    assert len(windows) == 5
    assert set(WIDTHS.values()) >= set(windows[:, 2].round(6).tolist())
