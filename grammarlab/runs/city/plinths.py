"""Plinths: what is between a building, which stands level, and ground that falls away below it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import numpy as np
import shapely

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts, row_of_value
from grammarlab.city.sites import Sites
from grammarlab.derivation.lots import Footprints
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.export.surface_labels import SurfaceLabels
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Meshes, Soup
from grammarlab.geometry.meshes.vectors import apply
from grammarlab.runs.city.outline_face import outline_face
from grammarlab.scene.instance_bounds import instance_bounds
from grammarlab.scene.instances import Scene, chosen
from grammarlab.scene.joined import united

_COLOR = (0.56, 0.54, 0.51)
"""sRGB of the stone of plinths."""
_LEVEL = 0.02
"""Metres from the bottom of a building within which a flat shape is its floor or its garden."""
_SMALLEST = 0.01
"""Smallest area in square metres of a part of the top of a plinth."""


def with_plinths(scene: Scene, labels: SurfaceLabels, sites: Sites) -> tuple[Scene, SurfaceLabels]:
    """Buildings with closed prisms of stone below their footprints, down to the lowest ground there.

    Where a building has a floor or a garden that looks up, the prism has no top.

    Args:
        scene: S models, from the corners of the sites.
        labels: kinds of its instances.
        sites: S sites.

    Returns:
        The scene and its labels; the same ones where no site has a plinth.
    """
    rows = np.flatnonzero(sites.plinth > 0.0)
    if not len(rows):
        return scene, labels
    footprints = sites.footprints.take(rows)
    floors = _floors(scene)
    has_floor = np.array([row in floors for row in rows.tolist()])
    prisms = _without_tops(_prisms(footprints, sites.plinth[rows]), has_floor)
    tops, model = _tops(footprints, rows, floors)
    more = _scene_of(Meshes.concatenate([prisms, tops]), np.concatenate([rows, model]), scene)
    whole, order = united(scene, more)
    return whole, SurfaceLabels.concatenate([labels, SurfaceLabels.none(len(more))]).take(order)


def _prisms(footprints: Footprints, depth: Floats) -> Meshes:
    """Prisms of depths [F] in metres, more than a little, below footprints [F]."""
    counts = np.diff(footprints.offsets)
    # Both ends of the bridge to a court are one point, so that it gets no wall.
    keys = np.column_stack([row_of_value(counts).astype(np.float64), footprints.points])
    different, corner = np.unique(keys, axis=0, return_inverse=True)
    mesh_points = offsets_from_counts(np.bincount(different[:, 0].astype(np.int64), minlength=len(footprints)))
    return extrude(
        Meshes(
            points=different[:, 1:],
            corners=corner.ravel() - np.repeat(mesh_points[:-1], counts),
            face_offsets=footprints.offsets,
            mesh_faces=np.arange(len(footprints) + 1),
            mesh_points=mesh_points,
            tags=np.zeros(len(footprints), np.int8),
        ),
        -depth,
    )


def _without_tops(prisms: Meshes, is_open: Flags) -> Meshes:
    """The prisms; those that are open have no face at the height of their building."""
    lowest = np.minimum.reduceat(prisms.points[prisms.corner_points(), 1], prisms.face_offsets[:-1])
    stays = ~(is_open[prisms.mesh_of_face()] & (lowest > -_SMALLEST))
    faces = Soup.of_faces(prisms, np.flatnonzero(stays))
    return faces.meshes(prisms.points, prisms.mesh_of_point(), len(prisms))


def _floors(scene: Scene) -> Mapping[int, list[shapely.Polygon]]:
    """Flat shapes at the bottom of models that look up, by model: east and north of its corner."""
    low, high = instance_bounds(scene)
    bottom = -scene.origins[scene.model, 1]
    is_flat = (low[:, 1] > bottom - _LEVEL) & (high[:, 1] < bottom + _LEVEL)
    flat = chosen(scene, np.flatnonzero(is_flat))
    meshes = flat.meshes.take(flat.mesh)
    instance = meshes.mesh_of_point()
    placed = apply(flat.frames[flat.frame[instance]], flat.size[instance] * meshes.points)
    placed += flat.position[instance] + flat.origins[flat.model[instance]]
    meshes = meshes.with_points(placed)
    model = flat.model[meshes.mesh_of_face()].tolist()
    floors: dict[int, list[shapely.Polygon]] = defaultdict(list)
    for face in np.flatnonzero(area_vectors(meshes)[:, 1] > _SMALLEST).tolist():
        corners = meshes.corner_points()[slice(*meshes.face_offsets[face : face + 2])]
        floors[model[face]].append(shapely.Polygon(_on_the_map(placed[corners])))
    return floors


def _tops(footprints: Footprints, rows: Ints, floors: Mapping[int, list[shapely.Polygon]]) -> tuple[Meshes, Ints]:
    """What the floors of models leave of their footprints: meshes of one face, and the model of each.

    Args:
        footprints: F footprints.
        rows: [F] their models.
        floors: floors by model; footprints of other models are left out.
    """
    faces, model = [np.zeros((0, 2))], list[int]()
    for number, row in enumerate(rows.tolist()):
        if row in floors:
            outline = shapely.Polygon(_on_the_map(footprints.points[slice(*footprints.offsets[number : number + 2])]))
            rest = shapely.difference(outline.buffer(0), shapely.union_all(shapely.buffer(floors[row], 0)))
            parts = [part for part in shapely.get_parts(rest) if isinstance(part, shapely.Polygon)]
            large = [outline_face(part) for part in parts if part.area > _SMALLEST]
            faces += large
            model += [row] * len(large)
    east, north = np.concatenate(faces).T
    points = np.column_stack([east, np.zeros(len(east)), -north])
    counts = np.array([len(face) for face in faces[1:]], np.int64)
    return Meshes.from_polygons(points, counts), np.array(model, np.int64)


def _on_the_map(points: Floats) -> Floats:
    """[n, 2] east and north of points [n, 3]."""
    return points[:, [0, 2]] * (1.0, -1.0)


def _scene_of(meshes: Meshes, model: Ints, scene: Scene) -> Scene:
    """Stone meshes [n] from the corners of models [n] of a scene."""
    num = len(meshes)
    channels = np.array([list(CHANNELS.values())])
    channels[0, :3] = _COLOR
    return Scene(
        num_models=scene.num_models,
        meshes=meshes,
        materials=Materials(channels, ("",)),
        model=model.astype(np.int32),
        mesh=np.arange(num, dtype=np.int32),
        material=np.zeros(num, np.int32),
        position=-scene.origins[model],
        size=np.ones((num, 3)),
        frame=np.zeros(num, np.int32),
        frames=np.eye(3)[None],
        texture_map=np.full(num, -1, np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=scene.origins,
    )
