"""Footprints from the text of an option: a size, well-known text (WKT), or the name of a map.

WKT may begin with an SRID, as PostGIS writes it: ``SRID=25832;POLYGON ((…))``.
"""

from __future__ import annotations

import codecs
import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.errors import AssetError, TableError, UsageError
from grammarlab.extras import require
from grammarlab.files import existing, open_regular, read_bounded
from grammarlab.geometry.footprints.crs import LOCAL, Crs, crs_of_code
from grammarlab.geometry.footprints.footprint import Footprint, FootprintMap, Outline, Remark, Source
from grammarlab.geometry.footprints.geojson import MAX_FOOTPRINTS, read_geojson
from grammarlab.geometry.footprints.geojson_features import well_formed
from grammarlab.geometry.footprints.map_file import VECTOR_SUFFIXES, is_cityjson, split_layer
from grammarlab.geometry.footprints.map_layer import MAX_FEATURES
from grammarlab.geometry.footprints.placing import placed, remark_lines
from grammarlab.tables import decoded

_NAME = "footprint"
"""Name of the source in messages."""
_MAX_NESTING = 64
"""Largest depth of parentheses."""
_MAX_SURFACES = 64
"""Largest number of surfaces in a text."""
_HEAD_BYTES = 4096
"""Bytes at the beginning of a file that decide whether it is WKT; blank lines count."""
_MAX_FILE_BYTES = 16 << 20
"""Largest size of a file of WKT."""
_START = re.compile(
    r"\s*(SRID\s*=|(MULTI)?(POINT|LINESTRING|POLYGON|SURFACE|CURVE)|GEOMETRYCOLLECTION|CURVEPOLYGON|COMPOUNDCURVE"
    r"|CIRCULARSTRING|TRIANGLE|TIN|POLYHEDRALSURFACE|GEOMETRY)\s*(Z|M|ZM)?\s*(\(|EMPTY|[-+\d]|$)",
    re.IGNORECASE,
)
_SRID = re.compile(r"\s*SRID\s*=\s*(-?\d{1,9})\s*;\s*(.*)", re.IGNORECASE | re.DOTALL)
_RARE = re.compile(r"CURVE|SURFACE|CIRC|CLOTHOID|SPIRAL|TRIANGLE|TIN", re.IGNORECASE)
"""Beginnings of all that `_flat` changes or refuses."""
_COLLECTION = re.compile(r"(SRID[^;]*;)?\s*(GEOMETRYCOLLECTION|MULTI|COMPOUND|CURVEPOLYGON)", re.IGNORECASE)
"""Beginnings of geometries whose members may have names of their own."""
_CURVES = re.compile(r"CIRCULARSTRING|COMPOUNDCURVE|MULTICURVE|CLOTHOID|SPIRAL", re.IGNORECASE)
_SOLIDS = re.compile(r"\b(TRIANGLE|TIN|POLYHEDRALSURFACE)", re.IGNORECASE)
_SIZE = re.compile(r"\s*(\d{1,30}(?:\.\d{1,30})?)\s*[xX×]\s*(\d{1,30}(?:\.\d{1,30})?)\s*")
_SUFFIXES = (".wkt", ".geojson", ".json", ".geojsonl", ".geojsons", ".geojsonseq", ".ndjson", ".jsonl")
_CONVERSION = "Convert it: ST_Transform(geom, 4326) in PostGIS."
_PARSE_ERRORS = (shapely.errors.ShapelyError, NotImplementedError, UnicodeEncodeError)
"""What shapely raises for texts that it cannot read: NotImplementedError for kinds that it has no class for."""
_ALONE = "expected WKT alone, without columns, quotes or ';' around it"
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
            used; for WKT that is the text itself, if any polygon cannot.
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
        return Source(text, (Outline(plan, text),), (), LOCAL, origin="text")
    if existing(text) is None and _is_wkt(text):
        return _read_wkt(text)
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
    if _is_wkt_file(path):
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


def _is_wkt_file(path: Path) -> bool:
    """Whether a regular file is WKT: by its name, unless it begins as JSON does, or by its beginning."""
    suffix = path.suffix.lower()
    if suffix in VECTOR_SUFFIXES:
        return False
    beginning = _beginning(path)
    return _is_wkt(beginning) or (suffix == ".wkt" and not beginning.lstrip().startswith(("{", "[")))


def _beginning(path: Path) -> str:
    """The first characters of a regular file in UTF-8 or UTF-16, without a byte order mark."""
    with open_regular(path) as file:
        head = file.read(_HEAD_BYTES)
    is_wide = head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return head.decode("utf-16" if is_wide else "utf-8-sig", errors="replace")


