"""Scene: placed meshes with materials, for one model or a whole batch, and checks of its coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, narrow
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.lots import NEAR, origins_of
from grammarlab.derivation.materials import Materials
from grammarlab.errors import DerivationError, check_type
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.shape_labels import ShapeLabels, labels_of

_FARTHEST = 1e9
"""Largest coordinate in metres, far below the overflow of 32-bit arithmetic."""


@dataclass(frozen=True, slots=True)
class PointSurface:
    """Normals and texture coordinates at the P points of meshes; two points at one position are a seam."""

    normals: Floats
    """[P, 3] unit vectors."""
    coordinates: Floats
    """[P, 2] u and v of the picture, v upwards; 1 is one repeat. At most about a thousand repeats fit 32 bits well."""


@dataclass(frozen=True, slots=True)
class Scene:
    """I instances of meshes over `num_models` models, world y up, metres, right-handed.

    Instance i's points are ``position + rotation @ (size * point)`` from the origin of its model, its rotation
    ``frames[frame[i]]``.

    >>> import grammarlab as gl
    >>> scene = gl.realize(gl.derive(gl.Grammar.parse("Lot --> extrude(3) Tower"), 4, seed=1))
    >>> scene.num_models
    4
    """

    num_models: int
    meshes: Meshes
    materials: Materials
    model: NDArray[np.int32]
    """[I] model of each instance, ascending."""
    mesh: NDArray[np.int32]
    """[I] index into `meshes`."""
    material: NDArray[np.int32]
    """[I] index into `materials`."""
    position: Floats
    """[I, 3] metres from the origin of the model."""
    size: Floats
    """[I, 3] metres, >= 0."""
    frame: NDArray[np.int32]
    """[I] index into `frames`."""
    frames: Floats
    """[K, 3, 3] proper rotations."""
    texture_map: NDArray[np.int32]
    """[I] index into `texture_maps`, -1 for instances without texture coordinates."""
    texture_maps: Floats
    """[K, 2, 4] u and v of a point from the origin of its model are rows times (x, y, z, 1), v upwards."""
    origins: Floats
    """[num_models, 3] origin of each model's positions, in world metres; see `grammarlab.derivation.lots`."""
    surface: PointSurface | None = None
    """Surface at the points of `meshes`, which then consist of triangles, in place of `texture_maps`; by default,
    normals follow from the faces."""
    labels: ShapeLabels | None = None
    """Symbols of the instances and values of the models, for the names in files; None if they have none."""

    def __len__(self) -> int:
        return len(self.model)


def realize(forest: Forest) -> Scene:
    """The scene of a forest: its leaves, ordered by model, then by material, then by symbol.

    Materials are ordered by their appearance, since their order in a forest depends on the other models in it.

    >>> import grammarlab as gl
    >>> len(gl.realize(gl.derive(gl.Grammar.parse("Lot --> extrude(3) split(y) { ~1 : A | ~1 : B }"), 4, seed=1)))
    8
    """
    check_type("forest", forest, Forest, "gl.derive(grammar, 4, seed=1)")
    leaves = forest.leaves
    materials, material_of_old = _sorted(forest.materials)
    order, material = _order(forest, material_of_old), material_of_old[leaves.material]
    scene = Scene(
        num_models=forest.num_models,
        meshes=forest.meshes,
        materials=materials,
        model=forest.nodes.model[leaves.node[order]],
        mesh=leaves.mesh[order],
        material=material[order],
        position=leaves.position.take(order, axis=0),
        size=leaves.size.take(order, axis=0),
        frame=leaves.frame[order],
        frames=forest.frames + 0.0,
        texture_map=leaves.texture_map[order],
        texture_maps=forest.texture_maps,
        origins=forest.origins,
        labels=labels_of(forest, order),
    )
    return _brought_near(scene)


def leaf_order(forest: Forest) -> NDArray[np.intp]:
    """The rows of the leaves of a forest in the order of the instances of its scene."""
    return _order(forest, _sorted(forest.materials)[1])


def stable_order(first: NDArray[np.integer], second: NDArray[np.integer]) -> NDArray[np.intp]:
    """The rows [N] ordered by one column of numbers >= 0, then by another; equal rows keep their order.

    >>> stable_order(np.array([1, 0, 1, 0]), np.array([5, 7, 4, 7])).tolist()
    [1, 3, 2, 0]
    """
    num_seconds = int(second.max(initial=0)) + 1
    if (int(first.max(initial=0)) + 1) * num_seconds <= 2**16:
        return np.argsort(narrow(first.astype(np.int32) * num_seconds + second), kind="stable")
    order = np.argsort(narrow(second), kind="stable")
    return order[np.argsort(narrow(first)[order], kind="stable")]


def scene_of_model(scene: Scene, model: int) -> Scene:
    """One model of a batch, as a separate scene with the same tables."""
    alone = chosen(scene, slice(*np.searchsorted(scene.model, [model, model + 1])))
    return replace(
        alone,
        num_models=1,
        model=np.zeros(len(alone), np.int32),
        origins=scene.origins[model : model + 1],
        labels=None if alone.labels is None else alone.labels.of_models(slice(model, model + 1)),
    )


