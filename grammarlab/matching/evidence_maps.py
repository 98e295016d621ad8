"""Evidence of an element for each width and height, from samples of its posterior."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import gaussian_filter

from grammarlab.arrays import Floats

FINEST = 0.01
"""Least distance of values, metres."""
_MAX_VALUES = 200
"""Largest number of values along each axis."""
_KERNEL_RATIO = 0.5
"""Width of the kernel that smooths samples, as a multiple of the noise of an element's lines."""
_UNIFORM_SHARE = 1e-4
"""Uniform part of the evidence, for sizes without samples."""


@dataclass(frozen=True, eq=False)
class Maps:
    """Evidence of N elements for widths and heights; 1 for points without information."""

    widths: Floats
    """[A] widths, metres, evenly spaced."""
    heights: Floats
    """[B] heights, metres, evenly spaced."""
    evidence: Floats
    """[N, A, B] relative to the mean over all sizes."""

    @cached_property
    def logs_by_width(self) -> Floats:
        """[A, N, B] logarithm of the evidence, which a search for kinds needs hundreds of times."""
        return np.log(self.evidence.transpose(1, 0, 2))

    @cached_property
    def logs_by_height(self) -> Floats:
        """[B, N, A] the same numbers, so that those of one height are side by side."""
        return np.ascontiguousarray(self.logs_by_width.transpose(2, 1, 0))

    def blurred(self, deviation: float) -> Maps:
        """Evidence for sizes from which those of each element deviate normally, with this deviation in metres."""
        steps = [deviation / float(values[1] - values[0]) for values in (self.widths, self.heights)]
        return replace(self, evidence=gaussian_filter(self.evidence, (0.0, *steps), mode="nearest"))


def maps_of(parameters: Floats, smoothing: Floats, low: Floats, high: Floats) -> Maps:
    """Evidence maps from posterior samples with a uniform prior.

    Args:
        parameters: [N, Q, 2] widths and heights.
        smoothing: [N] standard deviation of the error of a side, metres.
        low: [2] least width and height.
        high: [2] largest width and height.
    """
    widths, heights = _axis_values(low[0], high[0]), _axis_values(low[1], high[1])
    shape = len(widths), len(heights)
    step = np.array([widths[1] - widths[0], heights[1] - heights[0]])
    indices = np.clip(np.rint((parameters - low) / step).astype(np.int64), 0, np.array(shape) - 1)
    evidence = np.empty((len(parameters), *shape))
    for element, cells in enumerate(indices):
        counts = np.bincount(cells[:, 0] * shape[1] + cells[:, 1], minlength=shape[0] * shape[1]).reshape(shape)
        width = np.maximum(_KERNEL_RATIO * smoothing[element] / step, 0.7)
        smooth = gaussian_filter(counts.astype(np.float64), width, mode="nearest")
        evidence[element] = smooth * ((1.0 - _UNIFORM_SHARE) * smooth.size / smooth.sum()) + _UNIFORM_SHARE
    return Maps(widths, heights, evidence)


def _axis_values(low: float, high: float) -> Floats:
    """Values from low to high, one centimetre apart, or more if there would be too many."""
    count = min(_MAX_VALUES, max(2, round((high - low) / FINEST) + 1))
    return np.linspace(low, high, count)
