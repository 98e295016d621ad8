"""Selection of assets and images that fit a scope best: lists of files sorted by size or by ratio."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.asset_functions import image_extent, matching_files, mesh_extent, root_of
from grammarlab.derivation.functions.number_functions import one_of
from grammarlab.derivation.functions.text_functions import items, joined
from grammarlab.derivation.state.shapes import Value, kind_of
from grammarlab.errors import DerivationError
from grammarlab.language.syntax.keywords import KEYWORDS

Extent = Callable[[str, FunctionCall], tuple[float, ...]]
"""The extent of a file along each axis: three for a mesh, two for an image."""


@dataclass(frozen=True, slots=True)
class _Measure:
    """Measure of how well a file fits a scope."""

    extent: Extent
    compare: Callable[[np.ndarray], float]
    """The misfit from the logarithms of scope over file along each axis; 0 for a file that fits."""
    axes: tuple[str, ...]
    """Allowed axes; the last is the default for other texts."""
    is_image: bool = False

    def misfit(self, path: str, axes: str, size: Sequence[float], call: FunctionCall) -> tuple[float, float]:
        """The misfit, and the largest part by which the file would be scaled; infinite for a flat scope or file."""
        extent = self.extent(path, call)
        file = extent if self.is_image else [extent["xyz".index(axis)] for axis in axes]
        scope = [size["xyz".index(axis)] for axis in axes]
        if min(*file, *scope, 1.0) <= 0.0:
            return np.inf, np.inf
        scales = np.array(scope) / np.array(file)
        return self.compare(np.log(scales)), float(np.abs(scales - 1.0).max())


def _stretch(scales: np.ndarray) -> float:
    """Misfit of proportions: the range of the logarithms of the scales."""
    return float(scales.max() - scales.min())


def _growth(scales: np.ndarray) -> float:
    """Misfit of size: the largest absolute logarithm of the scales, so that twice and half have equal misfit."""
    return float(np.abs(scales).max())


_SIZE = _Measure(mesh_extent, _growth, ("x", "xy", "xz", "y", "yz", "z", "xyz"))
_RATIO = _Measure(mesh_extent, _stretch, ("xy", "xz", "yz", "xyz"))
_IMAGE = _Measure(image_extent, _stretch, ("xz", "yx", "yz", "zx", "zy", "xy"), is_image=True)


def _sorting(measure: _Measure) -> Builtin:
    """``assetsSortSize(list, axes, error)`` and similar functions: the list sorted by fit, best first.

    Files that fit equally well keep their order. With an error greater than 0, the list has only files that would be
    scaled by at most that share along each axis.
    """

    def evaluate(call: FunctionCall) -> Value:
        axes = str(call.arguments[1])
        return _for_each(call, lambda text, size, error: joined(_sorted(measure, items(text), axes, size, error, call)))

    words = KEYWORDS["axis_pair" if measure.is_image else "axes"]
    return Builtin(evaluate, (3, 3) if measure is _SIZE else (2, 2), keywords=words)


def _best(measure: _Measure) -> Builtin:
    """``assetBestSize(pattern, axes)`` and similar: the matching file that fits best, empty if there is none."""

    def evaluate(call: FunctionCall) -> Value:
        def best(pattern: str, size: Sequence[float], last: float) -> str:
            return next(iter(_candidates(measure, pattern, size, call)), "")

        return _for_each(call, best)

    return Builtin(evaluate, (2, 2))


def _approximate(measure: _Measure) -> Builtin:
    """``assetApproxSize(pattern, axes, n)`` and similar: one of the n files that fit best, all equally likely."""

    def evaluate(call: FunctionCall) -> Value:
        def nearest(pattern: str, size: Sequence[float], count: float) -> str:
            candidates = _candidates(measure, pattern, size, call)
            return joined(candidates[: max(0, round(count))] if count > 0 or not measure.is_image else candidates)

        return one_of(call, _for_each(call, nearest))

    return Builtin(evaluate, (3, 3), random=True)


def _fitting(call: FunctionCall) -> Value:
    """``assetFitSize(pattern, axes, error)``: one of the files that are scaled by at most that share of their size."""

    def fitting(pattern: str, size: Sequence[float], error: float) -> str:
        return joined(_candidates(_SIZE, pattern, size, call, error))

    return one_of(call, _for_each(call, fitting))


def _candidates(
    measure: _Measure, pattern: str, size: Sequence[float], call: FunctionCall, error: float = 0.0
) -> list[str]:
    """The asset files that match a pattern, best first."""
    second = call.arguments[1]
    axes = second if isinstance(second, str) and second in measure.axes else measure.axes[-1]
    return _sorted(measure, matching_files(root_of(call), pattern), axes, size, error, call)


def _sorted(
    measure: _Measure, paths: Sequence[str], axes: str, size: Sequence[float], error: float, call: FunctionCall
) -> list[str]:
    misfits = {path: measure.misfit(path, axes, size, call) for path in paths}
    return sorted((path for path in paths if error <= 0.0 or misfits[path][1] <= error), key=lambda p: misfits[p][0])


def _for_each(call: FunctionCall, choose: Callable[[str, Sequence[float], float], str]) -> Value:
    """A string from the first argument, the size of the scope and the last argument, computed once per combination."""
    text, last = call.arguments[0], call.arguments[-1]
    if kind_of(text) != "string":
        raise DerivationError(f"{call.name} expected a string, found a {kind_of(text)}", call.location)
    strings, count = call.workspace.strings, call.shapes.num
    numbers = last if len(call.arguments) == 3 else 0.0
    if kind_of(numbers) != "float":
        raise DerivationError(f"{call.name} expected a number last, found a {kind_of(numbers)}", call.location)
    ids = np.full(count, strings.id(text)) if isinstance(text, str) else np.asarray(text)
    table = np.column_stack([ids, np.broadcast_to(np.asarray(numbers, np.float64), count), call.shapes.size])
    rows, inverse = np.unique(table, axis=0, return_inverse=True)
    files = [choose(strings[int(row[0])], row[2:], row[1]) for row in rows.tolist()]
    return strings.ids(files)[inverse.ravel()]


BUILTINS: dict[str, Builtin] = {
    "assetApproxRatio": _approximate(_RATIO),
    "assetApproxSize": _approximate(_SIZE),
    "assetBestRatio": _best(_RATIO),
    "assetBestSize": _best(_SIZE),
    "assetFitSize": Builtin(_fitting, (3, 3), random=True),
    "assetsSortRatio": _sorting(_RATIO),
    "assetsSortSize": _sorting(_SIZE),
    "imageApproxRatio": _approximate(_IMAGE),
    "imageBestRatio": _best(_IMAGE),
    "imagesSortRatio": _sorting(_IMAGE),
}
