"""How much light leaves a surface towards the eye: sun, sky, and their mirror images."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grammarlab.render.look import Look, ambient, surroundings
from grammarlab.render.rays import Tracer
from grammarlab.render.surfaces import Model, Surfaces, dot

Floats = NDArray[np.float32]

LIFT = np.float32(2e-4)
"""How far rays start above a surface, in model units, so that they do not hit it."""
OPENNESS_REACH = 0.45
"""How far away something dims the sky, in model units."""
DIELECTRIC = np.float32(0.04)
"""What a polished non-metal mirrors when looked at straight."""


def sun_visibility(
    blockers: Tracer, points: Floats, normals: Floats, sun: Floats, look: Look, sample: NDArray[np.integer]
) -> Floats:
    """[N] 1 where the sun is seen from a point, else 0; each sample looks at its own spot of the sun's disc."""
    lit = np.flatnonzero(normals @ sun > 0)
    visible = np.zeros(len(points), np.float32)
    angle = sample[lit] * math.pi * (3.0 - math.sqrt(5.0))
    distance = look.sun_softness * np.sqrt((sample[lit] % 16 + 0.5) / 16.0)
    one, other = _across(sun)
    directions = sun + (distance * np.cos(angle))[:, None] * one + (distance * np.sin(angle))[:, None] * other
    directions = directions.astype(np.float32)
    visible[lit] = ~blockers.is_blocked(points[lit] + LIFT * normals[lit], directions)
    return visible


def openness(
    blockers: Tracer, points: Floats, normals: Floats, sample: NDArray[np.integer], num_rays: int
) -> Floats:
    """[N] share of the hemisphere above a surface that is free nearby, weighted by cosine.

    Each sample sends `num_rays` rays, its own part of a pattern of which 16 samples make up the whole.
    """
    tangent, other = _frames(normals)
    free = np.zeros(len(points), np.float32)
    start = points + LIFT * normals
    total = 16 * num_rays
    for ray in range(num_rays):
        index = (ray * 16 + (sample * 7) % 16).astype(np.float32)
        angle = index * np.float32(math.pi * (3.0 - math.sqrt(5.0)))
        radius = np.sqrt((index + np.float32(0.5)) / np.float32(total))
        height = np.sqrt(1.0 - radius * radius)
        directions = (
            (radius * np.cos(angle))[:, None] * tangent
            + (radius * np.sin(angle))[:, None] * other
            + height[:, None] * normals
        )
        free += ~blockers.is_blocked(start, directions, OPENNESS_REACH)
    return free / np.float32(num_rays)


def shade(
    model: Model,
    seen: Surfaces,
    directions: Floats,
    sun: Floats,
    look: Look,
    sample: NDArray[np.integer],
    num_rays: int,
) -> tuple[Floats, Floats]:
    """Light [N, 3] that surfaces send along rays [N, 3] to the eye, and how much of what is behind shows through [N]."""
    shadow = sun_visibility(model.blockers, seen.point, seen.flat, sun, look, sample)
    free = openness(model.blockers, seen.point, seen.flat, sample, num_rays)
    facing = np.clip(seen.normal @ sun, 0.0, None) * shadow
    skylight = ambient(look, seen.normal)
    closed = look.bounce * np.array(look.ground, np.float32)
    received = facing[:, None] * np.array(look.sun, np.float32) + free[:, None] * skylight
    received += (1.0 - free)[:, None] * closed

    color, metallic = model.color[seen.material], model.metallic[seen.material][:, None]
    roughness, opacity = model.roughness[seen.material], model.opacity[seen.material]
    mirrored = _mirrored(seen, directions, model, sun, look, shadow, free, roughness)
    facing_eye = np.clip(-dot(seen.normal, directions), 0.0, 1.0)
    at_normal = DIELECTRIC + (color - DIELECTRIC) * metallic
    grazing = (1.0 - roughness) * (1.0 - facing_eye) ** 5
    fresnel = at_normal + (1.0 - at_normal) * grazing[:, None]
    diffuse = color * received * (1.0 - metallic) * (1.0 - fresnel)
    light = opacity[:, None] * diffuse + fresnel * mirrored + model.emissive[seen.material] * 2.0
    through = (1.0 - opacity) * (1.0 - fresnel.mean(axis=1))
    return light, through


def _mirrored(
    seen: Surfaces,
    directions: Floats,
    model: Model,
    sun: Floats,
    look: Look,
    shadow: Floats,
    free: Floats,
    roughness: Floats,
) -> Floats:
    """[N, 3] what a surface mirrors: the surroundings, the model itself in smooth surfaces, and the sun's highlight."""
    along = directions - 2.0 * dot(directions, seen.normal)[:, None] * seen.normal
    image = surroundings(look, along)
    blur = roughness[:, None]
    image = image + blur * (ambient(look, seen.normal) - image)
    image *= (free + (1.0 - free) * look.bounce)[:, None]
    smooth = np.flatnonzero(roughness < 0.35)
    if len(smooth):
        start = seen.point[smooth] + LIFT * seen.flat[smooth]
        hits = model.tracer.first_hit(start, along[smooth])
        met = hits.triangle >= 0
        other = model.material[hits.triangle[met]]
        image[smooth[met]] = model.color[other] * (0.55 * np.array(look.sky, np.float32)) + model.emissive[other]
        image[smooth[~met]] = surroundings(look, along[smooth[~met]])
    # GGX distribution about the mirror direction, its peak held down so that single samples do not sparkle.
    alpha = np.clip(roughness * roughness, 0.02, 1.0)
    closeness = np.clip(along @ sun, 0.0, 1.0)
    half_cosine = (1.0 + closeness) * 0.5
    spread = half_cosine * (alpha * alpha - 1.0) + 1.0
    highlight = np.minimum(alpha * alpha / (4.0 * spread * spread * alpha), 6.0) * shadow
    return image + highlight[:, None] * np.array(look.sun, np.float32)


def _across(direction: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors [3] that make a right-handed frame with a direction [3]."""
    tangent, other = _frames(direction[None])
    return tangent[0], other[0]


def _frames(normals: Floats) -> tuple[Floats, Floats]:
    """Tangents [N, 3] that complete unit normals to frames (Duff et al. 2017, Building an Orthonormal Basis)."""
    x, y, z = normals.T
    sign = np.where(z < 0, np.float32(-1), np.float32(1))
    a = -1.0 / (sign + z)
    b = x * y * a
    return (
        np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1),
        np.stack([b, sign + y * y * a, -y], axis=1),
    )
