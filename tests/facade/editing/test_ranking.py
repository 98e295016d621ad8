import numpy as np

from grammarlab.facade.editing.edit_sequences import appearance, canonical, distinct, ranked, sequences, strain
from grammarlab.facade.editing.grids import kinds
from grammarlab.facade.editing.variations import unedited, vary
from grammarlab.facade.tree import X
from tests.facade.samples import windows


def test_columns_that_are_alike_give_one_variation() -> None:
    facade = windows(3, 4)
    found = vary(facade, "window", X, removals=False).variations
    assert len(found) == 5
    assert len(distinct(found, kinds(facade))) == 1
    assert len(ranked(found, kinds(facade))) == 1
    assert ranked((), kinds(facade)) == ()


def test_each_look_appears_once_and_ten_different_ones_come_first() -> None:
    facade = windows(2, 4, (1.0, 2.0, 3.0, 4.0))
    kind = kinds(facade)
    found = sequences(facade, "window", X, 2)
    order = ranked((*found, *found), kind)
    assert {canonical(each, kind) for each in order} == {canonical(each, kind) for each in found}
    assert len(order) == len(found)

    def nearest(variations: tuple) -> float:
        looks = [appearance(each, kind) for each in variations]
        return min(float((one != other).mean()) for i, one in enumerate(looks) for other in looks[:i])

    assert nearest(order[:10]) > nearest(found[:10])


def test_the_best_comes_first_and_the_rest_in_order() -> None:
    facade = windows(2, 5, (1.0, 2.0, 3.0, 4.0, 5.0))
    found = vary(facade, "window", X).variations
    order = ranked(found, kinds(facade), lambda variation: -variation.facade.width, different=3)
    widths = [variation.facade.width for variation in order]
    assert widths[0] == max(widths)
    assert widths[3:] == sorted(widths[3:], reverse=True)
    assert min(widths[:3]) >= np.median(widths)


def test_a_facade_is_not_strained_by_itself_and_shows_each_kind_where_it_is() -> None:
    facade = windows(2, 3, (1.0, 2.0, 3.0))
    start = unedited(facade)
    assert strain(start) == 0.0
    seen = appearance(start, np.arange(len(facade)))
    assert len(np.unique(seen)) == len(facade.leaves)
    shares = np.bincount(seen, minlength=len(facade))[facade.leaves] / len(seen)
    areas = facade.size[facade.leaves].prod(axis=1) / (facade.width * facade.height)
    assert np.abs(shares - areas).max() < 0.02
