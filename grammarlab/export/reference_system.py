"""Names of coordinate reference systems of frames as CityJSON has them: URLs of systems with heights."""

from __future__ import annotations

import re

import numpy as np

from grammarlab.extras import named_extras
from grammarlab.geometry.footprints.frame import Frame

_URL = "https://www.opengis.net/def/crs/EPSG/0/"


def reference_system_url(frame: Frame) -> str | None:
    """URL of the system of a frame; None if the frame has no place, or a system without a code of EPSG.

    CityJSON asks for a system with heights: it is the only one of EPSG that consists of the frame's and of heights and
    is in use at the origin of the frame. If there are several, or none, it is the frame's own.

    Raises:
        UsageError: If the extra ``city`` is missing.

    >>> reference_system_url(Frame("EPSG:28992", (85000.0, 447000.0)))
    'https://www.opengis.net/def/crs/EPSG/0/7415'
    """
    code = re.fullmatch(r"EPSG:(\d+)", frame.crs, re.IGNORECASE)
    if code is None:
        return None
    compounds = _compounds(frame)
    return _URL + (compounds[0] if len(compounds) == 1 else code[1])


def _compounds(frame: Frame) -> list[str]:
    """Codes of the systems of EPSG with heights that contain that of a frame."""
    with named_extras():
        from pyproj import CRS  # noqa: PLC0415  # an extra
        from pyproj.aoi import AreaOfInterest  # noqa: PLC0415
        from pyproj.database import query_crs_info  # noqa: PLC0415
        from pyproj.enums import PJType  # noqa: PLC0415
    ((longitude, latitude),) = frame.longitude_latitude(np.zeros((1, 2))).tolist()
    if not (abs(longitude) <= 180 and abs(latitude) <= 90):
        return []
    area = AreaOfInterest(longitude, latitude, longitude, latitude)
    infos = query_crs_info("EPSG", PJType.COMPOUND_CRS, area, contains=True)
    horizontal = CRS.from_user_input(frame.crs).to_authority()
    return sorted(
        info.code
        for info in infos
        if not info.deprecated and CRS.from_epsg(int(info.code)).sub_crs_list[0].to_authority() == horizontal
    )
