"""Interface of all renderers."""

from __future__ import annotations

import abc
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.rendering.camera import Camera, View
from grammarlab.rendering.light.look import Look
from grammarlab.scene import TriangleBatch

LARGEST_SIDE = 16384
"""Largest width and height of a picture in pixels."""
LARGEST_AREA = 64_000_000
"""Largest number of pixels of a picture, which bounds the memory."""


@dataclass(frozen=True, slots=True)
class RenderOptions:
    """Size and quality of a picture."""

    width: int = 320
    """Pixels."""
    height: int = 320
    """Pixels."""
    samples: int = 2
    """Samples along each side of a pixel, 1..8."""
    openness_rays: int = 4
    """Number of rays per sample for ambient occlusion, 0..64; 0 turns it off."""
    edges: bool = True
    ground: bool = True
    """Whether the model is on the ground and casts its shadow there."""
    view: View = field(default_factory=View)
    look: Look = field(default_factory=Look)

    def __post_init__(self) -> None:
        for name, low, high in (
            ("width", 1, LARGEST_SIDE),
            ("height", 1, LARGEST_SIDE),
            ("samples", 1, 8),
            ("openness_rays", 0, 64),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise UsageError(f"{name} of the picture is {value}; expected {low} to {high}")
        if self.width * self.height > LARGEST_AREA:
            raise UsageError(
                f"a picture of {self.width} x {self.height} pixels is too large; expected at most {LARGEST_AREA} pixels"
            )


class AbstractRenderer(abc.ABC):
    """Makes pictures of models. The same input gives the same picture."""

    @abc.abstractmethod
    def render(self, batch: TriangleBatch, camera: Camera, options: RenderOptions) -> NDArray[np.uint8]:
        """The picture [height, width, 3] of a batch of one model, in sRGB.

        A model without triangles gives an empty sheet of paper.
        """
