"""A model made ready for shading: corner normals and linear materials."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.render.rays import Hits, Tracer
from grammarlab.scene import TriangleBatch
from grammarlab.scene.color import linear_from_srgb

Floats = NDArray[np.floating]

SEE_THROUGH = 0.99
"""Below this opacity a material casts no shadow and shows what is behind it."""


@dataclass(frozen=True, slots=True)
class Model:
    """T triangles, moved and scaled to fit a unit sphere about the origin."""

    corners: Floats
    """[T, 3, 3]."""
    corner_normals: Floats
    """[T, 3, 3]."""
    material: NDArray[np.int32]
    """[T] row of the material columns."""
    color: Floats
    """[K, 3] linear."""
    opacity: Floats
    """[K]."""
    metallic: Floats
    """[K]."""
    roughness: Floats
    """[K]."""
    emissive: Floats
    """[K, 3] linear."""
    origin: NDArray[np.float64]
    """[3] world position of the model's centre."""
    radius: float
    """World metres of the unit."""
    ground: float
    """Height of the ground in model units."""
    tracer: Tracer
    """All triangles."""
    blockers: Tracer
    """The opaque ones."""


@dataclass(frozen=True, slots=True)
class Surfaces:
    """What N rays have hit."""

    point: Floats
    """[N, 3]."""
    normal: Floats
    """[N, 3] unit shading normals on the side of the viewer."""
    flat: Floats
    """[N, 3] unit normals of the triangles on the side of the viewer."""
    material: NDArray[np.int32]
    """[N]."""


def prepare(batch: TriangleBatch) -> Model:
    """A batch of one model, ready for rays."""
    low, high = batch.vertices.min(axis=0).astype(np.float64), batch.vertices.max(axis=0).astype(np.float64)
    origin, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2 or 1.0
    vertices = ((batch.vertices - origin) / radius).astype(np.float32)
    material = batch.material_of_triangle()
    table = batch.materials
    opacity = np.clip(table.opacity, 0.0, 1.0).astype(np.float32)
    tracer = Tracer(vertices, batch.triangles)
    opaque = opacity[material] >= SEE_THROUGH
    return Model(
        vertices[batch.triangles],
        batch.normals[batch.triangles],
        material,
        linear_from_srgb(table.color).astype(np.float32),
        opacity,
        np.clip(table.metallic, 0.0, 1.0).astype(np.float32),
        np.clip(table.roughness, 0.0, 1.0).astype(np.float32),
        linear_from_srgb(table.emissive).astype(np.float32),
        origin,
        radius,
        float((low[1] - origin[1]) / radius),
        tracer,
        tracer if opaque.all() else Tracer(vertices, batch.triangles[opaque]),
    )


def surfaces(model: Model, origins: Floats, directions: Floats, hits: Hits) -> Surfaces:
    """The surfaces at hits that all met a triangle, for rays [N, 3]."""
    corners = model.corners[hits.triangle]
    flat = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    flat *= _side(flat, directions)
    normals = model.corner_normals[hits.triangle]
    u, v = hits.u[:, None], hits.v[:, None]
    normal = _unit((1 - u - v) * normals[:, 0] + u * normals[:, 1] + v * normals[:, 2])
    # A shading normal belongs to the same side as its triangle, seen from the back or the front.
    normal *= np.where(dot(normal, flat) < 0, np.float32(-1), np.float32(1))[:, None]
    return Surfaces(origins + hits.distance[:, None] * directions, normal, flat, model.material[hits.triangle])


def dot(a: Floats, b: Floats) -> Floats:
    """[N] inner products of the rows [N, 3]."""
    return np.einsum("ij,ij->i", a, b)


def _side(normals: Floats, directions: Floats) -> Floats:
    """[N, 1] -1 where a normal points away from the viewer."""
    return np.where(dot(normals, directions) > 0, np.float32(-1), np.float32(1))[:, None]


def _unit(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.sqrt(dot(vectors, vectors)), np.float32(1e-20))[:, None]
