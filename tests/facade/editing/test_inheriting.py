"""Locks of variations."""

import numpy as np

from grammarlab.facade.editing.variations import inherited, lost, unedited, vary
from grammarlab.facade.sizes.size_wishes import Aspect, Position, Size
from grammarlab.facade.tree import X, Y
from tests.facade.samples import windows


def test_a_lock_is_lost_with_the_last_copy_of_its_part_or_of_a_part_with_an_equal_lock() -> None:
    facade = windows(2, 3)
    places = facade.grids[0].places()
    one, other = int(places[0, 0]), int(places[0, 2])
    locks = [Size(one, X, 1.0), Size(other, X, 1.0), Aspect(one, 0.5, 1.0), Size(0, Y, facade.height)]
    removals = vary(facade, "window", X, insertions=False).variations
    assert len(removals) == 3
    for variation in removals:
        gone = not np.isin(one, variation.source)
        assert lost(facade, locks, variation) == ((locks[2],) if gone else ())
        assert lost(facade, locks[:1], variation) == ((locks[0],) if gone else ())
        assert len(inherited(locks, variation)) == len(locks) - (2 if gone else not np.isin(other, variation.source))


def test_places_are_not_lost_since_they_do_not_apply_to_variations() -> None:
    facade = windows(2, 3)
    assert lost(facade, [Position(3, X, 1.0)], unedited(facade)) == ()
