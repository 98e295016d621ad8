import numpy as np
import pytest

from grammarlab.synthesis.label_grid import Count, Wishes
from grammarlab.synthesis.labels.demands import LabelDemands, demands_of
from grammarlab.synthesis.labels.dual_bounds import Dual, strips_alone, swept
from grammarlab.synthesis.labels.problem import AWAY, bordered, energy, unbordered
from grammarlab.synthesis.labels.strips import WindowStrips
from tests.cases import some
from tests.synthesis.grids import all_grids, checker, drawn, plain_house, shop_house, slow_energies


def everywhere(rows: int, columns: int) -> np.ndarray:
    return np.full((rows, columns), -1, dtype=np.int64)


@pytest.mark.parametrize("seed", some(range(8)))
def test_no_labels_of_a_strip_have_less_energy(seed: int) -> None:
    generator = np.random.default_rng(seed)
    example, columns = drawn(4, 4, 2, seed), 4
    problem = (bordered if seed % 2 else unbordered)([example], everywhere(3, columns))
    prices = generator.random((3, 3, columns, problem.num_labels)) * 2
    energies, labels = WindowStrips.from_problem(problem, range(3)).least(prices)
    grids = all_grids(3, columns, problem.num_labels)
    place = np.indices((3, columns))
    for row in range(3):
        around = [each for each in range(row - 1, row + 2) if 0 <= each < 3]
        total = np.zeros(len(grids))
        for each in around:
            chosen = prices[row, each - row + 1, place[1][each], grids[:, each]].sum(axis=1)
            allowed = problem.domain[each, place[1][each], grids[:, each]].all(axis=1)
            total += np.where(allowed, chosen, np.inf)
        padded = np.pad(grids, ((0, 0), (1, 1), (1, 1)), constant_values=AWAY)
        for column in range(columns):
            if problem.kind[row, column] >= 0:
                window = padded[:, None, row : row + 3, column : column + 3]
                patches = problem.patches[problem.kind[row, column]]
                total += ((window != patches) & (patches != AWAY)).sum(axis=(2, 3)).min(axis=1)
        assert energies[row] == pytest.approx(total.min(), abs=1e-4)
        best = grids[total < total.min() + 1e-4]
        found = labels[row, [each - row + 1 for each in around]]
        assert any(np.array_equal(found, grid[around]) for grid in best)


@pytest.mark.parametrize("seed", some(range(10)))
def test_bounds_are_never_above_the_least_energy(seed: int) -> None:
    example = drawn(3, 3, 2, seed) if seed % 3 else checker(3, 3)
    grids = all_grids(3, 4, len(example.names))
    least = slow_energies(example.labels, grids).min()
    problem = bordered([example], everywhere(3, 4))
    problem = problem.within(problem.domain)
    demands = LabelDemands(problem.domain, (), symmetric=False)
    for turned in (problem, problem.transposed()):
        assert strips_alone(turned) <= least
    dual = Dual(problem, demands)
    bounds = []
    for _ in dual.steps(float(least), 40):
        bounds.append(dual.bound)
        assert dual.integer_bound <= least
    assert bounds[0] == pytest.approx(strips_alone(problem))
    assert (np.diff(bounds) >= 0).all()


@pytest.mark.parametrize("symmetric", [False, True])
def test_bounds_know_counts_and_symmetry(symmetric: bool) -> None:
    example = plain_house()
    problem = bordered([example], everywhere(4, 15))
    wishes = Wishes(counts=(Count("door", 1, 1),), symmetric=symmetric)
    demands = demands_of(problem.domain, [example], wishes)
    problem = problem.within(demands.domain)
    free = strips_alone(problem)
    dual = Dual(problem, demands)
    house = plain_house().labels
    across = [0] + 6 * [1] + [2] + 6 * [1] + [5] if symmetric else [0, 1, 2, 3] + 10 * [4] + [5]
    grid = house[np.ix_([0, 1, 2, 5], across)]
    assert demands.broken(grid) == 0
    for _ in dual.steps(20.0, 30):
        assert dual.integer_bound <= energy(problem, grid)
    assert dual.integer_bound > free


@pytest.mark.parametrize("seed", some(range(6)))
def test_sweeps_only_raise_the_bound(seed: int) -> None:
    """Prices that strips pass on sum to 0 over a cell, so that the bound stays valid."""
    example = shop_house() if seed == 0 else drawn(4, 4, 3, seed)
    size = (5, 8) if seed == 0 else (3, 4)
    problem = bordered([example], everywhere(*size))
    strips = WindowStrips.from_problem(problem, range(problem.rows))
    bounds = []
    for sweeps in range(5):
        prices = swept(problem, np.zeros((problem.rows, 3, problem.columns, problem.num_labels)), sweeps)
        total = np.zeros((problem.rows + 2, *problem.domain.shape[1:]))
        for up in range(3):
            total[up : up + problem.rows] += prices[:, up]
        assert np.allclose(total, 0.0, atol=1e-9)
        bounds.append(float(strips.least(prices)[0].sum()))
    assert (np.diff(bounds) >= -1e-3).all()
    assert bounds[-1] > bounds[0]
    if seed and len(example.names) == 2:
        assert bounds[-1] <= slow_energies(example.labels, all_grids(*size, 2)).min() + 1e-3
