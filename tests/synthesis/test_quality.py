import numpy as np
import pytest

from grammarlab.synthesis.label_grid import HOLE, LabelGrid
from grammarlab.synthesis.label_synthesis import quality_of
from tests.synthesis.grids import checker, drawn, shop_house


def test_an_example_is_as_near_to_itself_as_can_be() -> None:
    for example in (shop_house(), checker(), LabelGrid.from_labels([[0]]), drawn(2, 5, 3, 0)):
        quality = quality_of(example.labels, [example])
        assert (quality.patch_similarity, quality.cooccurrence, quality.histogram, quality.novelty) == (1, 0, 0, 0)


def test_what_shares_nothing_is_as_far_as_can_be() -> None:
    quality = quality_of(np.full((5, 5), 2), [checker()])
    assert (quality.patch_similarity, quality.cooccurrence, quality.histogram, quality.novelty) == (0, 1, 1, 1)


def test_patch_similarity_goes_both_ways() -> None:
    half = LabelGrid.from_labels(np.hstack([np.zeros((6, 6), dtype=int), np.ones((6, 6), dtype=int)]))
    part = quality_of(np.zeros((6, 6), dtype=int), [half])
    assert part.novelty == 0.0
    assert part.patch_similarity < 1.0
    assert part.histogram == pytest.approx(0.5)


def test_distances_are_those_of_the_definition() -> None:
    generator = np.random.default_rng(0)
    for _ in range(5):
        example, grid = generator.integers(0, 3, (4, 5)), generator.integers(0, 3, (6, 3))
        quality = quality_of(grid, [LabelGrid.from_labels(example)])
        of_labels = [np.bincount(each.ravel(), minlength=3) / each.size for each in (grid, example)]
        assert quality.histogram == pytest.approx(np.abs(of_labels[0] - of_labels[1]).sum() / 2)
        tables = []
        for each in (grid, example):
            table = np.zeros((2, 3, 3))
            np.add.at(table[0], (each[:, :-1].ravel(), each[:, 1:].ravel()), 1)
            np.add.at(table[1], (each[:-1].ravel(), each[1:].ravel()), 1)
            tables.append(table / table.sum())
        assert quality.cooccurrence == pytest.approx(np.abs(tables[0] - tables[1]).sum() / 2)


def test_holes_agree_with_everything() -> None:
    labels = checker().labels.copy()
    labels[2, 3] = HOLE
    quality = quality_of(checker().labels, [LabelGrid.from_labels(labels)])
    assert quality.novelty == 0.0
    assert quality.patch_similarity == 1.0
