"""Surfaces of a model for shading: corner normals and linear materials."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.errors import UsageError
from grammarlab.rendering.light.rays import Hits, Tracer, welded
from grammarlab.rendering.light.textures import Skin, skin_of
from grammarlab.scene import TriangleBatch

SEE_THROUGH = 0.99
"""Opacity below which a material casts no shadow and is transparent."""


@dataclass(frozen=True, slots=True)
class ShadedModel:
    """T triangles, moved and scaled to fit a unit sphere about the origin."""

    vertices: AnyFloats
    """[V, 3]."""
    flat_normals: AnyFloats
    """[T, 3] unit normals of the triangles."""
    corner_normals: AnyFloats
    """[T, 3, 3]."""
    material: NDArray[np.int32]
    """[T] row of the material columns."""
    color: AnyFloats
    """[K, 3] linear."""
    opacity: AnyFloats
    """[K]."""
    metallic: AnyFloats
    """[K]."""
    roughness: AnyFloats
    """[K]."""
    emissive: AnyFloats
    """[K, 3] linear."""
    origin: NDArray[np.float64]
    """[3] world position of the model's centre."""
    radius: float
    """Length of the unit in world metres."""
    low: AnyFloats
    """[3] smallest coordinates in model units."""
    high: AnyFloats
    """[3] largest ones."""
    tracer: Tracer
    """All triangles for rays, or None without rays."""
    blockers: Tracer
    """The opaque triangles for rays."""
    skin: Skin | None
    """Pictures on the triangles; None without."""
    thin: NDArray[np.bool_] | None
    """[K] whether light passes through surfaces of a material to the other side; None if it does through none."""


@dataclass(frozen=True, slots=True)
class Surfaces:
    """Surfaces hit by N rays."""

    point: AnyFloats
    """[N, 3]."""
    normal: AnyFloats
    """[N, 3] unit shading normals on the side of the viewer."""
    flat: AnyFloats
    """[N, 3] unit normals of the triangles on the side of the viewer."""
    material: NDArray[np.int32]
    """[N]."""
    tint: AnyFloats | None = None
    """[N, 3] linear colours of pictures, by which those of the materials are multiplied; None without pictures."""


def prepare(batch: TriangleBatch, *, for_rays: bool = True, spacing: AnyFloats | float = 0.0) -> ShadedModel:
    """Surfaces from a batch of one model with at least one triangle, with or without rays.

    Args:
        batch: the model.
        for_rays: whether there will be rays.
        spacing: [T] metres between neighbouring samples on each triangle, which pictures on it need.

    Raises:
        UsageError: If a vertex is not finite.
    """
    if not np.isfinite(batch.vertices).all():
        raise UsageError("a model cannot be drawn: expected finite vertices, found some that are not.")
    low, high = batch.vertices.min(axis=0).astype(np.float64), batch.vertices.max(axis=0).astype(np.float64)
    origin, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2 or 1.0
    vertices = ((batch.vertices - origin) / radius).astype(np.float32)
    material = batch.material_of_triangle()
    table = batch.materials
    opacity = np.clip(table.opacity, 0.0, 1.0).astype(np.float32)
    triangles = batch.triangles if for_rays else batch.triangles[:0]
    points, point = welded(vertices)
    corners_of_rays = point.take(triangles)
    skin = skin_of(batch, spacing) if for_rays else None
    tracer = Tracer(points, corners_of_rays, skin)
    opaque = opacity[material] >= SEE_THROUGH
    corners = vertices.take(batch.triangles, axis=0)
    return ShadedModel(
        vertices=vertices,
        flat_normals=unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])),
        corner_normals=batch.normals.take(batch.triangles, axis=0),
        material=material,
        color=linear_from_srgb(table.color).astype(np.float32),
        opacity=opacity,
        metallic=np.clip(table.metallic, 0.0, 1.0).astype(np.float32),
        roughness=np.clip(table.roughness, 0.0, 1.0).astype(np.float32),
        emissive=linear_from_srgb(table.emissive).astype(np.float32),
        origin=origin,
        radius=radius,
        low=(low - origin) / radius,
        high=(high - origin) / radius,
        tracer=tracer,
        blockers=tracer
        if opaque.all() or not for_rays
        else Tracer(points, corners_of_rays[opaque], skin and skin.take(opaque)),
        skin=skin,
        thin=np.isin(np.arange(len(table)), list(table.thin)) if table.thin else None,
    )


def surfaces(model: ShadedModel, origins: AnyFloats, directions: AnyFloats, hits: Hits) -> Surfaces:
    """Surfaces at hits of rays [N, 3]; every ray has hit a triangle."""
    flat = model.flat_normals.take(hits.triangle, axis=0)
    flat *= side_of_viewer(flat, directions)
    normals = model.corner_normals.take(hits.triangle, axis=0)
    u, v = hits.u[:, None], hits.v[:, None]
    normal = unit((1 - u - v) * normals[:, 0] + u * normals[:, 1] + v * normals[:, 2])
    # A shading normal belongs to the same side as its triangle, seen from the back or the front.
    normal *= np.where(dot(normal, flat) < 0, np.float32(-1), np.float32(1))[:, None]
    point = origins + hits.distance[:, None] * directions
    tint = None if model.skin is None else model.skin.colors(hits)[:, :3]
    return Surfaces(point, normal, flat, model.material[hits.triangle], tint)


def sunward(model: ShadedModel, visible: Surfaces, sun: AnyFloats) -> AnyFloats:
    """[N, 3] unit normals of the sides of surfaces that the sun must see: those of the viewer, or either of leaves."""
    if model.thin is None:
        return visible.flat
    away = model.thin[visible.material] & (visible.flat @ sun < 0)
    return np.where(away[:, None], -visible.flat, visible.flat)


def dot(a: AnyFloats, b: AnyFloats) -> AnyFloats:
    """[...] inner products of vectors [..., 3], by a matrix product since that is three times faster than a sum."""
    products = a * b
    return (products.reshape(-1, 3) @ np.ones(3, products.dtype)).reshape(products.shape[:-1])


def side_of_viewer(normals: AnyFloats, directions: AnyFloats) -> AnyFloats:
    """[N, 1] -1 where a normal points away from the viewer."""
    return np.where(dot(normals, directions) > 0, np.float32(-1), np.float32(1))[:, None]


def unit(vectors: AnyFloats) -> AnyFloats:
    """[N, 3] the directions of vectors [N, 3]."""
    return vectors / np.maximum(np.sqrt(dot(vectors, vectors)), np.float32(1e-20))[:, None]
