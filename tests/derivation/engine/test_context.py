"""Spatial queries: overlaps, touches, inside, distances, ranks and numbers of labelled shapes."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation

from grammarlab.derivation import derive
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.lots import Lots
from grammarlab.geometry.meshes.contact import Body, distances_to_boxes
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box
from grammarlab.language.grammar import Grammar


def leaves(text: str, *lots, **options) -> Counter[str]:
    """Number of leaves of each symbol."""
    forest = derive(Grammar.parse(text), *(lots or (1, 1)), **options)
    return Counter(forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node])


def cuboid(low, high) -> Body:
    mesh = box()
    low, high = np.array(low, float), np.array(high, float)
    return Body(mesh.with_points(low + mesh.points * (high - low)))


def sheet(*corners) -> Body:
    return Body(Meshes.single(np.array(corners, float), [list(range(len(corners)))]))


@pytest.mark.parametrize(
    ("make", "corners", "inside", "overlaps", "touches"),
    [
        (cuboid, ([1, 1, 1], [3, 3, 3]), False, True, True),
        (cuboid, ([2, 0, 0], [3, 2, 2]), False, False, True),
        (cuboid, ([0.5, 0.5, 0.5], [1, 1, 1]), True, True, True),
        (cuboid, ([3, 0, 0], [4, 1, 1]), False, False, False),
        (cuboid, ([2, 2, 2], [3, 3, 3]), False, False, False),
        (cuboid, ([0, 0, 0], [2, 2, 2]), True, True, True),
        (sheet, ([0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]), True, False, True),
        (sheet, ([0.5, 0.5, 1], [1, 0.5, 1], [1, 1, 1], [0.5, 1, 1]), True, True, True),
        (sheet, ([1, 0.5, 1], [4, 0.5, 1], [4, 1, 1], [1, 1, 1]), False, True, True),
        (sheet, ([2, 0.5, 1], [4, 0.5, 1], [4, 1, 1], [2, 1, 1]), False, False, False),
    ],
)
def test_bodies_are_related_as_their_points_are(make, corners, inside, overlaps, touches):
    body, cube = make(*corners), cuboid([0, 0, 0], [2, 2, 2])
    assert (body.is_inside(cube), body.overlaps(cube), body.touches(cube)) == (inside, overlaps, touches)


def test_an_open_surface_is_no_occluder():
    assert not cuboid([0, 0, 0], [1, 1, 1]).overlaps(sheet([0, 0, 0], [9, 0, 0], [9, 9, 9], [0, 9, 9]))


def test_distances_of_boxes_are_those_of_their_nearest_points():
    rng = np.random.default_rng(5)
    axes = Rotation.from_rotvec(3.0 * rng.normal(size=(25, 3))).as_matrix()
    position, size, box_size = 2.5 * rng.normal(size=(25, 3)), 2.0 * rng.random((25, 3)), np.array([1.0, 2.0, 3.0])
    distances = distances_to_boxes((np.zeros(3), box_size, np.eye(3)), (position, size, axes))
    for k, distance in enumerate(distances):
        matrix = np.hstack([np.diag(box_size), -axes[k] * size[k]])
        nearest = lsq_linear(matrix, position[k], bounds=(0.0, 1.0), tol=1e-14)
        assert distance == pytest.approx(np.linalg.norm(matrix @ nearest.x - position[k]), abs=1e-5)
    assert (distances == 0.0).any()


def test_walls_are_compared_with_the_masses_beside_their_own():
    steps = """Lot --> extrude(12) split(x) { ~5 : Step }*
               Step --> s('1, '(split.index + 1) / 4, '1) comp(f) { right : Wall | left : Wall }
               Wall --> case touches(intra) : Hidden else : Seen"""
    assert leaves(steps, footprint=(15.0, 5.0)) == {"Hidden": 4, "Seen": 2}


def test_queries_have_their_default_values_in_the_first_derivation():
    # All trees are in the way of one another, so none is left, though without the query all would stand.
    text = """Lot --> split(x) { ~1 : Tree }*
              Tree --> s(3, 3, 3) primitiveCube() Check
              Check --> case overlaps() : NIL else : Stands."""
    assert leaves(text, footprint=(6.0, 6.0)) == {}
    assert leaves(text, footprint=(1.0, 6.0)) == {"Stands.": 1}


def test_a_labelled_query_sees_labelled_shapes_only():
    text = """Lot --> extrude(3) split(x) {{ ~1 : A | ~1 : B }}
              A --> label("a") Solid.
              B --> s(8, '1, '1) t(-4, 0, 0) Check
              Check --> case overlaps(intra, "{}") : Hit. else : Free."""
    assert leaves(text.format("a"))["Hit."] == 1
    assert leaves(text.format("b"))["Free."] == 1
    assert leaves(text.format(""))["Hit."] == 1


def test_distances_ranks_and_numbers_of_labelled_shapes():
    text = """Lot --> split(x) { ~1 : Column(split.index) }*
              Column(i) --> extrude(i + 1) label("column") Ask
              Ask --> report("count", contextCount(intra, "column"))
                      report("highest", contextCompare(intra, "column", world.highest))
                      report("west", contextCompare(all, "column", world.westernmost))
                      report("distance", minimumDistance(intra, "column"))
                      report("nothing", minimumDistance(intra, "absent"))"""
    forest = derive(Grammar.parse(text), 1, 1, footprint=(4.0, 2.0))
    values = {key: forest.reports.value[forest.reports.key == i] for i, key in enumerate(forest.reports.keys)}
    assert values["count"].tolist() == [4.0] * 4
    assert values["highest"].tolist() == [3.0, 2.0, 1.0, 0.0]
    assert values["west"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert values["distance"].tolist() == [0.0] * 4
    assert np.isinf(values["nothing"]).all()


SQUARE = np.array([[0.0, 0.0, 10.0], [10.0, 0.0, 10.0], [10.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
NEIGHBOURS = Lots.concatenate(
    [Lots.of(1, 1, first_model=i, footprint=x * np.eye(3)[0] + SQUARE) for i, x in enumerate([0.0, 9.0, 40.0])]
)
HOUSES = "Lot --> extrude(10) Mass  Mass --> case overlaps(inter) : Hit. else : Free."


def test_models_see_each_other_only_where_they_stand_together():
    assert leaves(HOUSES, NEIGHBOURS) == {"Free.": 3}
    assert leaves(HOUSES, NEIGHBOURS, together=True) == {"Hit.": 2, "Free.": 1}


def test_a_model_does_not_depend_on_its_batch():
    text = """Lot --> extrude(rand(3, 9)) split(x) { ~rand(2, 4) : Part }*
              Part --> s(rand(1, 6), '1, '1) Check
              Check --> case overlaps(intra) : color(1, 0, 0) A else : B"""
    batch = derive(Grammar.parse(text), 4, 3)
    for model in range(4):
        alone = derive(Grammar.parse(text), 1, 3, first_model=model)
        rows = batch.nodes.model[batch.leaves.node] == model
        assert np.array_equal(batch.leaves.position[rows], alone.leaves.position)
        assert np.array_equal(batch.leaves.size[rows], alone.leaves.size)


def test_only_grammars_with_queries_are_derived_twice():
    selectors = "Lot --> offset(-2, inside) comp(f) { inside : In | border : Edge }"
    assert not compile_grammar(Grammar.parse(selectors)).queries_context
    assert compile_grammar(Grammar.parse("Lot --> case inside : A else : B")).queries_context
    assert not compile_grammar(Grammar.parse("inside = true  Lot --> case inside : A else : B")).queries_context
