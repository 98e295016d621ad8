"""Shading: light from a surface towards the eye by sun, sky, and their mirror images."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.rendering.light.look import Look, ambient, mirrored_surroundings, mixed
from grammarlab.rendering.light.rays import Tracer
from grammarlab.rendering.light.surfaces import ShadedModel, Surfaces, dot

GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))
"""Points in steps of this angle along a widening spiral are spread evenly."""
LIFT = np.float32(2e-4)
"""Offset of rays above a surface, in model units, so that they do not hit it."""
OPENNESS_REACH = 0.45
"""Largest distance of ambient occlusion, in model units."""
DIELECTRIC = np.float32(0.04)
"""Reflectance of a non-metal at normal incidence."""
MOST_GLARE = np.float32(1.2)
"""Largest brightness of the mirrored sun, in suns, so that flat steel keeps some of its colour."""
THROUGH = np.float32(0.6)
"""Light that passes through a leaf, by the light that it reflects: about as for most broad leaves in green light."""
POLISHED = np.float32(0.26)
"""Reflectance of a very smooth non-metal at normal incidence, with a larger value for double panes of glass."""


def sun_visibility(
    blockers: Tracer, points: AnyFloats, normals: AnyFloats, sun: AnyFloats, look: Look, spot: AnyFloats
) -> AnyFloats:
    """[N] 1 if the sun is visible from a point, otherwise 0.

    Args:
        blockers: triangles that cast shadows.
        points: [N, 3].
        normals: [N, 3] unit vectors.
        sun: [3] direction of the middle of the sun.
        look: the light.
        spot: [N] number in 0..1 that selects a point of the sun's disc; equal steps cover it evenly.
    """
    lit = np.flatnonzero(normals @ sun > 0)
    visible = np.zeros(len(points), np.float32)
    spot = spot[lit]
    angle = spot * np.float32(36.0 * GOLDEN_ANGLE)
    distance = np.float32(look.sun_softness) * np.sqrt(spot)
    directions = _directions_near(sun, distance * np.cos(angle), distance * np.sin(angle))
    start = points.take(lit, axis=0) + LIFT * normals.take(lit, axis=0)
    visible[lit] = ~blockers.is_blocked(start, directions)
    return visible


def sun_spread(sun: AnyFloats, look: Look) -> AnyFloats:
    """[4, 3] directions whose convex hull contains the sun's disc.

    Args:
        sun: [3] direction of the middle of the sun.
        look: the light, with the size of the sun.
    """
    side = np.float32(look.sun_softness)
    return _directions_near(
        sun, side * np.array([-1, -1, 1, 1], np.float32), side * np.array([-1, 1, -1, 1], np.float32)
    )


def openness(
    blockers: Tracer, points: AnyFloats, normals: AnyFloats, sample: NDArray[np.integer], num_rays: int
) -> AnyFloats:
    """[N] share of the hemisphere above a surface that is free nearby, weighted by cosine.

    Each sample sends `num_rays` rays, its own part of a pattern of which 16 samples make up the whole.
    """
    tangent, other = (axis.T.copy() for axis in _frames(normals))
    up = normals.T.copy()
    along, across, height = _hemisphere(16 * num_rays).T.copy()
    free = np.zeros(len(points), np.float32)
    start = points + LIFT * normals
    for ray in range(num_rays):
        index = ray * 16 + (sample * 7) % 16
        directions = along[index] * tangent + across[index] * other + height[index] * up
        free += ~blockers.is_blocked(start, directions.T, OPENNESS_REACH)
    return free / np.float32(num_rays)


def _hemisphere(num_directions: int) -> AnyFloats:
    """[K, 3] unit vectors about +z, spread evenly when weighted by cosine."""
    index = np.arange(num_directions, dtype=np.float32)
    angle = index * np.float32(GOLDEN_ANGLE)
    radius = np.sqrt((index + np.float32(0.5)) / np.float32(num_directions))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - radius * radius)], axis=1)


@dataclass(frozen=True, slots=True)
class Exposure:
    """Light at N surface points."""

    sun: AnyFloats
    """[N] 1 in the sun, 0 in shadow."""
    free: AnyFloats
    """[N] share of the hemisphere that is free nearby, 0..1."""


def shade(
    model: ShadedModel, visible: Surfaces, exposure: Exposure, directions: AnyFloats, sun: AnyFloats, look: Look
) -> tuple[AnyFloats, AnyFloats]:
    """Light [N, 3] from surfaces along rays to the eye, and their transparency [N].

    Args:
        model: materials, and surfaces for mirror images.
        visible: the surfaces.
        exposure: the light at the surfaces.
        directions: [N, 3] unit directions of the rays.
        sun: [3] direction towards the sun.
        look: the light.
    """
    shadow, free = exposure.sun, exposure.free
    color, metallic = model.color.take(visible.material, axis=0), model.metallic[visible.material][:, None]
    if visible.tint is not None:
        color = color * visible.tint
    facing = np.clip(visible.normal @ sun, 0.0, None) * shadow
    skylight = ambient(look, visible.normal)
    closed = look.bounce * np.array(look.ground, np.float32)
    is_thin = np.zeros(len(shadow), bool)
    if model.thin is not None:
        is_thin = model.thin[visible.material]
        facing += np.where(is_thin, THROUGH * np.clip(-(visible.normal @ sun), 0.0, None) * shadow, np.float32(0.0))
        both = skylight + THROUGH * ambient(look, -visible.normal)
        skylight = np.where(is_thin[:, None], both, skylight)
    received = free[:, None] * skylight + mixed((facing, 1.0 - free), (look.sun, closed))
    if model.thin is not None:
        # What is near a leaf are other leaves, which pass light on, the more the brighter they are.
        passed = is_thin[:, None] * (1.0 - free)[:, None] * np.maximum(THROUGH**2, color)
        received += passed * skylight
    roughness, opacity = model.roughness[visible.material], model.opacity[visible.material]
    mirrored = _mirrored(visible, directions, model, sun, look, exposure, skylight, roughness)
    facing_eye = np.clip(-dot(visible.normal, directions), 0.0, 1.0)
    polished = DIELECTRIC + (POLISHED - DIELECTRIC) * (1.0 - roughness[:, None]) ** 4
    at_normal = polished + (color - polished) * metallic
    grazing = (1.0 - roughness) * (1.0 - facing_eye) ** 5
    fresnel = at_normal + (1.0 - at_normal) * grazing[:, None]
    diffuse = color * received * (1.0 - metallic) * (1.0 - fresnel)
    light = opacity[:, None] * diffuse + fresnel * mirrored + 2.0 * model.emissive.take(visible.material, axis=0)
    through = (1.0 - opacity) * (1.0 - fresnel.mean(axis=1))
    return light, through


def _mirrored(
    visible: Surfaces,
    directions: AnyFloats,
    model: ShadedModel,
    sun: AnyFloats,
    look: Look,
    exposure: Exposure,
    skylight: AnyFloats,
    roughness: AnyFloats,
) -> AnyFloats:
    """[N, 3] reflections: sky, sun, and in smooth surfaces the model itself."""
    along = directions - 2.0 * dot(directions, visible.normal)[:, None] * visible.normal
    image = mirrored_surroundings(look, along)
    blur = roughness[:, None]
    image = image + blur * (skylight - image)
    image *= (exposure.free + (1.0 - exposure.free) * look.bounce)[:, None]
    smooth = np.flatnonzero(roughness < 0.35)
    if len(smooth):
        start = visible.point.take(smooth, axis=0) + LIFT * visible.flat.take(smooth, axis=0)
        hits = model.tracer.first_hit(start, along.take(smooth, axis=0))
        is_hit = hits.triangle >= 0
        other = model.material[hits.triangle[is_hit]]
        image[smooth[is_hit]] = model.color[other] * (0.55 * np.array(look.sky, np.float32)) + model.emissive[other]
        image[smooth[~is_hit]] = mirrored_surroundings(look, along[smooth[~is_hit]])
    # GGX distribution about the mirror direction, with a limited peak so that single samples do not sparkle.
    alpha = np.clip(roughness * roughness, 0.02, 1.0)
    closeness = np.clip(along @ sun, 0.0, 1.0)
    half_cosine = (1.0 + closeness) * 0.5
    spread = half_cosine * (alpha * alpha - 1.0) + 1.0
    highlight = np.minimum(alpha * alpha / (4.0 * spread * spread * alpha), MOST_GLARE) * exposure.sun
    return image + mixed((highlight,), (look.sun,))


def _directions_near(direction: AnyFloats, along: AnyFloats, across: AnyFloats) -> AnyFloats:
    """[N, 3] directions beside one [3], by distances [N] along two axes at right angles to it."""
    (tangent,), (other,) = _frames(direction[None])
    return mixed((np.ones_like(along), along, across), (direction, tangent, other))


def _frames(normals: AnyFloats) -> tuple[AnyFloats, AnyFloats]:
    """Tangents [N, 3] that complete unit normals to frames (Duff et al. 2017, Building an Orthonormal Basis)."""
    x, y, z = normals.T
    sign = np.where(z < 0, np.float32(-1), np.float32(1))
    a = -1.0 / (sign + z)
    b = x * y * a
    return (
        np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1),
        np.stack([b, sign + y * y * a, -y], axis=1),
    )
