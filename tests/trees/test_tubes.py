"""Wood of trees: closed tubes, their volumes, joints and texture coordinates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from grammarlab.trees.detail import StemDetail
from grammarlab.trees.growth import grow
from grammarlab.trees.rings import WIDENING
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.species import Look
from grammarlab.trees.stem_axes import CLONE_START
from grammarlab.trees.taper import radii
from grammarlab.trees.tubes import Rings, num_triangles, tubes
from grammarlab.trees.wood import draw, plan
from tests.cases import some
from tests.trees.meshes import bark, directed_edges, volume, welded
from tests.trees.rows import ASPEN, random_row, row, tree_keys

DETAILS = ("full", "medium", "low")


def straight(radius: list[float], sides: int, height: float = 2.0, lobes: int = 0, depth: float = 0.0) -> Rings:
    """An upright stem with cross-sections of these radii at equal distances."""
    num = len(radius)
    return Rings(
        tree=np.zeros(1, np.int64),
        offsets=np.array([0, num]),
        sides=np.array([sides]),
        centre=np.linspace(0.0, 1.0, num)[:, None] * (0.0, height, 0.0),
        tangent=np.tile([0.0, 1.0, 0.0], (num, 1)),
        side=np.tile([1.0, 0.0, 0.0], (num, 1)),
        radius=np.array(radius),
        lobes=np.array([lobes]),
        lobe_depth=np.array([depth]),
    )


def aspens(num: int) -> Skeleton:
    return grow(np.tile(row(**{**ASPEN, "leaves": 2.0}), (num, 1)), tree_keys(num))


def test_a_cylinder_has_the_volume_of_its_prism_and_a_low_dome():
    meshes, _ = tubes(straight([0.3, 0.3, 0.3], 12), 1)
    ground = 12 / 2 * 0.3**2 * math.sin(2 * math.pi / 12)
    assert volume(meshes.points, meshes.corners.reshape(-1, 3)) == pytest.approx(ground * (2.0 + 0.4 * 0.3 / 3))


def test_a_cone_has_a_third_of_the_volume():
    meshes, _ = tubes(straight([0.3, 0.15, 0.0], 24), 1)
    ground = 24 / 2 * 0.3**2 * math.sin(2 * math.pi / 24)
    assert volume(meshes.points, meshes.corners.reshape(-1, 3)) == pytest.approx(ground * 2.0 / 3.0)


def test_pictures_repeat_at_most_a_thousand_times():
    _, surface = tubes(straight([0.001, 0.001, 0.0], 3, height=500.0), 1)
    assert surface.coordinates[:, 1].max() == pytest.approx(1000.0)


@pytest.mark.parametrize("detail", DETAILS)
def test_a_trunk_has_the_volume_of_a_cone(detail: str):
    """A straight trunk of one segment without flare: its prism's share of the cone's third."""
    named = {"levels": 1.0, "flare": 0.0, "curve_res_0": 6.0, "ratio": 0.05, "scale": 10.0}
    points, triangles = bark(realize_trees(grow(row(**named)[None], tree_keys(1)), Look(), detail))  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]
    cone = math.pi * 0.5**2 * 10.0 / 3.0
    assert 0.4 * cone < volume(points, triangles) < cone
    if detail == "full":
        assert volume(points, triangles) == pytest.approx(cone, rel=0.03)


@pytest.mark.parametrize("lobes", [3, 5])
def test_lobes_are_those_of_the_formula(lobes: int):
    meshes, _ = tubes(straight([0.3, 0.3, 0.3], 60, lobes=lobes, depth=0.2), 1)
    x, _, z = meshes.points[:60].T
    # About +y the angle runs from the side, +x, towards tangent x side, -z.
    angle = np.arctan2(-z, x)
    np.testing.assert_allclose(np.hypot(x, z), 0.3 * (1.0 + 0.2 * np.sin(lobes * angle)))


@pytest.mark.parametrize("lobes", [0, 5])
def test_normals_are_those_of_the_surface(lobes: int):
    """Smooth normals of a fine tube are near to the normals of its triangles."""
    meshes, surface = tubes(straight(list(np.linspace(0.4, 0.1, 40)), 120, lobes=lobes, depth=0.1), 1)
    triangles = meshes.corners.reshape(-1, 3)[: 120 * 2 * 37]
    a, b, c = meshes.points[triangles].transpose(1, 0, 2)
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    assert (np.einsum("ti,tki->tk", flat, surface.normals[triangles]) > 0.99).all()


def test_pictures_go_round_a_whole_number_of_times_and_keep_their_proportions():
    meshes, surface = tubes(straight([0.5, 0.5, 0.5], 16, height=4.0), 1)
    u, v = surface.coordinates[:-1].reshape(3, 17, 2).transpose(2, 0, 1)
    assert (u[:, 0] == 0.0).all()
    np.testing.assert_allclose(u[:, -1], 3.0)
    np.testing.assert_allclose(v, np.broadcast_to([[0.0], [2.0], [4.0]], (3, 17)) * 3.0 / math.pi)
    np.testing.assert_array_equal(meshes.points[0], meshes.points[16])


@pytest.mark.parametrize("detail", DETAILS)
@pytest.mark.parametrize("seed", some(range(60)))
def test_every_edge_has_two_triangles_in_opposite_directions(seed: int, detail: str):
    scene = realize_trees(grow(random_row(seed)[None], tree_keys(1, seed)), Look(), detail)  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]
    points, triangles = bark(scene)
    shared = welded(points, triangles)
    assert (shared[:, [0, 1, 2]] != shared[:, [1, 2, 0]]).all()
    np.testing.assert_array_equal(directed_edges(shared), directed_edges(shared[:, ::-1]))
    assert volume(points, triangles) > 0.0
    normals = scene.surface.normals if scene.surface is not None else np.zeros((0, 3))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)


@pytest.mark.parametrize("detail", DETAILS)
def test_every_tube_is_closed_and_faces_outwards(detail: str):
    """The stems of a tree one by one: pieces of its mesh that share points."""
    points, triangles = bark(realize_trees(aspens(1), Look(), detail))  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]
    shared = welded(points, triangles)
    edges = directed_edges(shared)
    num = int(shared.max()) + 1
    count, piece = connected_components(coo_array((np.ones(len(edges)), edges.T), (num, num)), directed=False)
    a, b, c = points[triangles].transpose(1, 0, 2)
    volumes = np.bincount(piece[shared[:, 0]], np.einsum("ti,ti->t", a - a[0], np.cross(b - a[0], c - a[0])), count)
    assert count > 100
    assert (volumes > 0.0).all()
    # A sphere's: vertices - edges + triangles = 2.
    euler = np.bincount(piece) - np.bincount(piece[edges[:, 0]]) / 2 + np.bincount(piece[shared[:, 0]])
    assert (euler == 2).all()


def test_triangles_are_those_of_the_formula():
    meshes, _ = tubes(straight([0.3, 0.2, 0.1, 0.0], 7), 1)
    assert meshes.num_faces == num_triangles(np.array([3]), np.array([7]))[0]


@pytest.mark.parametrize("seed", some(range(40)))
def test_stems_begin_inside_their_parents(seed: int):
    """The first ring of a stem is within its parent's radius of the parent's axis there, and no wider."""
    trees = grow(random_row(seed)[None], tree_keys(1, seed))
    parents = None
    for level, stems in enumerate(trees.levels):
        part = plan(trees, level)
        counts = part.stations.counts
        levels = StemDetail(np.ones(len(stems), bool), counts, np.full(len(stems), 6))
        drawn = draw(trees, level, part, levels, parents)
        first = drawn.stations.offsets[:-1]
        child = np.flatnonzero((stems.parent >= 0) & ~stems.is_clone)
        if parents is not None and len(child):
            length = trees.levels[level - 1].length[stems.parent[child]]
            along = stems.offset[child] / length
            axis = parents.centres(stems.parent[child], along)
            np.testing.assert_allclose(drawn.rings.centre[first[child]], axis, atol=1e-9)
            room = radii(trees, level - 1, stems.parent[child], np.clip(along, 0.0, 1.0))
            assert (drawn.rings.radius[first[child]] <= np.maximum(room, 1e-4)).all()
        widest = radii(trees, level, drawn.stations.stem(), np.clip(drawn.stations.along, 0.0, 1.0))
        assert (drawn.rings.radius <= np.maximum((1.0 + WIDENING) * widest, 1e-4) + 1e-12).all()
        parents = drawn


def test_clones_begin_inside_their_sources_in_their_direction():
    """The first ring is on the last segment of the source before the fork, and no wider than the source there."""
    trees = grow(
        row(levels=1, seg_splits_0=0.4, split_angle_0=35.0, curve_res_0=8, curve_0=60.0)[None], tree_keys(1, 3)
    )
    stems = trees.levels[0]
    part = plan(trees, 0)
    clone = np.flatnonzero(stems.is_clone)
    assert len(clone) > 1
    node = stems.node_offsets[stems.source[clone]] + stems.first[clone] - stems.first[stems.source[clone]]
    begin, _, _ = part.axes.positions(clone, part.axes.along[part.axes.offsets[clone]])
    back, before = stems.points[node] - begin, stems.frames[node - 1, :, 2]
    inside = node > stems.node_offsets[stems.source[clone]]
    assert inside.any()
    reach = CLONE_START * radii(trees, 0, clone, stems.along[stems.node_offsets[clone]])
    np.testing.assert_allclose(back[inside], (reach[:, None] * before)[inside], atol=1e-9)
    drawn = draw(
        trees, 0, part, StemDetail(np.ones(len(stems), bool), part.stations.counts, part.stations.counts), None
    )
    first = drawn.stations.offsets[clone]
    assert (drawn.rings.radius[first] < radii(trees, 0, stems.source[clone], stems.along[node])).all()


def test_a_batch_is_its_trees():
    batch = realize_trees(aspens(3), Look())
    assert batch.surface is not None
    for index in range(3):
        alone = grow(row(**{**ASPEN, "leaves": 2.0})[None], tree_keys(3)[index : index + 1])
        points, triangles = bark(realize_trees(alone, Look()))
        together, same = bark(batch, index)
        np.testing.assert_array_equal(points, together)
        key = np.lexsort(triangles.T)
        np.testing.assert_array_equal(triangles[key], same[np.lexsort(same.T)])
