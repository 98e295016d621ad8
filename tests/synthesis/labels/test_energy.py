import numpy as np
import pytest

from grammarlab.synthesis.labels.grid_search import expectation_maximization
from grammarlab.synthesis.labels.problem import Problem, bordered, distances, energy, unbordered, votes
from tests.cases import some
from tests.synthesis.grids import checker, drawn, shop_house, slow_energies


def everywhere(rows: int, columns: int) -> np.ndarray:
    return np.full((rows, columns), -1, dtype=np.int64)


def paper_energy(example: np.ndarray, grid: np.ndarray) -> int:
    """E(O) of Eq. 1 and 2 with loops."""

    def windows(labels: np.ndarray) -> list[np.ndarray]:
        rows, columns = labels.shape
        return [labels[r : r + 3, c : c + 3] for r in range(rows - 2) for c in range(columns - 2)]

    return sum(min(int((window != patch).sum()) for patch in windows(example)) for window in windows(grid))


@pytest.mark.parametrize("seed", some(range(20)))
def test_energy_equals_its_definition(seed: int) -> None:
    generator = np.random.default_rng(seed)
    example = drawn(*generator.integers(3, 7, 2), labels=4, seed=seed)
    rows, columns = generator.integers(3, 9, 2).tolist()
    grid = generator.integers(0, len(example.names), (rows, columns))
    assert energy(unbordered([example], everywhere(rows, columns)), grid) == paper_energy(example.labels, grid)
    problem = bordered([example], everywhere(rows, columns))
    place = np.indices((rows, columns))
    stray = int((~problem.domain[place[0], place[1], grid]).sum())
    assert energy(problem, grid) + 9 * stray == slow_energies(example.labels, grid[None])[0]


def test_an_example_has_no_energy() -> None:
    for example in (shop_house(), checker(), drawn(5, 4, 3, seed=1)):
        places = everywhere(example.rows, example.columns)
        for problem in (unbordered([example], places), bordered([example], places)):
            assert energy(problem, example.labels) == 0
            assert problem.domain[(*np.indices(example.labels.shape), example.labels)].all()


def test_transposing_a_problem_transposes_its_energies() -> None:
    example = shop_house()
    grid = np.random.default_rng(0).integers(0, 7, (5, 9))
    for problem in (unbordered([example], everywhere(5, 9)), bordered([example], everywhere(5, 9))):
        assert energy(problem.transposed(), grid.T) == energy(problem, grid)


def test_the_label_of_most_neighbourhoods_wins() -> None:
    """The paper's Fig. 3: a cell whose nine neighbourhoods have the labels 2, 2, 2, 2, 2, 3, 2, 2, 2 gets 2."""
    patches = np.full((2, 3, 3), 2)
    patches[1] = 3
    problem = Problem(np.zeros((3, 3), dtype=np.int64), (patches,), np.ones((3, 3, 4), dtype=np.bool_))
    nearest = np.zeros((3, 3), dtype=np.int64)
    nearest[1, 2] = 1
    assert votes(problem, nearest)[1, 1].tolist() == [0, 0, 8, 1]
    assert votes(problem, nearest).argmax(axis=2)[1, 1] == 2


@pytest.mark.parametrize("seed", some(range(12)))
def test_expectation_maximization_never_raises_the_energy(seed: int) -> None:
    example = shop_house() if seed % 2 else drawn(6, 6, 4, seed)
    problem = unbordered([example], everywhere(8, 15))
    trace = expectation_maximization(problem, seed)
    assert len(trace.history) > 1
    assert (np.diff(trace.history) <= 0).all()
    assert trace.history[-1] == energy(problem, trace.labels) == paper_energy(example.labels, trace.labels)
    again = expectation_maximization(problem, seed)
    assert np.array_equal(again.labels, trace.labels)


def test_expectation_maximization_ends_where_neither_step_changes_anything() -> None:
    problem = unbordered([checker()], everywhere(8, 15))
    trace = expectation_maximization(problem, 3)
    nearest, differ = distances(problem, trace.labels)
    assert differ.sum() == trace.history[-1]
    assert np.array_equal(votes(problem, nearest).argmax(axis=2), trace.labels)


def test_windows_of_another_region_are_of_another_example() -> None:
    ones, twos = drawn(3, 3, 1, 0).labels + 0, drawn(3, 3, 1, 0).labels + 1
    from grammarlab.synthesis.label_grid import LabelGrid

    examples = [LabelGrid.from_labels(ones, ["a", "b"]), LabelGrid.from_labels(twos, ["a", "b"])]
    regions = np.zeros((4, 6), dtype=np.int64)
    regions[:, 3:] = 1
    assert energy(bordered(examples, regions), regions) > 0
    halves = bordered(examples, regions).domain.argmax(axis=2)
    assert np.array_equal(halves, regions)
