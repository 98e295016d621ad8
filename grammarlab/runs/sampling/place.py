"""The place of a run on the earth, as plain values for its manifest."""

from __future__ import annotations

from typing import Any

from grammarlab.runs.requests.request import SampleRequest


def place_of(request: SampleRequest) -> dict[str, Any]:
    """Where the origin of a run is: in world metres, and in its coordinate reference system.

    Returns:
        ``crs``, a name or None; ``origin``, x, y and z in world metres; and of that origin ``longitude`` and
        ``latitude`` in degrees, if the footprints were in degrees, otherwise ``easting`` and ``northing`` in metres.
    """
    x, y, z = request.origin or (0.0, 0.0, 0.0)
    georeference = request.georeference
    values: dict[str, Any] = {"crs": georeference.crs if georeference else None, "origin": [x, y, z]}
    if georeference is not None and georeference.longitude is not None:
        return values | {"longitude": georeference.longitude, "latitude": georeference.latitude}
    return values | {"easting": x, "northing": -z + 0.0}


def place_in_words(request: SampleRequest) -> str:
    """One sentence about the origin of a run; empty if it is that of an unknown world."""
    if request.georeference is None and request.origin is None:
        return ""
    place = place_of(request)
    system = place["crs"] or "unknown CRS"
    if "longitude" in place:
        where = f"longitude {place['longitude']:.7f}, latitude {place['latitude']:.7f}"
        return f"origin: {where} ({system}); x is east of it and z south, in metres"
    if request.origin is None:
        return f"coordinates: x is the easting and -z the northing ({system})"
    if request.file_format == "glb" and not request.single_file:
        return (
            f"coordinates: x is the easting and -z the northing ({system}); each file has its place in a node 'origin'"
        )
    where = f"easting {place['easting']:.10g}, northing {place['northing']:.10g}"
    return f"origin: {where} ({system}); all files count from it"
