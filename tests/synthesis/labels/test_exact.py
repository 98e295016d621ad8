import numpy as np
import pytest

from grammarlab.synthesis.label_grid import Count, Fixed, LabelGrid, Wishes
from grammarlab.synthesis.label_synthesis import synthesize
from grammarlab.synthesis.labels.problem import bordered, energy
from tests.cases import some
from tests.synthesis.grids import all_grids, checker, drawn, plain_house, shop_house, slow_energies

FREE = Wishes(keep=False)


@pytest.mark.parametrize("seed", some(range(50)))
def test_energies_are_proven_least_on_small_grids(seed: int) -> None:
    """Compared with all grids, by another implementation of the energy."""
    generator = np.random.default_rng(seed)
    example = drawn(*generator.integers(3, 5, 2), labels=int(generator.integers(2, 4)), seed=seed)
    if seed % 3 == 0:
        example = LabelGrid.from_labels(np.tile(example.labels[:2, :2], (2, 2)))
    rows, columns = (3, 3) if len(example.names) == 3 else ((3, 4), (4, 3), (3, 5))[seed % 3]
    grids = all_grids(rows, columns, len(example.names))
    energies = slow_energies(example.labels, grids)
    found = synthesize([example], rows, columns, wishes=FREE, seed=seed)[0]
    assert found.energy == energies.min()
    assert found.proven
    assert found.energy == slow_energies(example.labels, found.grid.labels[None])[0]


def test_bounds_meet_energies_on_fifty_larger_grids() -> None:
    """6 x 6 after examples of at most 4 x 4; that bounds are none too high is tested beside all grids above."""
    proven, seeds = 0, some(range(50))
    for seed in seeds:
        generator = np.random.default_rng(seed)
        example = drawn(*generator.integers(2, 5, 2), labels=3, seed=seed)
        found = synthesize([example], 6, 6, wishes=FREE, seed=seed)[0]
        assert found.energy == energy(bordered([example], np.full((6, 6), -1)), found.grid.labels)
        proven += found.proven
    assert proven == len(seeds)


@pytest.mark.parametrize("seed", some(range(12)))
def test_wishes_are_kept_at_the_least_energy(seed: int) -> None:
    """Compared with all grids that satisfy the count or the symmetry."""
    half = drawn(3, 2, 2, seed)
    example = LabelGrid.from_labels(np.hstack([half.labels, half.labels[:, ::-1]]), half.names)
    problem = bordered([example], np.full((3, 4), -1))
    grids = all_grids(3, 4, len(example.names))
    place = np.indices((3, 4))
    grids = grids[problem.domain[place[0], place[1], grids].all(axis=(1, 2))]
    symmetric = seed % 2 == 0
    if symmetric:
        grids = grids[(grids == grids[:, :, ::-1]).all(axis=(1, 2))]
    counts = np.unique((grids == 0).sum(axis=(1, 2))).tolist()
    count = counts[seed % len(counts)]
    wishes = Wishes(counts=(Count("0", count, count),), symmetric=symmetric, keep=False)
    found = synthesize([example], 3, 4, wishes=wishes, seed=seed)[0]
    able = grids[(grids == 0).sum(axis=(1, 2)) == count]
    assert (found.grid.labels == 0).sum() == count
    assert found.energy == min(energy(problem, grid) for grid in able)
    assert found.proven


@pytest.mark.parametrize("seed", some(range(8)))
def test_periodic_examples_of_fitting_size_have_no_energy(seed: int) -> None:
    generator = np.random.default_rng(seed)
    turn = generator.integers(0, 4, generator.integers(1, 3, 2))
    inner = np.tile(turn, (3, 3))
    example = np.pad(inner, 1, constant_values=4)
    example[0, 1:-1], example[0, 0], example[-1, -1] = 5, 6, 7
    labels = np.unique(example, return_inverse=True)[1].reshape(example.shape)
    rows, columns = (2 + turn.shape[0] * 4, 2 + turn.shape[1] * 7)
    found = synthesize([LabelGrid.from_labels(labels)], rows, columns)[0]
    assert (found.energy, found.bound, found.proven, found.paper_energy) == (0, 0, True, 0)
    assert found.quality.novelty == 0.0


