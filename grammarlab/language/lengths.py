"""Lengths as people write them in maps: ``12 m``, ``7,5``, ``40 ft``, ``6'4"``."""

from __future__ import annotations

import re

_METRES = {
    **dict.fromkeys(("", "m", "metre", "metres", "meter", "meters"), 1.0),
    **dict.fromkeys(("km", "kilometre", "kilometres", "kilometer", "kilometers"), 1000.0),
    **dict.fromkeys(("cm", "centimetre", "centimetres", "centimeter", "centimeters"), 0.01),
    **dict.fromkeys(("mm", "millimetre", "millimetres", "millimeter", "millimeters"), 0.001),
    **dict.fromkeys(("ft", "foot", "feet", "'", "\u2032"), 0.3048),
    **dict.fromkeys(("in", "inch", "inches", '"', "\u2033"), 0.0254),
}
"""Metres of each unit; the foot is the international one."""
_LONGEST = 64
"""Characters of the longest text that is a length."""
_NUMBER = r"[-+]?\d+(?:[.,]\d+)?"
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*([a-z]*|['\"\u2032\u2033])\.?\s*", re.IGNORECASE)
_FEET_AND_INCHES = re.compile(r"\s*(\d+)\s*(?:'|ft|\u2032)\s*(\d+(?:\.\d+)?)\s*(?:\"|in|\u2033)\s*", re.IGNORECASE)
_THOUSANDS = re.compile(r"[-+]?\d{1,3},\d{3}")


def length(text: str) -> float | None:
    """A length in metres; None if a text is not a length.

    A number without a unit is in metres. A comma is a decimal point, but ``1,200`` may also be twelve hundred, so it is
    not a length.

    >>> length("12 m"), length("7,5"), length("40 ft"), length("1,200"), length("about 12")
    (12.0, 7.5, 12.192, None, None)
    """
    if len(text) > _LONGEST:
        return None
    if match := _FEET_AND_INCHES.fullmatch(text):
        return round(float(match[1]) * 0.3048 + float(match[2]) * 0.0254, 9)
    match = _LENGTH.fullmatch(text)
    if match is None or match[2].lower() not in _METRES or _THOUSANDS.fullmatch(match[1]):
        return None
    unit = _METRES[match[2].lower()]
    value = float(match[1].replace(",", "."))
    return value if unit == 1.0 else round(value * unit, 9)
