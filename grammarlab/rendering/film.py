"""Samples of a picture, and their conversion to pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.rendering.camera import Camera
from grammarlab.rendering.light.look import background
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.scene.color import srgb_from_linear

Floats = NDArray[np.floating]


@dataclass(frozen=True, slots=True)
class Samples:
    """One ray per sample for rows of samples."""

    shape: tuple[int, int]
    """[H, W], with N = H * W."""
    origins: Floats
    """[N, 3] in the camera's units."""
    directions: Floats
    """[N, 3] unit vectors."""
    pattern: NDArray[np.int32]
    """[N] 0..15, repeating every 4 x 4 samples: selects openness rays."""
    spot: Floats
    """[N] in 0..1, evenly spread within each pixel: selects a point of the sun."""


def samples(camera: Camera, options: RenderOptions, start: int, stop: int) -> Samples:
    """The samples of the rows start..stop, which may lie outside the picture."""
    across = options.samples
    width = options.width * across
    row, column = np.arange(start, stop), np.arange(width)
    x = ((column + 0.5) / width * 2.0 - 1.0).astype(np.float32)
    origins, directions = camera.rays(x, _heights(options, start, stop), options.width / options.height)
    within_pixel = (row % across * across)[:, None] + column % across
    pattern = (row % 4 * 4)[:, None] + column % 4
    spot = (within_pixel.ravel().astype(np.float32) + np.float32(0.5)) / np.float32(across * across)
    return Samples((len(row), width), origins, directions, pattern.ravel().astype(np.int32), spot)


def paper(options: RenderOptions, start: int, stop: int) -> Floats:
    """[N, 3] colours of the background for samples of rows, linear in 0..1."""
    colors = background(options.look, _heights(options, start, stop))
    return np.repeat(colors, options.width * options.samples, axis=0)


def pixels(shown: Floats, options: RenderOptions) -> Floats:
    """[rows, width, 3] the means of the samples [N, 3] in each pixel of whole rows."""
    across = options.samples
    # One axis after the other is faster than a mean over both at once.
    lines = shown.reshape(-1, across, options.width * across * 3).mean(axis=1)
    return lines.reshape(-1, options.width, across, 3).mean(axis=2)


def develop(light: Floats) -> NDArray[np.uint8]:
    """[H, W, 3] sRGB from linear 0..1."""
    return np.rint(srgb_from_linear(light) * 255.0).astype(np.uint8)


def _heights(options: RenderOptions, start: int, stop: int) -> Floats:
    """[stop - start] heights of rows of samples in the picture, 1 at the top to -1 at the bottom."""
    rows = np.arange(start, stop)
    return (1.0 - (rows + 0.5) / (options.height * options.samples) * 2.0).astype(np.float32)
