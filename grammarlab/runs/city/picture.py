"""Pictures of a city, from above or from the street: its buildings, ground and trees in one scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from PIL import Image

from grammarlab.arrays import Flags, Floats
from grammarlab.city.plan import read_plan
from grammarlab.errors import UsageError
from grammarlab.export.tiles.simplified_models import PLAIN_TRIANGLES, simplified
from grammarlab.files import atomic_file
from grammarlab.rendering.camera import Camera, View, frame
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.runs.city.city_ground import LAND, GroundPieces, draped, ground_pieces, ground_scene, kinds_of_parcels
from grammarlab.runs.city.survey import Survey, surveyed
from grammarlab.runs.city.tree_places import grown_cards, tree_places
from grammarlab.runs.city.zone_rules import ZoneRules, make_buildings
from grammarlab.scene import Scene, TriangleBatch, triangles
from grammarlab.scene.joined import joined_materials, of_models

_KINDS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
"""Formats of pictures by the suffixes of their files."""
_FULL = 250.0
"""Metres up to which a picture from the street shows whole buildings; those farther away are walls and roofs."""
_MOST_FULL = 600
"""Largest number of whole buildings in a picture: of more, all are walls and roofs if they are seen from above."""
_AT_ONCE = 128
"""Buildings that are derived together."""
ABOVE = View(azimuth=25.0, elevation=34.0, field_of_view=30.0, margin=0.01)
"""A view of the whole city from the south, from above."""
_EYE = 1.7
"""Height of the eyes of a person in metres."""
_FIELD_OF_VIEW = 62.0
"""Vertical angle of a picture from the street in degrees."""


@dataclass(frozen=True, slots=True)
class StreetView:
    """Where a person stands in a city, and where they look."""

    east: float
    """Metres from the frame's origin."""
    north: float
    bearing: float
    """Degrees from north, clockwise."""
    height: float = _EYE
    """Metres above the ground."""
    tilt: float = 6.0
    """Degrees above the horizon."""


def draw_city(plan: Path, file: Path, *, view: View | StreetView = ABOVE, size: tuple[int, int] = (1600, 900)) -> None:
    """Draw the city of a plan.

    Args:
        plan: file of the plan.
        file: the picture (PNG or JPEG).
        view: where from.
        size: width and height in pixels.

    Raises:
        GrammarlabError: If the plan or one of its files cannot be used, or nothing is built.
    """
    kind = _KINDS.get(file.suffix.lower())
    if kind is None:
        raise UsageError(f"{file}: expected the name of a picture, {' or '.join(_KINDS)}.")
    read = read_plan(plan)
    zones = tuple(ZoneRules.of(zone) for zone in read.zones)
    street_trees = None if read.street_trees is None else ZoneRules.along_streets(read.street_trees)
    survey = surveyed(read, zones)
    batch = _batch(survey, zones, street_trees, view)
    options = RenderOptions(width=size[0], height=size[1], ground=False)
    aspect = size[0] / size[1]
    camera = frame(batch.vertices, aspect, view) if isinstance(view, View) else _camera(view, survey)
    picture = RaycastRenderer().render(batch, camera, options)
    with atomic_file(file) as part:
        Image.fromarray(picture).save(part, kind, quality=85)


def _camera(view: StreetView, survey: Survey) -> Camera:
    turn, tilt = np.radians(view.bearing), np.radians(view.tilt)
    ahead = np.array([np.sin(turn) * np.cos(tilt), np.sin(tilt), -np.cos(turn) * np.cos(tilt)])
    right = np.array([np.cos(turn), 0.0, np.sin(turn)])
    axes = np.stack([right, np.cross(right, ahead), -ahead])
    (ground,) = survey.heights(np.array([[view.east, view.north]]))
    eye = np.array([view.east, ground + view.height, -view.north])
    return Camera(eye, axes, float(np.tan(np.radians(_FIELD_OF_VIEW) / 2)), parallel=False)