@pytest.mark.parametrize(
    ("example", "least"), [(checker(), 12), (plain_house(), 18), (shop_house(), 60)], ids=["checker", "plain", "shop"]
)
def test_large_grids_are_proven_least_and_never_above_the_papers_method(example: LabelGrid, least: int) -> None:
    found = synthesize([example], 8, 15)[0]
    assert (found.energy, found.bound) == (least, least)
    runs = synthesize([example], 8, 15, method="em", count=100)
    assert found.energy <= min(run.energy for run in runs)
    assert len(runs) == 100
    for run in runs[:5]:
        assert run.bound == 0
        assert not run.proven
        assert run.paper_energy == run.history[-1]


@pytest.mark.parametrize("example", [checker(), plain_house(), shop_house(), drawn(6, 6, 4, seed=0)])
def test_without_borders_the_papers_energy_is_never_above_the_papers_method(example: LabelGrid) -> None:
    found = synthesize([example], 8, 15, borders=False, effort=0.5)[0]
    runs = synthesize([example], 8, 15, borders=False, method="em", count=100)
    assert found.energy == found.paper_energy
    assert found.bound <= found.energy <= min(run.energy for run in runs)
    assert all(run.energy == run.paper_energy == run.history[-1] for run in runs)


def test_ground_floor_corners_and_door_stay() -> None:
    for example in (plain_house(), shop_house()):
        for rows, columns, seed in ((6, 6, 0), (12, 7, 2), (3, 16, 3), (4, 4, 4)):
            grid = synthesize([example], rows, columns, seed=seed)[0].grid
            house, new = example.labels, grid.labels
            assert [new[0, 0], new[0, -1], new[-1, 0], new[-1, -1]] == [
                house[0, 0],
                house[0, -1],
                house[-1, 0],
                house[-1, -1],
            ]
            assert set(new[0].tolist()) <= set(house[0].tolist())
            assert set(new[-1].tolist()) == set(house[-1].tolist())
            assert (new == grid.label("door")).sum() == 1
            assert (new[1:-1, 0] == grid.label("quoin")).all()


def test_an_axis_stays_in_the_middle_and_seeds_choose_among_equal_grids() -> None:
    example = LabelGrid.from_labels([[0, 0, 0, 0, 1, 0, 0, 0, 0]] * 4)
    for columns in (11, 13, 15, 17):
        made = synthesize([example], 4, columns, seed=columns)[0]
        assert (made.energy, made.proven) == (0, True)
        assert np.argwhere(made.grid.labels == 1)[:, 1].tolist() == [columns // 2] * 4
    even = [synthesize([example], 4, 14, seed=seed)[0].grid.labels for seed in range(8)]
    assert {int(np.argwhere(labels == 1)[0, 1]) for labels in even} == {6, 7}


def test_results_are_different_and_best_first() -> None:
    found = synthesize([shop_house()], 6, 9, count=4)
    assert len(found) == 4
    energies = [each.energy for each in found]
    assert energies == sorted(energies)
    assert len({each.grid.labels.tobytes() for each in found}) == 4
    assert len({each.bound for each in found}) == 1


def test_without_the_solver_the_gap_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grammarlab.synthesis.labels.exact.suits", lambda problem: False)
    found = synthesize([drawn(4, 4, 3, seed=11)], 6, 6)[0]
    assert 0 <= found.bound <= found.energy
    assert found.proven == (found.bound == found.energy)


def test_fixed_cells_and_corners_are_kept() -> None:
    wishes = Wishes(fixed=(Fixed(0, 3, "door"), Fixed(2, 2, "quoin")), equal_corners=True)
    labels = synthesize([shop_house()], 5, 9, wishes=wishes)[0].grid.labels
    assert labels[0, 3] == 3
    assert labels[2, 2] == 4
    assert labels[0, 0] == labels[0, -1]
    assert labels[-1, 0] == labels[-1, -1]


def test_symmetric_grids_read_the_same_from_both_sides() -> None:
    for columns in (6, 9):
        found = synthesize([shop_house()], 5, columns, wishes=Wishes(symmetric=True), effort=0.2)[0]
        assert np.array_equal(found.grid.labels, found.grid.labels[:, ::-1])
        assert (found.grid.labels == 3).sum() == (1 if columns % 2 else 2)