def chosen(scene: Scene, rows: slice | NDArray[np.integer] | NDArray[np.bool_]) -> Scene:
    """Selected instances in their order, with the same number of models and the same tables."""
    return Scene(
        num_models=scene.num_models,
        meshes=scene.meshes,
        materials=scene.materials,
        model=scene.model[rows],
        mesh=scene.mesh[rows],
        material=scene.material[rows],
        position=scene.position[rows],
        size=scene.size[rows],
        frame=scene.frame[rows],
        frames=scene.frames,
        texture_map=scene.texture_map[rows],
        texture_maps=scene.texture_maps,
        origins=scene.origins,
        surface=scene.surface,
        labels=None if scene.labels is None else scene.labels.take(rows),
    )


def moved(scene: Scene, moves: Floats) -> Scene:
    """The same models in the world, with other origins.

    Args:
        scene: the scene.
        moves: [num_models, 3] new origin of each model from its old one, in metres.
    """
    move = moves[scene.model]
    mapped = np.flatnonzero(scene.texture_map >= 0)
    maps = scene.texture_maps[scene.texture_map[mapped]]
    maps[:, :, 3] += np.einsum("nai,ni->na", maps[:, :, :3], move[mapped])
    texture_map = scene.texture_map.copy()
    texture_map[mapped] = np.arange(len(mapped))
    return replace(
        scene,
        position=scene.position - move,
        texture_map=texture_map,
        texture_maps=maps,
        origins=scene.origins + moves,
    )


def require_finite(scene: Scene) -> None:
    """Refuse a scene with coordinates that files and pictures cannot represent.

    Raises:
        DerivationError: If a coordinate is NaN, infinite or beyond `_FARTHEST`; it names the first such model.
    """
    _require_within(scene, "position", scene.position)
    _require_within(scene, "size", scene.size)
    if not _within(scene.frames):
        _require_within(scene, "rotation", scene.frames[scene.frame])
    if not np.isfinite(scene.materials.channels).all():
        raise DerivationError(
            "a material has a colour or another number that is not finite", hint="check for divisions by zero"
        )
    points = scene.meshes.points
    if not _within(points):
        raise DerivationError(
            "a mesh has a point that is not a finite number of metres",
            hint="check for divisions by zero and for broken assets",
        )
    if scene.surface is not None and not (_within(scene.surface.normals) and _within(scene.surface.coordinates)):
        raise DerivationError("a mesh has a normal or a texture coordinate that is not a finite number")
    if len(scene) and scene.size.min() < 0:
        model = int(scene.model[np.flatnonzero((scene.size < 0).any(axis=1))[0]])
        raise DerivationError(
            f"model {model} has a shape of negative size; a negative size would mirror its geometry",
            hint="keep sizes at or above zero, for example with max(0, size)",
        )


def require_proper(scene: Scene) -> None:
    """Refuse mirrored or sheared orientations, which would be inside out in files.

    Raises:
        DerivationError: If an orientation is not a proper rotation; it names the first such model.
    """
    axes = scene.frames
    handed = np.einsum("ij,ij->i", np.cross(axes[:, :, 0], axes[:, :, 1]), axes[:, :, 2])
    skewed = np.abs(np.einsum("nij,nik->njk", axes, axes) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    wrong = np.flatnonzero(((handed < 0.5) | (skewed > 1e-6))[scene.frame])
    if len(wrong):
        raise DerivationError(
            f"model {int(scene.model[wrong[0]])} has a shape whose axes are not a right-handed rotation",
            hint="mirror the geometry inside its scope, not the scope",
        )


def _sorted(materials: Materials) -> tuple[Materials, NDArray[np.int32]]:
    """Materials [K] ordered by their channels, then by their textures, and the new place of each [K]."""
    channels = materials.channels + 0.0
    rows = list(zip(channels.tolist(), materials.textures, strict=True))
    order = np.array(sorted(range(len(rows)), key=rows.__getitem__), dtype=np.int32)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order), dtype=np.int32)
    textures = tuple(materials.textures[row] for row in order.tolist())
    return Materials(channels[order], textures, cut_out=materials.cut_out), rank


def _order(forest: Forest, material_of_old: NDArray[np.integer]) -> NDArray[np.intp]:
    nodes, leaves = forest.nodes, forest.leaves
    kind = material_of_old[leaves.material].astype(np.int64) * len(forest.symbols) + nodes.symbol[leaves.node]
    return stable_order(nodes.model[leaves.node], kind)


def _brought_near(scene: Scene) -> Scene:
    """The same scene with new origins for models that rules have moved far from their origins."""
    if len(scene) == 0 or np.abs(scene.position).max() <= NEAR:
        return scene
    ends = np.searchsorted(scene.model, np.arange(scene.num_models + 1))
    starts, filled = ends[:-1][np.diff(ends) > 0], np.diff(ends) > 0
    moves = np.zeros((scene.num_models, 3))
    moves[filled] = origins_of(
        np.minimum.reduceat(scene.position, starts, axis=0), np.maximum.reduceat(scene.position, starts, axis=0)
    )
    return moved(scene, moves)


def _require_within(scene: Scene, name: str, values: np.ndarray) -> None:
    if _within(values):
        return
    wrong = np.flatnonzero(~(np.abs(values).reshape(len(values), -1).max(axis=1) <= _FARTHEST))[0]
    raise DerivationError(
        f"model {int(scene.model[wrong])} has a shape whose {name} is {values[wrong].tolist()}; "
        f"expected finite numbers within {_FARTHEST:g} m",
        hint="check for divisions by zero and for sizes that grow without bound",
    )


def _within(values: np.ndarray) -> bool:
    """Whether all are finite and within `_FARTHEST`; comparisons with NaN are false."""
    return values.size == 0 or bool(values.min() >= -_FARTHEST and values.max() <= _FARTHEST)