def _batch(
    survey: Survey, zones: tuple[ZoneRules, ...], street_trees: ZoneRules | None, view: View | StreetView
) -> TriangleBatch:
    """All triangles of a city as one model, in metres of the frame."""
    parts = [_merged(ground_scene(_ground(survey, zones), np.zeros(3), survey.heights), np.zeros((1, 3)))]
    is_full = _is_full(survey, view)
    for number, rules in enumerate(zones):
        for full in (True, False):
            rows = np.flatnonzero((survey.sites.zone == number) & (is_full == full))
            for start in range(0, 0 if rules.is_park else len(rows), _AT_ONCE):
                sites = survey.sites.take(rows[start : start + _AT_ONCE])
                made = make_buildings(rules, sites)
                if made.scene is not None:
                    scene = made.scene if full else simplified(made.scene, (PLAIN_TRIANGLES,))[0]
                    parts.append(_merged(scene, sites.corner[made.row] + made.scene.origins))
    for trees in tree_places(survey, zones, street_trees):
        parts.append(_merged(of_models(grown_cards(trees.rules, survey.plan.seed), trees.grown), trees.place))
    return one_batch(parts)


def _is_full(survey: Survey, view: View | StreetView) -> Flags:
    """[S] whether a site is drawn with its whole building."""
    corner = survey.sites.corner
    if isinstance(view, View):
        return np.full(len(corner), len(corner) <= _MOST_FULL)
    return np.hypot(corner[:, 0] - view.east, corner[:, 2] + view.north) <= _FULL


def _ground(survey: Survey, zones: tuple[ZoneRules, ...]) -> GroundPieces:
    outlines = survey.parcels.outline
    everywhere = shapely.buffer(shapely.box(*shapely.total_bounds(outlines)), 100.0)
    kinds = kinds_of_parcels(survey, [rules.is_park for rules in zones])
    if survey.ground.terrain is None:
        return ground_pieces(outlines, kinds, everywhere)
    pieces = draped(ground_pieces(outlines, kinds, everywhere, has_land=True))
    middles = shapely.get_coordinates(shapely.centroid(pieces.outline))
    # A terrain may end near the city; parcels beyond it are at height 0.
    return pieces.where((pieces.kind != LAND) | ~np.isnan(survey.ground.terrain.heights(middles)))


def _merged(scene: Scene, places: Floats) -> TriangleBatch:
    """Triangles of models at places [num_models, 3], from one origin."""
    batch = triangles(scene)
    vertices = np.diff(batch.group_vertices)
    moved = batch.vertices + np.repeat(places[batch.group_model], vertices, axis=0).astype(np.float32)
    return replace(batch, vertices=moved)


def one_batch(parts: Sequence[TriangleBatch]) -> TriangleBatch:
    """The triangles of all parts as one model without texture maps, by material.

    Args:
        parts: one or more; pictures are only those of texture coordinates at vertices.
    """
    tables = [part.materials for part in parts]
    starts = np.cumsum([0, *map(len, tables)])
    material = np.concatenate([part.material_of_triangle() + start for part, start in zip(parts, starts, strict=False)])
    vertex_starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    corners = np.concatenate(
        [part.triangles + np.uint32(start) for part, start in zip(parts, vertex_starts, strict=False)]
    )
    order = np.argsort(material, kind="stable")
    counts = np.bincount(material, minlength=int(starts[-1]))
    used = np.flatnonzero(counts)
    corners = corners[order]
    # Each material has vertices of its own, as in every batch.
    vertex = corners.ravel().astype(np.int64)
    ends = np.concatenate([[0], np.cumsum(counts[used])])
    return TriangleBatch(
        num_models=1,
        materials=joined_materials(tables),
        vertices=np.concatenate([part.vertices for part in parts])[vertex],
        normals=np.concatenate([part.normals for part in parts])[vertex],
        triangles=np.arange(len(vertex), dtype=np.uint32).reshape(-1, 3),
        group_model=np.zeros(len(used), np.int32),
        group_material=used.astype(np.int32),
        group_vertices=3 * ends,
        group_triangles=ends,
        model_groups=np.array([0, len(used)], np.int64),
        texture_map=np.full(len(corners), -1, np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((1, 3)),
        coordinates=np.concatenate([_coordinates(part) for part in parts])[vertex],
    )


def _coordinates(batch: TriangleBatch) -> np.ndarray:
    """[V, 2] texture coordinates; zeros for pictures in asset folders, which pictures of models do not show."""
    return np.zeros((len(batch.vertices), 2), np.float32) if batch.coordinates is None else batch.coordinates
