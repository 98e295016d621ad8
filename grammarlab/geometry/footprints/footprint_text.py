"""Footprints from the text of an option: a size, well-known text (WKT), or the name of a map.

WKT may begin with an SRID, as PostGIS writes it: ``SRID=25832;POLYGON ((…))``.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from grammarlab.errors import AssetError, UsageError
from grammarlab.extras import require
from grammarlab.files import existing, open_regular, read_bounded
from grammarlab.geometry.footprints.crs import LOCAL, Crs, crs_of_code
from grammarlab.geometry.footprints.footprint import Footprint, FootprintMap, Outline, Remark, Source
from grammarlab.geometry.footprints.geojson import read_geojson
from grammarlab.geometry.footprints.map_file import VECTOR_SUFFIXES, is_cityjson, split_layer
from grammarlab.geometry.footprints.placing import placed, remark_lines

_NAME = "footprint"
"""Name of the source in messages."""
_MAX_NESTING = 64
"""Largest depth of parentheses."""
_MAX_SURFACES = 64
"""Largest number of surfaces in a text."""
_HEAD_BYTES = 256
_MAX_FILE_BYTES = 16 << 20
"""Largest size of a file of WKT."""
_START = re.compile(
    r"\s*(SRID\s*=|(MULTI)?(POINT|LINESTRING|POLYGON|SURFACE|CURVE)|GEOMETRYCOLLECTION|CURVEPOLYGON|COMPOUNDCURVE"
    r"|CIRCULARSTRING|TRIANGLE|TIN|POLYHEDRALSURFACE|GEOMETRY)\s*(Z|M|ZM)?\s*(\(|EMPTY|[-+\d]|$)",
    re.IGNORECASE,
)
_SRID = re.compile(r"\s*SRID\s*=\s*(-?\d{1,9})\s*;\s*(.*)", re.IGNORECASE | re.DOTALL)
_CURVES = re.compile(r"CIRCULARSTRING|COMPOUNDCURVE|MULTICURVE|CLOTHOID|SPIRAL", re.IGNORECASE)
_SOLIDS = re.compile(r"\b(TRIANGLE|TIN|POLYHEDRALSURFACE)", re.IGNORECASE)
_SIZE = re.compile(r"\s*(\d{1,30}(?:\.\d{1,30})?)\s*[xX×]\s*(\d{1,30}(?:\.\d{1,30})?)\s*")
_SUFFIXES = (".wkt", ".geojson", ".json", ".geojsonl", ".geojsons", ".geojsonseq", ".ndjson", ".jsonl")
_EXPECTED = (
    "expected WIDTHxDEPTH in metres (20x12), WKT (POLYGON ((0 0, 20 0, 20 12, 0 12, 0 0))) or a file of WKT or GeoJSON"
)


def read_footprints(text: str) -> tuple[Footprint, ...]:
    """Footprints from the text of an option: at least one.

    A Python warning lists what is left out of a file: lines, points, and polygons that cannot be used.

    Args:
        text: ``20x12``; WKT in metres, or with ``SRID=…;`` before it; or the path of a file of WKT, of GeoJSON, of
            GeoJSON lines or of a GeoJSON text sequence (RFC 8142); with the extra ``city``, of a GeoPackage, Shapefile,
            FlatGeobuf or CityJSON file, with ``:LAYER`` behind it if it has several layers.

    Raises:
        UsageError: If the text is none of these.
        AssetError: If a file or a polygon cannot be used.

    >>> import grammarlab as gl
    >>> gl.read_footprints("20x12")[0].polygon[:, [0, 2]].tolist()
    [[0.0, 12.0], [20.0, 12.0], [20.0, 0.0], [0.0, 0.0]]
    """
    plan = read_footprint_map(text)
    if plan.remarks:
        warnings.warn(f"{len(plan.remarks):,} remarks about the footprints:{remark_lines(plan.remarks)}", stacklevel=2)
    return plan.footprints


def read_footprint_map(text: str) -> FootprintMap:
    """Footprints from the text of an option, with their place and with remarks about what is left out.

    Args:
        text: text of the option, see `read_footprints`.

    Raises:
        UsageError: If the text is none of these.
        AssetError: If a file is broken, its coordinates are neither true metres nor degrees, or no polygon in it can be
            used; for WKT, if any polygon cannot.
    """
    return placed(read_source(text))


def read_source(text: str) -> Source:
    """Outlines from the text of an option, in the coordinates of their source.

    Raises:
        UsageError: If the text is none of those of `read_footprints`.
        AssetError: If a file is broken, or its coordinates are neither true metres nor degrees and the extra ``city``
            is missing.
    """
    source = _read(text)
    if source.crs.unit != "other":
        return source
    from grammarlab.geometry.footprints.map_source import in_metres  # noqa: PLC0415  # rare

    return in_metres(source)


def _read(text: str) -> Source:
    """Outlines from the text of an option, in any coordinate system."""
    if size := _SIZE.fullmatch(text):
        width, depth = float(size[1]), float(size[2])
        plan = shapely.Polygon([(0, -depth), (width, -depth), (width, 0), (0, 0)])  # along +x and +z, as in `derive`
        return Source(text, (Outline(plan, text),), (), LOCAL, strict=True)
    if existing(text) is None and _is_wkt(text):
        return _read_wkt(text, _EXPECTED)
    match split_layer(text):
        case Path() as file, layer if not file.is_dir():
            return _read_file(file, layer)
    if text.lower().endswith(_SUFFIXES):
        raise AssetError(f"{Path(text)}: no such footprint file; {_EXPECTED}.")
    raise UsageError(f"footprint {text!r}: {_EXPECTED}.")


def _read_file(path: Path, layer: str | None) -> Source:
    """Outlines of a map.

    Raises:
        AssetError: If it cannot be used, or needs the extra ``city`` and this is missing.
    """
    if path.suffix.lower() not in VECTOR_SUFFIXES and _is_wkt(_beginning(path)):
        if layer is not None:
            raise UsageError(f"{path}: WKT has no layers; leave out ':{layer[:80]}'.")
        return _read_wkt_file(path)
    if path.suffix.lower() not in VECTOR_SUFFIXES and not is_cityjson(path):
        if layer is not None:
            raise UsageError(f"{path}: GeoJSON has no layers; leave out ':{layer[:80]}'.")
        return read_geojson(path)
    if path.suffix.lower() in VECTOR_SUFFIXES:
        try:
            require("pyogrio")
        except UsageError as extra:
            try:
                return read_geojson(path)  # a wrong suffix is no reason to refuse it
            except AssetError as error:
                raise AssetError(f"{error} Or install what reads it: {extra}") from error
    from grammarlab.geometry.footprints.map_source import read_map  # noqa: PLC0415  # rare

    return read_map(path, layer)


def _beginning(path: Path) -> str:
    """The first characters of a regular file, without a byte order mark."""
    with open_regular(path) as file:
        return file.read(_HEAD_BYTES).decode("utf-8-sig", errors="replace")


def _read_wkt_file(path: Path) -> Source:
    """The outlines of all texts of a file, each of which begins in a line of its own.

    Raises:
        AssetError: If one of them cannot be read, or they have several coordinate systems.
    """
    sources = [_read_wkt(text, _EXPECTED) for text in _texts(_text_of(path))]
    systems = {source.crs for source in sources}
    if len(systems) > 1:
        names = ", ".join(sorted(crs.name for crs in systems))
        raise AssetError(f"{path}: expected one coordinate system for all texts, found {names}.")
    outlines = tuple(outline for source in sources for outline in source.outlines)
    remarks = tuple(remark for source in sources for remark in source.remarks)
    return replace(sources[0], name=str(path), outlines=outlines, remarks=remarks)


def _texts(content: str) -> list[str]:
    """Texts of WKT: a line that begins as one does, outside of parentheses, is the first of another."""
    texts: list[list[str]] = []
    depth = 0
    for line in filter(str.strip, content.splitlines()):
        if not texts or (depth == 0 and _is_wkt(line)):
            texts.append([])
        texts[-1].append(line)
        depth += line.count("(") - line.count(")")
    return ["\n".join(lines) for lines in texts]


def _text_of(path: Path) -> str:
    try:
        return read_bounded(path, _MAX_FILE_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise AssetError(f"{path}: expected WKT in UTF-8: {error}") from error


def _is_wkt(text: str) -> bool:
    """Whether a text begins as WKT does, unlike the name of a file such as ``polygons.geojson``.

    >>> _is_wkt("POLYGON ((0 0, 9 0, 9 9, 0 0))"), _is_wkt("SRID=4326;POINT (7 50)"), _is_wkt("polygons.geojson")
    (True, True, False)
    """
    return _START.match(text) is not None


def _read_wkt(text: str, expected: str) -> Source:
    """The polygons of a text.

    Args:
        text: WKT, in metres unless an SRID says otherwise.
        expected: expected forms, for the message.

    Raises:
        AssetError: If it is not WKT, or has curves.
    """
    crs, body = LOCAL, text
    if match := _SRID.fullmatch(text):
        crs, body = _crs(int(match[1])), match[2]
    outlines: list[Outline] = []
    remarks: list[Remark] = []
    for part in _shapes(_flat(body), expected):
        if isinstance(part, shapely.Polygon):
            outlines.append(Outline(shapely.force_2d(part), _NAME))
        else:
            kind = type(part).__name__
            empty = "an empty " if shapely.is_empty(part) else "a "
            remarks.append(Remark(_NAME, "geometry", f"expected a polygon, found {empty}{kind}"))
    conversion = "Convert it: ST_Transform(geom, 4326) in PostGIS."
    return Source(_NAME, tuple(outlines), tuple(remarks), crs, strict=True, conversion=conversion)


def _crs(code: int) -> Crs:
    # PostGIS writes 0, and earlier -1, for an unknown place.
    return LOCAL if code <= 0 else crs_of_code(code)


def _shapes(text: str, expected: str) -> list[shapely.Geometry]:
    """The simple geometries of a text.

    Raises:
        AssetError: If it is not WKT, or nested too deeply.
    """
    depth = np.cumsum([(c == "(") - (c == ")") for c in text if c in "()"])
    if depth.max(initial=0) > _MAX_NESTING:
        raise AssetError(f"{_NAME}: expected at most {_MAX_NESTING} parentheses in each other.")
    try:
        with np.errstate(invalid="ignore", over="ignore"):  # not-a-number is reported later
            return _parts(shapely.from_wkt(text))
    # Shapely raises NotImplementedError for kinds of geometry that it has no class for.
    except (shapely.errors.ShapelyError, NotImplementedError, UnicodeEncodeError) as error:
        raise AssetError(f"{_NAME}: this is not well-formed WKT ({error}); {expected}.") from error


def _parts(shape: shapely.Geometry) -> list[shapely.Geometry]:
    """The simple geometries of a geometry; its nesting is bounded."""
    if shapely.is_empty(shape) or not isinstance(shape, shapely.GeometryCollection | shapely.MultiPolygon):
        return [shape]
    return [part for member in shape.geoms for part in _parts(member)]


def _flat(text: str) -> str:
    """WKT of plain polygons instead of surfaces whose rings are plain.

    Raises:
        AssetError: If rings have arcs, or are faces of a solid.
    """
    if match := _CURVES.search(text):
        raise AssetError(
            f"{_NAME}: {match[0].upper()} has arcs, and an outline has straight edges. Replace them by edges: "
            "ST_CurveToLine(geom) in PostGIS, ogr2ogr -nlt CONVERT_TO_LINEAR for files."
        )
    if match := _SOLIDS.search(text):
        raise AssetError(f"{_NAME}: {match[0].upper()} has faces in space; expected a POLYGON on the ground.")
    text = re.sub("CURVEPOLYGON", "POLYGON", text, flags=re.IGNORECASE)
    surfaces = [*re.finditer("MULTISURFACE", text, re.IGNORECASE)]
    if len(surfaces) > _MAX_SURFACES:
        raise AssetError(f"{_NAME}: expected at most {_MAX_SURFACES} MULTISURFACE.")
    for match in reversed(surfaces):
        end = _end_of_parentheses(text, match.end())
        members = re.sub(r"POLYGON\s*(ZM|Z|M)?", "", text[match.end() : end], flags=re.IGNORECASE)
        text = f"{text[: match.start()]}MULTIPOLYGON{members}{text[end:]}"
    return text


def _end_of_parentheses(text: str, start: int) -> int:
    """Index after the parenthesis that closes the first one after an index; the end of the text if none does."""
    depth = 0
    for index in range(start, len(text)):
        depth += (text[index] == "(") - (text[index] == ")")
        if text[index] == ")" and depth <= 0:
            return index + 1
    return len(text)
