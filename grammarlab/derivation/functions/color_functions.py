"""Functions between hexadecimal colours and their channels, and ``colorRamp``: colours for numbers from 0 to 1."""

from __future__ import annotations

import colorsys
import math
import re
from bisect import bisect_right
from collections.abc import Callable

import numpy as np

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.text_functions import text_function
from grammarlab.derivation.state.shapes import Value, kind_of, number_column
from grammarlab.errors import DerivationError

_HEX = re.compile(r"#?([0-9a-fA-F]{6})([0-9a-fA-F]{2})?\Z")
_STEPS = 36
"""Colours of a ramp."""
_ANCHORS = {
    "whiteToBlack": ((0, "#ffffff"), (35, "#000000")),
    "greenToRed": ((0, "#3ba800"), (17, "#ffff00"), (35, "#ff0000")),
    "yellowToRed": ((0, "#f5f500"), (35, "#f50000")),
    "redToBlue": ((0, "#c44539"), (17, "#fafcbb"), (35, "#3661cf")),
    "orangeToBlue": ((0, "#ffc800"), (8, "#ff730f"), (17, "#ff0051"), (26, "#e800a2"), (35, "#0000ff")),
    "brownToBlue": ((0, "#9c5621"), (17, "#ffffbf"), (35, "#218291")),
    "spectrum": (
        *((0, "#b952a4"), (5, "#3c53a3"), (10, "#39bfef"), (14, "#89c73d")),
        *((20, "#fbee24"), (25, "#f16d20"), (35, "#ed2726")),
    ),
}
"""Steps of each ramp with their colours; colours between steps are interpolated."""


def parse_color(text: str) -> tuple[float, ...] | None:
    """Red, green, blue and optional opacity in 0..1; None if the text is not a colour.

    >>> parse_color("#ff0080")
    (1.0, 0.0, 0.5019607843137255)
    """
    match = _HEX.match(text.strip())
    if match is None:
        return None
    digits = match.group(1) + (match.group(2) or "")
    return tuple(int(digits[i : i + 2], 16) / 255.0 for i in range(0, len(digits), 2))


def to_hex(*channels: float) -> str:
    """A colour from its channels, clamped to 0..1.

    >>> to_hex(1.0, 0.0, 0.5)
    '#ff0080'
    """
    return "#" + "".join(f"{round(255 * min(max(channel, 0.0), 1.0)):02x}" for channel in channels)


def _hsv_to_hex(hue: float, saturation: float, value: float, *opacity: float) -> str:
    clamped = (min(max(channel, 0.0), 1.0) for channel in (saturation, value))
    return to_hex(*colorsys.hsv_to_rgb(hue % 360.0 / 360.0, *clamped), *opacity)


def _from_hex(apply: Callable[[tuple[float, ...]], float]) -> Builtin:
    return text_function(lambda text: apply(color) if (color := parse_color(text)) is not None else math.nan)


def _hsv(channel: int) -> Builtin:
    scale = 360.0 if channel == 0 else 1.0
    return _from_hex(lambda color: scale * colorsys.rgb_to_hsv(*color[:3])[channel])


def _to_hex(apply: Callable[..., str], count: int) -> Builtin:
    """A colour from numbers, computed once for each different combination."""

    def evaluate(call: FunctionCall) -> Value:
        if any(kind_of(argument) == "string" for argument in call.arguments):
            raise DerivationError(f"{call.name} expected numbers, found a string", call.location)
        columns = any(isinstance(argument, np.ndarray) for argument in call.arguments)
        table = np.stack([number_column(a, call.shapes.num if columns else 1) for a in call.arguments], axis=1)
        if not np.isfinite(table).all():
            raise DerivationError(f"{call.name} expected finite numbers", call.location)
        unique, inverse = np.unique(table, axis=0, return_inverse=True)
        texts = [apply(*row) for row in unique.tolist()]
        return call.workspace.strings.ids(texts)[inverse] if columns else texts[0]

    return Builtin(evaluate, (count, count))


def _color_ramp(gradient: str, value: float) -> str:
    """One of the 36 colours of a ramp: the first for 0 and below, the last for 1 and above; empty for an unknown ramp.

    >>> _color_ramp("yellowToRed", 0.0), _color_ramp("yellowToRed", 1.0), _color_ramp("rainbow", 0.5)
    ('#f5f500', '#f50000', '')
    """
    anchors = _ANCHORS.get(gradient)
    if anchors is None or math.isnan(value):
        return ""
    step = min(int(_STEPS * min(max(value, 0.0), 1.0)), _STEPS - 1)
    segment_end = min(bisect_right([stop for stop, _ in anchors], step), len(anchors) - 1)
    (before, first), (after, last) = anchors[segment_end - 1], anchors[segment_end]
    share = (step - before) / (after - before)
    pairs = zip(parse_color(first) or (), parse_color(last) or (), strict=True)
    return to_hex(*(a + share * (b - a) for a, b in pairs))


BUILTINS: dict[str, Builtin] = {
    "colorHSVOToHex": _to_hex(_hsv_to_hex, 4),
    "colorHSVToHex": _to_hex(_hsv_to_hex, 3),
    "colorHexToB": _from_hex(lambda color: color[2]),
    "colorHexToG": _from_hex(lambda color: color[1]),
    "colorHexToH": _hsv(0),
    "colorHexToO": _from_hex(lambda color: color[3] if len(color) > 3 else 0.0),
    "colorHexToR": _from_hex(lambda color: color[0]),
    "colorHexToS": _hsv(1),
    "colorHexToV": _hsv(2),
    "colorRGBOToHex": _to_hex(to_hex, 4),
    "colorRGBToHex": _to_hex(to_hex, 3),
    "colorRamp": text_function(_color_ramp, (2, 2)),
}
