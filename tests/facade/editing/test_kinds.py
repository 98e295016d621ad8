import tracemalloc
from dataclasses import replace

import numpy as np
from hypothesis import given

from grammarlab.facade.editing.grids import is_background, kinds, single_shops, types
from grammarlab.facade.tree import TOLERANCE, Facade
from tests.facade.samples import across, built, leaf, stacked
from tests.facade.strategies import trees


def written(facade: Facade, node: int) -> str:
    return f"{facade.axis[node]}{facade.name_of(node)}({','.join(written(facade, c) for c in facade.children[node])})"


@given(trees())
def test_types_are_equal_exactly_where_trees_are_written_alike(facade: Facade) -> None:
    forms = [written(facade, node) for node in range(len(facade))]
    assert len(set(zip(forms, types(facade).tolist(), strict=True))) == len(set(forms)) == len(set(types(facade)))
    # A kind is a part of a type.
    assert len(set(zip(kinds(facade).tolist(), types(facade).tolist(), strict=True))) == len(set(kinds(facade)))


def test_sizes_that_differ_by_more_than_a_twentieth_are_of_two_kinds() -> None:
    facade = built(across(leaf("a", 1.0), leaf("a", 1.04), leaf("a", 1.2), leaf("b", 1.0)))
    kind = kinds(facade)
    assert (kind[1] == kind[2], kind[2] == kind[3], kind[1] == kind[4]) == (True, False, False)


def test_an_arch_and_a_rectangle_are_of_two_kinds_of_one_type() -> None:
    arch = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.6], [0.5, 1.0], [0.0, 0.6]]
    flat = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.97], [0.5, 1.0], [0.0, 0.97]]
    facade = built(across(*(leaf("a", 1.0) for _ in range(4))))
    outlines = [np.zeros((0, 2)), *(np.array(each).reshape(-1, 2) for each in (arch, flat, [], arch))]
    offsets = np.cumsum([0, *map(len, outlines)])
    facade = replace(facade, outline_offsets=offsets, outline_points=np.concatenate(outlines))
    assert len(set(types(facade)[1:])) == 1
    kind = kinds(facade)
    assert (kind[1] == kind[4], kind[2] == kind[3], kind[1] == kind[2]) == (True, True, False)


def test_walls_and_what_has_no_name_are_background() -> None:
    facade = built(stacked(leaf("Wall"), leaf(""), leaf("window")))
    assert np.array_equal(is_background(facade), [True, True, True, False])


@given(trees())
def test_single_shops_are_those_that_touch_no_other(facade: Facade) -> None:
    facade = replace(facade, labels=tuple("shop" if name == "window" else name for name in facade.labels))
    shops = [leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) == "shop"]
    low, high = facade.position / facade.size[0], (facade.position + facade.size) / facade.size[0]

    def touches(one: int, other: int) -> bool:
        return bool((np.maximum(low[one] - high[other], low[other] - high[one]) <= TOLERANCE).all())

    single = [one for one in shops if not any(touches(one, other) for other in shops if other != one)]
    assert np.flatnonzero(single_shops(facade)).tolist() == single


def test_single_shops_of_many_need_little_memory() -> None:
    num = 2_000
    facade = built(across(*(leaf(name) for _ in range(num) for name in ("shop", "wall"))))
    single_shops(facade)
    tracemalloc.start()
    try:
        assert single_shops(facade).sum() == num
        assert tracemalloc.get_traced_memory()[1] < num**2
    finally:
        tracemalloc.stop()