@dataclass(frozen=True, slots=True)
class _Body:
    """WKT without its SRID, of plain polygons instead of surfaces."""

    line: int
    """Number of its first line, from 1."""
    text: str
    crs: Crs


def _read_wkt_file(path: Path) -> Source:
    """The outlines of all texts of a file, each of which begins in a line of its own.

    Raises:
        AssetError: If there are too many, or they have several coordinate systems.
    """
    entries = [_entry(path, line, text) for line, text in _texts(path)]
    bodies = [entry for entry in entries if isinstance(entry, _Body)]
    shapes = dict(zip((body.line for body in bodies), _geometries([body.text for body in bodies]), strict=True))
    crs = _common_crs(path, [body for body in bodies if shapes[body.line] is not None])
    outlines: list[Outline] = []
    remarks: list[Remark] = []
    for entry in entries:
        if isinstance(entry, Remark):
            remarks.append(entry)
            continue
        name, shape = _name(path, entry.line), shapes[entry.line]
        if shape is None:
            remarks.append(Remark(name, "record", f"{_fault_of(entry.text)}; {_ALONE}"))
            continue
        polygons, omissions = _polygons(shape, name)
        outlines += polygons
        remarks += omissions
        if len(outlines) > MAX_FOOTPRINTS:
            raise AssetError(f"{path}: expected at most {MAX_FOOTPRINTS:,} polygons. Cut out a smaller area.")
    return Source(str(path), tuple(outlines), tuple(remarks), crs, origin="file of WKT", conversion=_CONVERSION)


def _entry(path: Path, line: int, text: str) -> _Body | Remark:
    try:
        return _body(text, line)
    except _WktError as error:
        return Remark(_name(path, line), "outline", str(error))


def _name(path: Path, line: int) -> str:
    return f"{well_formed(path.name)}, line {line}"


def _common_crs(path: Path, bodies: Sequence[_Body]) -> Crs:
    """The coordinate system of all texts of a file.

    Raises:
        AssetError: If they have several.
    """
    lines: dict[Crs, int] = {}
    for body in bodies:
        lines.setdefault(body.crs, body.line)
    if len(lines) > 1:
        names = ", ".join(f"{crs.name or 'none (metres)'} in line {line}" for crs, line in lines.items())
        raise AssetError(f"{path}: expected one coordinate system for all texts, found {names}.")
    return next(iter(lines), LOCAL)


def _texts(path: Path) -> list[tuple[int, str]]:
    """Texts of a file of WKT and the numbers of their first lines.

    A text goes on until all its parentheses are closed, and what is no WKT to the end of its line. A line that begins
    as WKT does is the first of another text unless a collection goes on there: a missing parenthesis spoils one alone.

    Raises:
        AssetError: If there are none or too many, or it is no text.
    """
    texts: list[tuple[int, list[str]]] = []
    depth, is_open = 0, False
    for number, line in enumerate(_text_of(path).splitlines(), 1):
        content = line.strip()
        if not content:
            continue
        is_wkt = _is_wkt(content)
        is_member = is_open and depth > 0 and _goes_on(texts[-1][1])
        if not is_open or (is_wkt and not is_member):
            texts.append((number, []))
            depth, is_open = 0, is_wkt
        texts[-1][1].append(content)
        depth += content.count("(") - content.count(")")
        is_open = is_open and not (depth <= 0 and content.upper().endswith((")", "EMPTY")))
        if len(texts) > MAX_FEATURES:
            raise AssetError(f"{path}: expected at most {MAX_FEATURES:,} texts. Cut out a smaller area.")
    if not texts:
        raise AssetError(f"{path}: expected WKT, found an empty file.")
    return [(number, "\n".join(lines)) for number, lines in texts]


def _goes_on(lines: Sequence[str]) -> bool:
    """Whether the next line may be a member of the geometry that these lines begin."""
    return lines[-1].endswith((",", "(")) and _COLLECTION.match(lines[0]) is not None


def _text_of(path: Path) -> str:
    try:
        return decoded(read_bounded(path, _MAX_FILE_BYTES)).lstrip("\ufeff")
    except TableError as error:
        raise AssetError(f"{path}: expected WKT: {error}") from error


def _is_wkt(text: str) -> bool:
    """Whether a text begins as WKT does, unlike the name of a file such as ``polygons.geojson``.

    >>> _is_wkt("POLYGON ((0 0, 9 0, 9 9, 0 0))"), _is_wkt("SRID=4326;POINT (7 50)"), _is_wkt("polygons.geojson")
    (True, True, False)
    """
    return _START.match(text) is not None


