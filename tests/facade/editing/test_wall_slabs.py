"""Columns of whole facades, and their numbers for a size."""

import tracemalloc
from collections import Counter
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.facade.editing.edit import edit
from grammarlab.facade.editing.grid_proposals import with_proposals
from grammarlab.facade.editing.slab_counts import SpringKinds, best_counts, best_slabs
from grammarlab.facade.editing.variations import unedited
from grammarlab.facade.editing.wall_slabs import Elements, _cut_between, find_elements, find_slabs
from grammarlab.facade.tree import TOLERANCE, Facade, X, Y
from tests.facade.samples import Node, across, built, leaf, stacked


@given(st.integers(1, 3), st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_numbers_are_those_of_brute_force(num: int, seed: int) -> None:
    randomness = np.random.default_rng(seed)
    kinds = SpringKinds(
        length=randomness.uniform(1.0, 4.0, num),
        give=randomness.uniform(0.01, 1.0, num),
        price=randomness.uniform(0.05, 1.0, num),
        share=randomness.uniform(0.0, 5.0, num),
        least=randomness.integers(0, 2, num),
        fixed_length=(fixed := float(randomness.choice([0.0, 3.0]))),
        fixed_give=0.1 * fixed,
        size=float(randomness.uniform(5.0, 30.0)),
    )
    counts, is_proven = best_counts(kinds)
    assert is_proven
    numbers = np.array(list(product(*(range(least, 14) for least in kinds.least.tolist()))))
    assert kinds.deformation(counts) == pytest.approx(kinds.deformation(numbers).min(), rel=1e-9)
    assert (counts >= kinds.least).all()


def townhouse(columns: int, storeys: int) -> Facade:
    """Windows with sills and shutters, between corner pillars, above a ground floor with a door, under a cornice."""
    bay = across(leaf("blind", 0.4, 1.5), leaf("window", 1.0, 1.5), leaf("blind", 0.4, 1.5))
    unit = stacked(leaf("wall", 1.8, 0.8), leaf("sill", 1.8, 0.1), bay, leaf("wall", 1.8, 0.6))

    def row(parts: list[Node], height: float) -> Node:
        gap = leaf("wall", 1.2, height)
        inner = [part for one in parts for part in (gap, one)]
        return across(leaf("pillar", 0.5, height), *inner, gap, leaf("pillar", 0.5, height))

    shop = stacked(leaf("window", 1.8, 2.6), leaf("wall", 1.8, 0.9))
    door = stacked(leaf("door", 1.8, 3.0), leaf("wall", 1.8, 0.5))
    ground = row([door if number == columns // 2 else shop for number in range(columns)], 3.5)
    width = 2.2 + 3.0 * columns
    storey = [part for _ in range(storeys) for part in (row([unit] * columns, 3.0), leaf("molding", width, 0.3))]
    return built(stacked(ground, *storey[:-1], leaf("cornice", width, 0.6)))


def counts(facade: Facade) -> Counter[str]:
    """Number of leaves of each label."""
    return Counter(facade.name_of(node) for node in facade.leaves.tolist())


@pytest.mark.parametrize("factor", [0.7, 1.3, 1.5])
def test_columns_and_rows_of_a_house_are_repeated_whole_and_its_door_and_borders_are_not(factor: float) -> None:
    house = townhouse(5, 4)
    for along, kept in ((X, ("door", "pillar", "cornice", "molding")), (Y, ("door", "cornice"))):
        metres = factor * float(house.size[0, along])
        best = edit(house, width=metres if along == X else None, height=metres if along == Y else None, most=1)[0]
        assert best.proven
        assert not best.faults
        before, count = counts(house), counts(best.facade)
        assert [count[name] for name in kept] == [before[name] for name in kept]
        # A window of a storey travels with its sill and both shutters.
        assert count["blind"] == 2 * count["sill"]
        assert count["window"] != before["window"]
        pillars = [node for node in best.facade.leaves if best.facade.name_of(node) == "pillar"]
        low, high = (side[pillars, X] for side in (best.facade.position, best.facade.position + best.facade.size))
        assert ((low < 1e-6) | (high > best.facade.width - 1e-6)).all()


def test_the_ground_floor_and_the_ends_are_fixed_unless_nothing_else_is_left() -> None:
    house = townhouse(5, 3)
    columns = find_slabs(house, X, find_elements(house, X))
    assert [slab.is_fixed for slab in columns] == [True, False, True, False, True]
    two = townhouse(2, 3)
    assert [slab.is_fixed for slab in find_slabs(two, X, find_elements(two, X))] == [False, True]
    rows = find_slabs(house, Y, find_elements(house, Y))
    assert [slab.is_fixed for slab in rows] == [True, False, False, True]


def test_multiples_are_exact_and_every_copy_equals_its_source() -> None:
    house = townhouse(5, 3)
    choice = best_slabs(unedited(house), house, X, house.width + 6.0)
    assert choice is not None
    assert choice.is_proven
    assert choice.variation.facade.width == pytest.approx(house.width + 6.0)
    best = edit(house, width=house.width + 6.0, most=1)[0]
    assert best.energy == pytest.approx(0.0, abs=1e-12)
    sizes = {(house.name_of(node), *house.size[node].round(9)) for node in house.leaves.tolist()}
    for node in best.facade.leaves.tolist():
        if best.facade.name_of(node) in {"window", "blind", "sill", "door", "pillar"}:
            assert (best.facade.name_of(node), *best.facade.size[node].round(9)) in sizes


def test_the_size_that_it_has_costs_nothing() -> None:
    house = townhouse(3, 2)
    (same,) = edit(house, width=house.width)
    assert same.proven
    assert same.energy == 0.0
    np.testing.assert_array_equal(same.facade.size, house.size)


@pytest.mark.parametrize(("columns", "rows"), [(1, 0), (-1, 0), (2, 1)])
def test_columns_and_rows_more_or_fewer_are_first_those_of_the_whole_house(columns: int, rows: int) -> None:
    house = with_proposals(townhouse(5, 3))
    best = edit(house, columns=columns, rows=rows, most=1)[0]
    assert not best.faults
    assert all(step.startswith("facade: ") for step in best.steps)
    assert counts(best.facade)["sill"] == (5 + columns) * (3 + rows)
    assert counts(best.facade)["door"] == 1
    assert best.energy == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("change", [-2, 2])
def test_a_portal_in_the_middle_stays_there(change: int) -> None:
    """One column more or fewer of each of two kinds: one on each side."""
    openings = [("window", width) for width in (1.0, 1.0, 2.0)]
    openings = [*openings, ("door", 1.5), *openings[::-1]]
    parts = [part for name, width in openings for part in (leaf("wall", 1.0, 3.0), leaf(name, width, 3.0))]
    house = built(across(*parts, leaf("wall", 1.0, 3.0)))
    # A column has half a gap on each side: one of each kind has 5 metres.
    choice = best_slabs(unedited(house), house, X, house.width + 2.5 * change)
    assert choice is not None
    changed = choice.variation.facade
    names = [changed.name_of(node) for node in changed.leaves[np.argsort(changed.position[changed.leaves, X])]]
    door = names.index("door")
    assert names.count("window") == 6 + change
    assert names[:door].count("window") == names[door:].count("window")


def test_slivers_of_windows_beside_closed_blinds_make_no_columns() -> None:
    closed = across(leaf("window", 0.1, 2.0), leaf("blind", 1.9, 2.0))
    bay = stacked(*[leaf("window", 2.0, 1.0), *[part for _ in range(5) for part in (leaf("wall", 2.0, 0.5), closed)]])
    gap = leaf("wall", 1.0, 13.5)
    house = built(across(gap, bay, gap, bay, gap, bay, gap))
    slabs = find_slabs(house, X, find_elements(house, X))
    assert [round(slab.length, 6) for slab in slabs] == [3.0, 3.0, 3.0]


@pytest.mark.parametrize("factor", [1.3, 2.0])
def test_shop_windows_of_another_rhythm_are_not_cut_into_strips(factor: float) -> None:
    window = across(leaf("wall", 1.0, 1.5), leaf("window", 1.0, 1.5), leaf("wall", 1.0, 1.5))
    shop = across(leaf("wall", 0.5, 3.0), leaf("shop", 3.5, 3.0), leaf("wall", 0.5, 3.0))
    storey = across(*[window] * 6)
    house = built(stacked(across(*[shop] * 4), *[part for _ in range(3) for part in (leaf("wall", 18.0, 1.0), storey)]))
    best = edit(house, width=factor * house.width, most=1)[0]
    shops = [node for node in best.facade.leaves if best.facade.name_of(node) == "shop"]
    assert not best.faults
    assert len(shops) >= 4
    assert best.facade.size[shops, X].min() > 2.5


def test_columns_with_a_fault_are_left_as_they_are_even_where_whole_shop_windows_leave_no_columns() -> None:
    storey = [leaf("wall" if k % 2 == 0 else "window", width, 1.5) for k, width in enumerate((3, 2, 1, 2, 3, 2, 1))]
    ground = across(leaf("door", 1.7, 3.0), leaf("shop", 6.1, 3.0), leaf("wall", 6.2, 3.0))
    house = built(stacked(ground, leaf("wall", 14.0, 1.0), across(*storey)))
    width = 1.3 * house.width
    assert best_slabs(unedited(house), house, X, width, shops=True) is None
    best = edit(house, width=width, most=1)[0]
    assert best.steps == ("facade: column 2 from the left 2 times",)
    assert not best.faults


@pytest.mark.parametrize(
    ("name", "low", "length", "factor", "cut", "fixed"),
    [
        ("signboard", 4.6, 4.0, 0.7, 8.7, [0, 2, 3, 7]),  # over two columns
        ("ShopSign", 3.2, 1.5, 2.0, 4.775, [0, 1, 7]),  # most of it in one; the cut is beside it
        ("shop_logo2", 3.2, 4.0, 2.0, 4.5, [0, 1, 2, 7]),  # across every place for a cut
    ],
)
def test_signs_are_neither_cut_nor_repeated_where_other_columns_are(
    name: str, low: float, length: float, factor: float, cut: float, fixed: list[int]
) -> None:
    gap, window = leaf("wall", 1.0, 2.0), leaf("window", 1.0, 2.0)
    row = across(*[part for _ in range(8) for part in (gap, window)], gap)
    fascia = across(leaf("wall", low, 1.0), leaf(name, length, 1.0), leaf("wall", 17.0 - low - length, 1.0))
    house = built(stacked(row, fascia, row))
    slabs = find_slabs(house, X, find_elements(house, X))
    assert cut in [pytest.approx(slab.begin) for slab in slabs]
    assert [index for index, slab in enumerate(slabs) if slab.is_fixed] == fixed
    changed = edit(house, width=factor * house.width, most=1)[0].facade
    signs = [node for node in changed.leaves.tolist() if changed.name_of(node) == name]
    assert changed.size[signs, X] == pytest.approx([length], rel=0.25)
    assert counts(changed)["window"] != 16


@given(st.data())
@settings(max_examples=20, deadline=None)
def test_what_is_alone_in_its_storey_stays_alone_and_whole(data: st.DataObject) -> None:
    """Windows of unequal bays, and above them an element anywhere: one bay inside without an end of it is enough."""
    gaps = data.draw(st.lists(st.sampled_from([0.8, 1.0, 1.2]), min_size=7, max_size=9))
    parts = [part for gap in gaps for part in (leaf("wall", gap, 2.0), leaf("window", 1.0, 2.0))]
    row = across(*parts, leaf("wall", 1.0, 2.0))
    width = sum(gaps) + len(gaps) + 1.0
    length = data.draw(st.floats(0.2, 4.0))
    low = data.draw(st.floats(0.1, width - length - 0.1))
    name = data.draw(st.sampled_from(["deco", "balcony", "cornice"]))
    above = across(leaf("wall", low, 1.0), leaf(name, length, 1.0), leaf("wall", width - low - length, 1.0))
    house = built(stacked(row, above, row))
    slabs = find_slabs(house, X, find_elements(house, X))
    assert any(not slab.is_fixed for slab in slabs)
    for slab in slabs:
        has_end = any(slab.begin + 1e-6 < end < slab.end - 1e-6 for end in (low, low + length))
        assert slab.is_fixed or not has_end
    changed = edit(house, width=data.draw(st.sampled_from([1.3, 2.0])) * house.width, most=1)[0].facade
    assert counts(changed)[name] == 1
    assert counts(changed)["window"] > counts(house)["window"]


def test_what_is_alone_is_repeated_where_all_other_columns_have_a_fault() -> None:
    window = across(leaf("wall", 1.0, 1.5), leaf("window", 1.0, 1.5), leaf("wall", 1.0, 1.5))
    ground = across(leaf("wall", 7.0, 3.0), leaf("shop", 5.0, 3.0))
    house = built(stacked(ground, across(*[window] * 4), across(leaf("wall", 4.0), leaf("deco"), leaf("wall", 7.0))))
    # The third column has the end of the shop window, the second one the ornament.
    assert [slab.is_fixed for slab in find_slabs(house, X, find_elements(house, X))] == [True, True, False, True]
    best = edit(house, width=1.25 * house.width, most=1)[0]
    assert best.steps == ("facade: column 2 from the left 2 times",)
    assert not best.faults


def random_wall(randomness: np.random.Generator, width: float, height: float, depth: int) -> Node:
    """Elements cut from a rectangle, on a grid of 0.5 m or up to 10 nm beside it."""
    along = int(randomness.integers(2))
    whole = (width, height)[along]
    if not depth or whole < 2.0:
        return leaf(str(randomness.choice(["wall", "deco", "deco", "balcony", "cornice", "window"])), width, height)
    cut = 0.5 * int(randomness.integers(1, int(2.0 * whole))) + 5e-9 * int(randomness.integers(-2, 3))
    sizes = [(cut, height), (width - cut, height)] if along == X else [(width, cut), (width, height - cut)]
    return (across, stacked)[along](*(random_wall(randomness, *size, depth - 1) for size in sizes))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_elements_that_are_alone_are_those_of_brute_force(seed: int) -> None:
    wall = built(random_wall(np.random.default_rng(seed), 12.0, 9.0, 6))
    elements = find_elements(wall, X)
    bottom, label = wall.position[elements.node, Y], wall.label[elements.node]
    top = bottom + wall.size[elements.node, Y]

    def is_beside(one: int, other: int) -> bool:
        overlap = min(top[one], top[other]) - max(bottom[one], bottom[other])
        return label[one] == label[other] and overlap > TOLERANCE * wall.height

    indices = range(len(elements.node))
    alone = np.array([[other for other in indices if is_beside(one, other)] == [one] for one in indices], dtype=bool)
    can_be = ~(elements.is_solid | elements.is_whole | elements.is_sign)
    assert elements.is_alone.tolist() == (alone & can_be).tolist()
    for other in (find_elements(wall, X, singles=False), find_elements(wall, Y)):
        assert not other.is_alone.any()


def test_memory_for_elements_grows_with_their_number() -> None:
    wall = built(stacked(*[across(*[leaf("deco"), leaf("window")] * 40)] * 30))
    tracemalloc.start()
    elements = find_elements(wall, X)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # Pairs of them would need 5.76 million bytes for a single comparison.
    assert peak < 1000 * len(elements.node)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60)
def test_a_cut_crosses_as_little_of_openings_and_then_of_elements_as_any_other_position(seed: int) -> None:
    randomness = np.random.default_rng(seed)
    num = int(randomness.integers(1, 9))
    low = randomness.uniform(-0.5, 0.9, num)
    high = low + randomness.uniform(0.05, 1.0, num)
    is_solid = randomness.random(num) < 0.5
    thickness = randomness.uniform(0.1, 3.0, num)
    elements = Elements(
        node=np.arange(num),
        low=low,
        high=high,
        thickness=thickness,
        is_solid=is_solid,
        is_whole=np.zeros(num, dtype=bool),
        is_sign=np.zeros(num, dtype=bool),
        is_alone=np.zeros(num, dtype=bool),
    )

    def crossed(position: float) -> tuple[float, float]:
        is_crossed = (low < position) & (position < high)
        sizes = thickness * is_crossed
        return round(float(sizes[is_solid].sum()), 6), round(float(sizes.sum()), 6)

    cut = _cut_between(0.0, 1.0, elements, 1e-8)
    edges = np.unique(np.clip([*low, *high, 0.0, 1.0], 0.0, 1.0))
    assert crossed(cut) == min(crossed(0.5 * (begin + end)) for begin, end in pairwise(edges.tolist()))
