"""``colorRamp``: colours for numbers from 0 to 1."""

from __future__ import annotations

import math
from bisect import bisect_right

from grammarlab.derivation.calls.calls import Builtin
from grammarlab.derivation.functions.colors import parse_color, to_hex
from grammarlab.derivation.functions.text import text_function

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


def color_ramp(gradient: str, value: float) -> str:
    """One of the 36 colours of a ramp: the first for 0 and below, the last for 1 and above; empty for an unknown ramp.

    >>> color_ramp("yellowToRed", 0.0), color_ramp("yellowToRed", 1.0), color_ramp("rainbow", 0.5)
    ('#f5f500', '#f50000', '')
    """
    anchors = _ANCHORS.get(gradient)
    if anchors is None or math.isnan(value):
        return ""
    step = min(int(_STEPS * min(max(value, 0.0), 1.0)), _STEPS - 1)
    place = min(bisect_right([at for at, _ in anchors], step), len(anchors) - 1)
    (before, first), (after, last) = anchors[place - 1], anchors[place]
    share = (step - before) / (after - before)
    pairs = zip(parse_color(first) or (), parse_color(last) or (), strict=True)
    return to_hex(*(a + share * (b - a) for a, b in pairs))


BUILTINS: dict[str, Builtin] = {"colorRamp": text_function(color_ramp, (2, 2))}
