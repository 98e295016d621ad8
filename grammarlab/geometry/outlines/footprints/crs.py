"""Coordinate reference systems (CRS) by their many names; only those in true metres or degrees are accepted."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any, Literal

from grammarlab.errors import AssetError
from grammarlab.geometry.outlines.footprints.epsg import degree_codes, metre_codes

Unit = Literal["degrees", "metres"]


@dataclass(frozen=True, slots=True)
class Crs:
    """A coordinate reference system whose first axis points to the east and second to the north."""

    name: str
    """``EPSG:25832``; empty for metres at an unknown place."""
    unit: Unit


LOCAL = Crs("", "metres")
"""Metres at an unknown place."""
WGS_84 = Crs("OGC:CRS84", "degrees")
"""Longitude and latitude, as RFC 7946 has it."""

_WIDEST = 80
"""Characters of a name that a message shows."""
_LONGEST = 20_000
"""Characters of the longest name, which may be a definition in WKT."""
_AUTHORITY = re.compile(r"\b(?:EPSG|ESRI|IAU|IGNF|SR-ORG)\b", re.IGNORECASE)
_EPSG = re.compile(
    r"""EPSG(?:\.xml\#|\.io/|/[\d.]+/|:[\d.]*:|[:/ _-]?)(\d{4,7})(?:[+,].*|/)?$  # URNs, URLs and short names
    |^(\d{4,7})$
    |(?:AUTHORITY|ID)\["EPSG",\s*"?(\d{4,7})"?\]\s*\]$  # the end of a definition in WKT""",
    re.IGNORECASE | re.VERBOSE,
)
_LONGITUDE_LATITUDE = re.compile(r"(?:\bCRS:?|\bOGC:2:)(84h?|83|27)$", re.IGNORECASE)
_DEGREES = re.compile(
    r"(GCS_)?(WGS[ _]?(19)?84|ETRS[ _]?(19)?89|ETRF[ _]?\d+|NAD[ _]?(19)?83(\(\w+\))?|North_American_1983)",
    re.IGNORECASE,
)
_WEB_MERCATOR = re.compile(r"\b(3857|3785|900913|102100|102113)$|Mercator_Auxiliary|(Pseudo|Popular).*Mercator", re.I)
_UTM = re.compile(r"(?:[\w() .-]+[/_ ] ?)?UTM[ _]zone[ _]?\d{1,2}[NS]", re.IGNORECASE)


def crs_of_member(member: Any) -> Crs:
    """The CRS of a member ``crs`` of GeoJSON.

    Raises:
        AssetError: If it is not known to be in true metres or degrees; it names the CRS but not the file.

    >>> crs_of_member({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}})
    Crs(name='EPSG:25832', unit='metres')
    """
    if member is None:
        return LOCAL
    properties = member.get("properties") if isinstance(member, dict) else None
    kind = str(member.get("type")).lower() if isinstance(member, dict) else ""
    if kind == "link":
        raise AssetError("its CRS is a link to another file, which is not followed")
    value = member
    if isinstance(properties, dict):
        value = next((properties[key] for key in ("name", "code", "wkid") if key in properties), None)
    if isinstance(value, int) and not isinstance(value, bool):
        value = str(value)
    if not isinstance(value, str) or not value.strip():
        raise AssetError(
            f"expected the name of a CRS in its member 'crs', found {_shown(json.dumps(member))}. Leave it out if the "
            "coordinates are degrees; otherwise find out their CRS, and add -s_srs EPSG:CODE below"
        )
    return crs_of_name(value.strip())


def crs_of_name(name: str) -> Crs:
    """The CRS of a name, a URN, a URL or an EPSG code.

    Raises:
        AssetError: If it is not known to be in true metres or degrees.
    """
    if len(name) > _LONGEST:
        raise _unknown(name)
    if match := _LONGITUDE_LATITUDE.search(name):
        return Crs(f"OGC:CRS{match[1].lower()}", "degrees")
    if match := _EPSG.search(name):
        return crs_of_code(int(match[1] or match[2] or match[3]))
    if _AUTHORITY.search(name) is None:
        if _DEGREES.fullmatch(name):
            return Crs(name, "degrees")
        if _UTM.fullmatch(name):
            return Crs(name, "metres")
    raise _unknown(name)


def crs_of_code(code: int) -> Crs:
    """The CRS of an EPSG code.

    Raises:
        AssetError: If it is not known to be in true metres or degrees.
    """
    name = f"EPSG:{code}"
    if code in metre_codes():
        return Crs(name, "metres")
    if code in degree_codes():
        return Crs(name, "degrees")
    raise _unknown(name)


def _unknown(name: str) -> AssetError:
    if _WEB_MERCATOR.search(name):
        return AssetError(f"its CRS, {_shown(name)}, is Web Mercator, whose metres are not those on the ground")
    return AssetError(f"its CRS, {_shown(name)}, is not known to count in true metres or in degrees")


def _shown(text: str) -> str:
    text = "".join(c if c.isprintable() else " " for c in text)
    return text if len(text) <= _WIDEST else f"{text[:_WIDEST]}…"
