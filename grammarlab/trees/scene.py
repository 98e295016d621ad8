"""Scenes of trees: closed stems with bark, leaves and blossoms as instances, at several levels of detail."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts
from grammarlab.asset_roots import AssetRoot
from grammarlab.derivation.materials import Materials
from grammarlab.errors import UsageError
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instances import PointSurface, Scene, stable_order
from grammarlab.trees.detail import DETAILS, Detail, LeafDetail, leaf_detail, stalk_lengths, stem_details
from grammarlab.trees.draws import counts
from grammarlab.trees.leaf_shapes import LeafMesh, blossom_mesh, leaf_mesh, with_stalk
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.species import Look
from grammarlab.trees.tree_materials import BARK, BLOSSOM, LEAF, tree_materials
from grammarlab.trees.tubes import joined_rings, tubes
from grammarlab.trees.wood import DrawnLevel, draw, plan


def realize_trees(
    skeleton: Skeleton, looks: Look | Sequence[Look], detail: Detail = "full", assets: AssetRoot | None = None
) -> Scene:
    """Meshes of trees with materials and texture coordinates; model i of the scene is tree i.

    Args:
        skeleton: n trees.
        looks: the look of all trees, or one for each of them.
        detail: ``full``; ``medium`` and ``low``: the same tree with 40 % and 15 % of the triangles; ``cards``: two
            crossed rectangles with pictures of the tree.
        assets: folder of the pictures of bark and leaves, which then travel with the scene and appear in pictures that
            renderers draw; None leaves them to the writers of files.

    Raises:
        UsageError: If the detail is unknown.
        AssetError: If a picture is outside the asset folder, or broken.

    >>> import grammarlab as gl
    >>> palm = gl.load("palm")
    >>> scene = gl.realize_trees(gl.sample(palm, 2, seed=1), palm.look, "low", palm.assets)
    >>> scene.num_models
    2
    """
    if detail not in DETAILS:
        raise UsageError(f"unknown detail {detail!r}; choose one of {', '.join(DETAILS)}")
    each = [looks] * skeleton.num_trees if isinstance(looks, Look) else list(looks)
    if len(each) != skeleton.num_trees:
        raise UsageError(f"expected one look, or {skeleton.num_trees}: one for each tree; found {len(each)}")
    if detail == "cards":
        from grammarlab.trees.cards import card_scene  # noqa: PLC0415 - most scenes need no renderer

        return card_scene(realize_trees(skeleton, each, "medium", assets))
    leaves, leaf_triangles, full_leaf_triangles = leaf_detail(skeleton, detail)
    plans = [plan(skeleton, level) for level in range(len(skeleton.levels))]
    stations = [part.stations for part in plans]
    details = stem_details(skeleton, stations, leaf_triangles, full_leaf_triangles, detail)
    levels: list[DrawnLevel] = []
    for level, part in enumerate(plans):
        levels.append(draw(skeleton, level, part, details[level], levels[-1] if levels else None))
    wood, surface = tubes(joined_rings([level.rings for level in levels]), skeleton.num_trees)
    materials = tree_materials(list(dict.fromkeys(each)), assets)
    return _scene(skeleton, each, materials, wood, surface, _placed_leaves(skeleton, leaves, levels))


@dataclass(frozen=True, slots=True, eq=False)
class _PlacedLeaves:
    """K leaves and blossoms as instances of M meshes."""

    tree: Ints
    mesh: Ints
    meshes: tuple[LeafMesh, ...]
    is_blossom: Flags
    position: Floats
    frame: Floats
    size: Floats


def _placed_leaves(skeleton: Skeleton, detail: LeafDetail, levels: Sequence[DrawnLevel]) -> _PlacedLeaves:
    """The leaves to draw, which begin on stems as they are drawn, if they are drawn."""
    leaves, rows = skeleton.leaves, detail.rows
    tree, is_blossom, frame = leaves.tree[rows], leaves.is_blossom[rows], leaves.frame[rows]
    position = leaves.position[rows]
    for number, level in enumerate(levels):
        stem = leaves.stem[rows]
        drawn = np.flatnonzero((leaves.level[rows] == number) & level.drawn[stem * (leaves.level[rows] == number)])
        length = skeleton.levels[number].length[stem[drawn]]
        position[drawn] = level.centres(stem[drawn], leaves.offset[rows[drawn]] / np.maximum(length, 1e-9))
    length = leaves.length[rows] * detail.growth
    width = np.where(is_blossom, length, leaves.width[rows] * detail.growth)
    stalk = np.where(is_blossom, 0.0, stalk_lengths(skeleton)[rows])
    if detail.detail > 0:
        # A larger leaf keeps its tip, so that a crown keeps its outline; its stalk is not drawn.
        tip = leaves.length[rows] * (1.0 + stalk)
        position += np.where(is_blossom, 0.0, tip - length)[:, None] * frame[:, :, 2]
        stalk = np.zeros(len(rows))
    shape = np.where(
        is_blossom,
        counts(skeleton.rows, tree, "blossom_shape"),
        counts(skeleton.rows, tree, "leaf_shape"),
    )
    kinds, mesh = _distinct(np.stack([is_blossom.astype(float), shape, stalk], axis=1))
    meshes = tuple(
        blossom_mesh(int(number), detail.detail)
        if blooms
        else with_stalk(leaf_mesh(int(number), detail.detail), length_of_stalk)
        for blooms, number, length_of_stalk in kinds.tolist()
    )
    return _PlacedLeaves(
        tree=tree,
        mesh=mesh,
        meshes=meshes,
        is_blossom=is_blossom,
        position=position,
        frame=frame,
        size=np.stack([width, width, length], axis=1),
    )


def _distinct(rows: Floats) -> tuple[Floats, Ints]:
    """Different rows [M, C] of rows [K, C], and the index [K] of each among them."""
    if len(rows) == 0:
        return rows, np.zeros(0, np.int64)
    different, index = np.unique(rows, axis=0, return_inverse=True)
    return different, index.ravel()


def _scene(
    skeleton: Skeleton,
    looks: Sequence[Look],
    materials: Materials,
    wood: Meshes,
    surface: PointSurface,
    leaves: _PlacedLeaves,
) -> Scene:
    num = skeleton.num_trees
    meshes, points = _joined(wood, surface, leaves.meshes)
    number = {look: index for index, look in enumerate(dict.fromkeys(looks))}
    look = np.array([number[part] for part in looks], np.int64)
    kind = np.where(leaves.is_blossom, BLOSSOM, LEAF)
    model = np.concatenate([np.arange(num), leaves.tree])
    material = 3 * look[model] + np.concatenate([np.full(num, BARK), kind])
    order = stable_order(model, material)
    identity = np.eye(3)
    return Scene(
        num_models=num,
        meshes=meshes,
        materials=materials,
        model=model[order].astype(np.int32),
        mesh=np.concatenate([np.arange(num), num + leaves.mesh])[order].astype(np.int32),
        material=material[order].astype(np.int32),
        position=np.concatenate([np.zeros((num, 3)), leaves.position])[order],
        size=np.concatenate([np.ones((num, 3)), leaves.size])[order],
        frame=np.concatenate([np.zeros(num, np.int64), 1 + np.arange(len(leaves.tree))])[order].astype(np.int32),
        frames=np.concatenate([identity[None], leaves.frame]),
        texture_map=np.full(len(order), -1, np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((num, 3)),
        surface=points,
    )


def _joined(wood: Meshes, surface: PointSurface, leaves: Sequence[LeafMesh]) -> tuple[Meshes, PointSurface]:
    """Meshes of wood, then those of leaves."""
    if not leaves:
        return wood, surface
    triangles = np.concatenate([leaf.triangles for leaf in leaves])
    parts = Meshes(
        points=np.concatenate([leaf.points for leaf in leaves]),
        corners=triangles.ravel(),
        face_offsets=3 * np.arange(len(triangles) + 1),
        mesh_faces=offsets_from_counts(np.array([len(leaf.triangles) for leaf in leaves])),
        mesh_points=offsets_from_counts(np.array([len(leaf.points) for leaf in leaves])),
        tags=np.zeros(len(triangles), np.int8),
    )
    normals = np.concatenate([surface.normals, *(leaf.normals for leaf in leaves)])
    coordinates = np.concatenate([surface.coordinates, *(leaf.coordinates for leaf in leaves)])
    return Meshes.concatenate([wood, parts]), PointSurface(normals, coordinates)
