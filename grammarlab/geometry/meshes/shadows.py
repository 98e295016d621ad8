"""Areas that meshes cover seen from above, and faces without holes: CGA's ``footprint`` and ``deleteHoles``."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from shapely import Polygon, get_parts, make_valid, set_precision, union_all
from shapely.geometry.polygon import orient

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.geometry.meshes.edges import edges, in_rings
from grammarlab.geometry.meshes.flat_patches import faces_within
from grammarlab.geometry.meshes.mesh import Meshes, Soup

_GRID = 1e-9
"""Distance of points that are one, as a share of the size."""
_UP = np.array([0.0, 1.0, 0.0])


def shadow(mesh: Meshes) -> Meshes:
    """The area that a mesh covers, at y = 0 and seen from above.

    Args:
        mesh: a single mesh.
    """
    if mesh.num_faces == 0:
        return mesh
    size = float(np.ptp(mesh.points, axis=0).max())
    corners = mesh.points[mesh.corner_points()][:, [0, 2]]
    shapes = [Polygon(corners[begin:end]) for begin, end in pairwise(mesh.face_offsets.tolist()) if end - begin > 2]
    area = union_all([set_precision(make_valid(shape), _GRID * size) for shape in shapes])
    points: list[Floats] = []
    faces: list[list[int]] = []
    count = 0
    for part in get_parts(area).tolist():
        if not isinstance(part, Polygon) or part.is_empty:
            continue
        # Counter-clockwise seen from above, where z runs down.
        outline = orient(part, sign=-1.0)
        rings = [np.asarray(ring.coords)[:-1] for ring in (outline.exterior, *outline.interiors)]
        ends = np.cumsum([len(ring) for ring in rings]).tolist()
        flat = np.concatenate(rings)
        own = np.column_stack((flat[:, 0], np.zeros(len(flat)), flat[:, 1]))
        loops = [list(range(end - len(ring), end)) for ring, end in zip(rings, ends, strict=True)]
        faces += [(face + count).tolist() for face in faces_within(own, loops, _UP)]
        points.append(own)
        count += len(own)
    return Meshes.single(np.concatenate(points), faces) if points else Meshes.united([])


def without_holes(meshes: Meshes) -> Meshes:
    """Meshes whose faces have no holes."""
    table = edges(meshes)
    if bool((table.edge_of_corner >= 0).all()):
        return meshes
    corners, of_hole = in_rings(meshes, table.edge_of_corner)
    faces = Soup.of_faces(meshes, np.arange(meshes.num_faces))
    kept = corners[~of_hole]
    counts = np.bincount(meshes.face_of_corner()[kept], minlength=meshes.num_faces)
    outlines = Soup(
        rows=faces.rows[kept],
        offsets=offsets_from_counts(counts),
        mesh=faces.mesh,
        rank=faces.rank,
        tags=faces.tags,
        data=faces.data and faces.data.of_corners(kept),
    )
    return outlines.meshes(meshes.points, meshes.mesh_of_point(), len(meshes))
