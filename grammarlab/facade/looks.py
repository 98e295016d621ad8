"""Looks of elements of facades without a picture: a colour, and the depth of the front."""

from __future__ import annotations

import colorsys
import re
from dataclasses import dataclass
from zlib import crc32

THICKNESS = 0.35
"""Metres from the front of a wall to its back, where all elements end."""


@dataclass(frozen=True, slots=True)
class LabelLook:
    """Look of an element."""

    color: str
    """``#rrggbb``, sRGB, or ``#rrggbboo`` with opacity."""
    front: float
    """Depth of its front relative to that of the wall, metres; below 0 behind it, above -`THICKNESS`."""
    is_flexible: bool = False
    """Whether it is wall: it fills the room between elements and is stretched before they are."""
    glazed: bool = False

    @property
    def metallic(self) -> float:
        """0 to 1."""
        return 0.35 if self.glazed else 0.0

    @property
    def roughness(self) -> float:
        """0 to 1."""
        return 0.12 if self.glazed else 0.8


_WINDOW = LabelLook("#2B3A48", -0.18, glazed=True)
_DOOR = LabelLook("#5B4030", -0.22)
_SHOP = LabelLook("#39424A", -0.12, glazed=True)
_BLIND = LabelLook("#6F7F6A", -0.06)
_SHUTTER = LabelLook("#6F7F6A", 0.06)
_CORNICE = LabelLook("#DDD6C6", 0.3)
_BAND = LabelLook("#DDD6C6", 0.1)
_PILLAR = LabelLook("#D3CBBB", 0.15)
_WALL = LabelLook("#CDBFA6", 0.0, is_flexible=True)
_BASE = LabelLook("#9A958B", 0.06, is_flexible=True)

_LOOKS = {
    **dict.fromkeys(("window", "pane", "glass", "light"), _WINDOW),
    **dict.fromkeys(("door", "gate", "portal", "entrance"), _DOOR),
    "shop": _SHOP,
    "balcony": LabelLook("#3A3D40", 0.5),
    **dict.fromkeys(("cornice", "coping", "eaves"), _CORNICE),
    **dict.fromkeys(("molding", "band", "belt", "frieze"), _BAND),
    "sill": LabelLook("#D8D2C4", 0.12),
    "blind": _BLIND,
    "shutter": _SHUTTER,
    **dict.fromkeys(("pillar", "pilaster", "column"), _PILLAR),
    "deco": LabelLook("#C9BFA9", 0.08),
    **dict.fromkeys(("base", "plinth"), _BASE),
    "roof": LabelLook("#5A4A44", -0.1),
    **dict.fromkeys(("wall", "facade", "background"), _WALL),
    "outside": LabelLook("#FFFFFF00", 0.01 - THICKNESS, is_flexible=True),
}

_SIGN_NOUNS = (
    *("sign", "signboard", "signage", "signpost", "advert", "advertisement", "advertising", "banner", "billboard"),
    *("logo", "logotype", "lettering", "inscription"),
)
_SIGNS = frozenset(_SIGN_NOUNS) | {f"{noun}s" for noun in _SIGN_NOUNS}
"""Words for elements that bear letters, in small letters."""
_WORD = r"[^\W\d_a-z]+(?![a-z])|[^\W\d_]?[a-z]+"
"""A word of a label: letters up to a digit, an underscore, a blank or the next capital; or capitals alone."""


def look_of(label: str) -> LabelLook:
    """The look of an element with this label: that of the first known word in it, or a colour derived from it.

    >>> look_of("Shop window").color == look_of("window").color, look_of("").is_flexible, look_of("clock").is_flexible
    (True, True, False)
    """
    if not label:
        return _WALL
    words = label.lower()
    match = next((look for word, look in _LOOKS.items() if word in words), None)
    if match is not None:
        return match
    channels = colorsys.hls_to_rgb(crc32(words.encode()) / 2**32, 0.55, 0.35)
    return LabelLook("#" + "".join(f"{round(255 * channel):02X}" for channel in channels), 0.05)


def is_door(label: str) -> bool:
    """Whether an element with this label is an entrance, whose number must not change."""
    return any(word in label.lower() for word in ("door", "gate", "portal", "entrance"))


def is_sign(label: str) -> bool:
    """Whether an element with this label bears letters, which are neither cut nor repeated.

    >>> is_sign("ShopSign2"), is_sign("street_sign"), is_sign("signal"), is_sign("design")
    (True, True, False, False)
    """
    words = {word.lower() for word in re.findall(_WORD, label)}
    return not words.isdisjoint(_SIGNS)


def is_opening(label: str) -> bool:
    """Whether an element with this label is a window or an entrance, whose proportions people notice."""
    return is_door(label) or look_of(label) is _WINDOW


def covers_opening(label: str) -> bool:
    """Whether an element with this label hides a part of a window, or all of it, as blinds and shutters do."""
    return look_of(label) in (_BLIND, _SHUTTER)


def is_shop(label: str) -> bool:
    """Whether an element with this label is a shop window, which may be as long as a whole storey."""
    return look_of(label) is _SHOP