class _WktError(ValueError):
    """WKT that is too deep, or has no polygons with straight edges on the ground."""


def _read_wkt(text: str) -> Source:
    """The polygons of the text of an option, in metres unless an SRID says otherwise.

    Raises:
        AssetError: If it is not WKT, or has curves.
    """
    try:
        body = _body(text, 1)
    except _WktError as error:
        raise AssetError(f"{_NAME}: {error}") from error
    (shape,) = _geometries([body.text])
    if shape is None:
        raise AssetError(f"{_NAME}: {_fault_of(body.text)}; {_EXPECTED}.")
    outlines, remarks = _polygons(shape, _NAME)
    return Source(_NAME, tuple(outlines), tuple(remarks), body.crs, origin="text", conversion=_CONVERSION)


def _body(text: str, line: int) -> _Body:
    """A text that is safe to parse.

    Raises:
        _WktError: If it is nested too deeply, or has curves or solids.
    """
    crs = LOCAL
    if match := _SRID.fullmatch(text):
        crs, text = _crs(int(match[1])), match[2]
    body = _flat(text) if _RARE.search(text) else text
    if body.count("(") > _MAX_NESTING:
        depth = np.cumsum([(c == "(") - (c == ")") for c in body if c in "()"])
        if depth.max(initial=0) > _MAX_NESTING:
            raise _WktError(f"expected at most {_MAX_NESTING} parentheses in each other.")
    return _Body(line, body, crs)


def _crs(code: int) -> Crs:
    # PostGIS writes 0, and earlier -1, for an unknown place.
    return LOCAL if code <= 0 else crs_of_code(code)


def _polygons(shape: shapely.Geometry, name: str) -> tuple[list[Outline], list[Remark]]:
    """The polygons of a geometry, and remarks about what else it has."""
    outlines: list[Outline] = []
    remarks: list[Remark] = []
    for part in _parts(shape):
        if isinstance(part, shapely.Polygon):
            outlines.append(Outline(shapely.force_2d(part), name))
        else:
            kind = type(part).__name__
            empty = "an empty " if shapely.is_empty(part) else "a "
            remarks.append(Remark(name, "geometry", f"expected a polygon, found {empty}{kind}"))
    return outlines, remarks


def _geometries(texts: Sequence[str]) -> Iterator[shapely.Geometry | None]:
    """The geometry of each text, None for one that is not well-formed; a call of shapely takes most of the time."""
    try:
        yield from _parsed(texts, "ignore")
    except _PARSE_ERRORS:
        for text in texts:
            yield None if _fault_of(text) else _parsed([text], "raise")[0]


def _fault_of(text: str) -> str:
    """Why a text is not well-formed; empty if it is."""
    try:
        _parsed([text], "raise")
    except _PARSE_ERRORS as error:
        return f"this is not well-formed WKT ({error})"
    return ""


def _parsed(texts: Sequence[str], on_invalid: Literal["ignore", "raise"]) -> NDArray[np.object_]:
    with np.errstate(invalid="ignore", over="ignore"):  # not-a-number is reported later
        return shapely.from_wkt(np.array(texts, dtype=object), on_invalid=on_invalid)


def _parts(shape: shapely.Geometry) -> list[shapely.Geometry]:
    """The simple geometries of a geometry; its nesting is bounded."""
    if shapely.is_empty(shape) or not isinstance(shape, shapely.GeometryCollection | shapely.MultiPolygon):
        return [shape]
    return [part for member in shape.geoms for part in _parts(member)]


def _flat(text: str) -> str:
    """WKT of plain polygons instead of surfaces whose rings are plain.

    Raises:
        _WktError: If rings have arcs, or are faces of a solid.
    """
    if match := _CURVES.search(text):
        raise _WktError(
            f"{match[0].upper()} has arcs, and an outline has straight edges. Replace them by edges: "
            "ST_CurveToLine(geom) in PostGIS, ogr2ogr -nlt CONVERT_TO_LINEAR for files."
        )
    if match := _SOLIDS.search(text):
        raise _WktError(f"{match[0].upper()} has faces in space; expected a POLYGON on the ground.")
    text = re.sub("CURVEPOLYGON", "POLYGON", text, flags=re.IGNORECASE)
    surfaces = [*re.finditer("MULTISURFACE", text, re.IGNORECASE)]
    if len(surfaces) > _MAX_SURFACES:
        raise _WktError(f"expected at most {_MAX_SURFACES} MULTISURFACE.")
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
