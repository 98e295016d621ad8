"""Cameras: viewpoints, and framing of models."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.errors import UsageError

NEAREST = 0.02
"""Smallest distance of the eye from a model, in radii of the model."""


@dataclass(frozen=True, slots=True)
class View:
    """Direction of view; the default is a three-quarter view from the front right."""

    azimuth: float = 35.0
    """Degrees around the model, from the +z axis (its front) towards +x (its right)."""
    elevation: float = 22.0
    """Degrees above the horizon, -89..89."""
    field_of_view: float = 26.0
    """Vertical angle of the picture in degrees, 0..120; 0 is a parallel (orthographic) projection."""
    margin: float = 0.07
    """Margin around the model as a share of the picture, 0..0.4."""

    def __post_init__(self) -> None:
        for name, low, high in (
            ("azimuth", -3600.0, 3600.0),
            ("elevation", -89.0, 89.0),
            ("field_of_view", 0.0, 120.0),
            ("margin", 0.0, 0.4),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise UsageError(f"{name} of the view is {value}; expected {low:g} to {high:g}")


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera in world metres, y up."""

    position: AnyFloats
    """[3] the eye; for a parallel projection, a point in front of everything."""
    axes: AnyFloats
    """[3, 3] rows are the directions right, up and backward of the picture."""
    half_height: float
    """Half the height of the picture: a tangent, or metres for a parallel projection."""
    parallel: bool

    def rays(self, x: AnyFloats, y: AnyFloats, aspect: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Origins and unit directions [H * W, 3] of the rays through a grid of points of the picture, row by row.

        Args:
            x: [W] coordinates from -1 at the left to 1 at the right border.
            y: [H] coordinates from -1 at the bottom to 1 at the top.
            aspect: width over height of the picture.
        """
        right, up, back = self.axes.astype(np.float32)
        across = (x * (self.half_height * aspect)).astype(np.float32)[None, :, None] * right
        plane = across + (y * self.half_height).astype(np.float32)[:, None, None] * up
        position = self.position.astype(np.float32)
        if self.parallel:
            origins, directions = plane + position, np.broadcast_to(-back, plane.shape)
        else:
            directions = plane - back
            directions /= np.sqrt(np.einsum("hwi,hwi->hw", directions, directions))[..., None]
            origins = np.broadcast_to(position, plane.shape)
        return origins.reshape(-1, 3), directions.reshape(-1, 3)

    def seen_from(self, origin: AnyFloats, unit: float) -> Camera:
        """The same camera relative to another origin [3], in another unit in metres."""
        half_height = self.half_height / unit if self.parallel else self.half_height
        return replace(self, position=(self.position - origin) / unit, half_height=half_height)


def frame(points: NDArray[np.floating], aspect: float, view: View) -> Camera:
    """The nearest camera from which all points are in the picture, centred.

    Args:
        points: [P, 3] world metres, at least one.
        aspect: width over height of the picture.
        view: the direction.
    """
    axes = _axes(view)
    low, high = points.min(axis=0), points.max(axis=0)
    centre = (low + high).astype(np.float64) / 2
    in_camera = (points - centre) @ axes.T
    radius = float(np.linalg.norm((high - low).astype(np.float64))) / 2 or 1.0
    inside = 1.0 - 2.0 * view.margin
    if view.field_of_view == 0:
        middle = (in_camera.min(axis=0) + in_camera.max(axis=0)) / 2
        extent = (in_camera.max(axis=0) - in_camera.min(axis=0)) / 2
        half_height = float(max(extent[1], extent[0] / aspect, 1e-6 * radius)) / inside
        eye = np.array([middle[0], middle[1], 4 * radius])
        return Camera(centre + eye @ axes, axes, half_height, parallel=True)
    tangent = math.tan(math.radians(view.field_of_view) / 2)
    shift_x, distance_x = _between_planes(in_camera[:, 0], in_camera[:, 2], tangent * aspect * inside)
    shift_y, distance_y = _between_planes(in_camera[:, 1], in_camera[:, 2], tangent * inside)
    nearest = float(in_camera[:, 2].max()) + NEAREST * radius
    eye = np.array([shift_x, shift_y, max(distance_x, distance_y, nearest)])
    return Camera(centre + eye @ axes, axes, tangent, parallel=False)


def seen_aspect(points: NDArray[np.floating], view: View) -> float:
    """Width over height of points [P, 3] as a parallel camera sees them, 0.01 to 100."""
    width, height = np.ptp(points.astype(np.float64) @ _axes(view)[:2].T, axis=0)
    return float(np.clip(width / height, 0.01, 100.0)) if height > 0 and width > 0 else 1.0


def frame_alike(models: list[NDArray[np.floating]], aspect: float, view: View) -> list[Camera]:
    """A camera for each model such that all models appear at one scale and stand on one line.

    Args:
        models: points [P, 3] of each model; at least one point each.
        aspect: width over height of the pictures.
        view: the direction, the same for all.
    """
    bases = [_base(points) for points in models]
    together = np.concatenate([points - base for points, base in zip(models, bases, strict=True)])
    camera = frame(together, aspect, view)
    return [replace(camera, position=camera.position + base) for base in bases]


def _base(points: NDArray[np.floating]) -> AnyFloats:
    """[3] the middle of the ground below the points."""
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    return np.array([(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2])


def _axes(view: View) -> AnyFloats:
    """[3, 3] rows right, up, backward."""
    azimuth, elevation = math.radians(view.azimuth), math.radians(view.elevation)
    right = np.array([math.cos(azimuth), 0.0, -math.sin(azimuth)])
    back = np.array(
        [math.sin(azimuth) * math.cos(elevation), math.sin(elevation), math.cos(azimuth) * math.cos(elevation)]
    )
    return np.stack([right, np.cross(back, right), back])


def _between_planes(across: AnyFloats, towards: AnyFloats, tangent: float) -> tuple[float, float]:
    """Position of an eye, sideways and backwards, such that points lie between two planes through it.

    Args:
        across: [P] coordinate along the picture.
        towards: [P] coordinate towards the eye.
        tangent: tangent of half the angle between the planes.
    """
    upper = float((across / tangent + towards).max())
    lower = float((-across / tangent + towards).max())
    return tangent * (upper - lower) / 2, (upper + lower) / 2
