"""``modify``: what is not touched follows the corners that move, and the shape stays one."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import Forest
from grammarlab.geometry.meshes.edges import is_closed_surface, joined
from grammarlab.geometry.meshes.measure import areas, volumes
from grammarlab.geometry.meshes.mesh import Meshes
from tests.derivation.operations.leaves import sampled, symbols, world_meshes

LOT = (12.0, 8.0)


def only(rule: str) -> Meshes:
    """The mesh of the only leaf, whose symbol is A."""
    forest = sampled(f"Lot --> {rule} A", LOT)
    assert symbols(forest) == ["A"]
    return world_meshes(forest)


def test_a_smaller_top_makes_a_frustum():
    """The example of the documentation; the volume is that of a prismatoid."""
    mesh = only("extrude(5) modify(f) { top : s('0.5, '0.5, '1) X. }")
    assert (mesh.num_faces, len(mesh.points)) == (6, 8)
    assert is_closed_surface(mesh).all()
    assert volumes(mesh) == pytest.approx([5 / 6 * (96 + 4 * 54 + 24)])


@pytest.mark.parametrize("kind", ["f", "e", "v", "fe"])
@pytest.mark.parametrize(
    "solid", ["extrude(3)", "roofHip(40)", "primitiveCylinder(9)", "shapeL(3, 2) { shape = extrude(2)"]
)
def test_parts_that_stay_change_nothing(kind, solid):
    rule = (
        f"{solid} modify({kind}) {{ all : X. }}"
        if "{" not in solid
        else f"inline {solid} Y }} modify({kind}) {{ all : X. }}"
    )
    before = only(solid if "{" not in solid else f"inline {solid} Y }}")
    after = only(rule)
    assert after.num_faces == before.num_faces
    assert areas(after) == pytest.approx(areas(before))
    assert volumes(after) == pytest.approx(volumes(before))
    assert after.bounds()[1] == pytest.approx(before.bounds()[1])


def test_a_ridge_that_moves_sideways_keeps_the_volume():
    """Each level section of a hip roof stays a rectangle of its size: Cavalieri's principle."""
    before, after = (joined(only(f"roofHip(45) {change}")) for change in ("", "modify(e) { ridge : t(0, 2, 0) X. }"))
    assert volumes(after) == pytest.approx(volumes(before))
    assert is_closed_surface(after).all()
    assert after.bounds()[1] == pytest.approx(before.bounds()[1])
    top = after.points[after.points[:, 1] > 3.9]
    assert sorted({*np.round(top[:, 2], 6)}) in ([2.0], [6.0])
    assert areas(after) > areas(before) + 1.0


def test_a_corner_that_two_faces_move_comes_to_the_mean_place():
    mesh = only("extrude(3) modify(f) { top : t(0, 0, 2) X. | front : t(0, 0, 2) X. }")
    points = {tuple(point) for point in np.round(mesh.points, 9).tolist()}
    # The top rises by 2, the front comes out by 2, and their common corners do half of each.
    assert points == {(x, *rest) for x in (0.0, 12.0) for rest in [(0.0, 0.0), (0.0, 10.0), (5.0, 0.0), (4.0, 9.0)]}
    assert is_closed_surface(mesh).all()


def test_a_corner_takes_its_faces_along():
    mesh = only("extrude(3) modify(v) { 0 : t(0, 0, 1) X. }")
    assert (mesh.num_faces, len(mesh.points)) == (6, 8)
    assert is_closed_surface(mesh).all()
    box = only("extrude(3)")
    assert np.abs(np.sort(mesh.points, axis=0) - np.sort(box.points, axis=0)).sum() > 0.5


def test_new_geometry_takes_the_place_of_a_part():
    bump = only("extrude(3) modify(f) { front : extrude(1) X. }")
    assert areas(bump) == pytest.approx([312.0 - 36.0 + 2 * 36.0 + 2 * 12.0 + 2 * 3.0])
    assert bump.num_faces == 5 + 6
    gone = only("extrude(3) modify(f) { front : NIL | back : split(x) { '0.5 : X. | ~1 : Y. } }")
    assert areas(gone) == pytest.approx([312.0 - 36.0])
    # The points that divide the upper and lower edges of the back are corners of the top and the bottom.
    assert sorted(np.diff(gone.face_offsets).tolist()) == [4, 4, 4, 4, 5, 5]


def test_colours_and_rules_of_parts_are_kept():
    forest = sampled(
        "Lot --> extrude(3) color(0, 0, 1) modify(f) { top : Red } A\nRed --> color(1, 0, 0) t(0, 0, 1) X.", LOT
    )
    channels = forest.materials.channels[forest.leaves.material][:, :3]
    by_colour = dict(zip(map(tuple, channels.tolist()), areas(world_meshes(forest)).tolist(), strict=True))
    assert by_colour == {(1.0, 0.0, 0.0): pytest.approx(96.0), (0.0, 0.0, 1.0): pytest.approx(96.0 + 40.0 * 4.0)}


def corners(forest: Forest) -> list[list[float]]:
    return np.round(world_meshes(forest).points, 9).tolist()


def test_models_of_a_batch_are_those_alone_and_inside_of_other_blocks():
    rule = """
    Lot --> extrude(3) split(x) { ~1 : modify(f) { top : t(0, 0, rand(0, 2)) s('0.5, '1, '1) X. | side : Side } A }*
    Side --> modify(e) { top : t(0, rand(0.1, 0.2), 0) X. } Y.
    """
    together, alone = sampled(rule, LOT, num_models=3), sampled(rule, LOT)
    assert corners(together)[: len(corners(alone))] == corners(alone)
    assert len({tuple(point) for point in corners(together)}) > len({tuple(point) for point in corners(alone)})
