"""Layers of GeoPackages, Shapefiles and FlatGeobuf files, by GDAL.

GDAL chooses a driver by the content of a file, and some drivers follow references to other files or run commands. So
the first bytes must be those of the format that the name says.
"""

from __future__ import annotations

import sqlite3
import warnings
import zipfile
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pyarrow as pa
import shapely
from numpy.typing import NDArray

from grammarlab.errors import AssetError, UsageError
from grammarlab.extras import named_extras
from grammarlab.files import open_regular
from grammarlab.geometry.footprints.attribute_columns import NOT_USED, Columns, plain_columns, united
from grammarlab.geometry.footprints.crs import label
from grammarlab.geometry.footprints.curved_wkb import straightened
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.geometry.footprints.map_layer import MAX_FEATURES, MAX_MAP_BYTES, MapLayer, bodies_of
from grammarlab.printable import printable

_BATCH = 8192
"""Features that are read at a time."""
_HEAD_BYTES = 72
_MOST_REMARKS = 8
"""Largest number of warnings of GDAL that are repeated."""
_MAX_ZIPPED_FILES = 10_000
_NO_PATH = "!;?"
"""Letters that the names of files cannot have, since they mean something in GDAL's names."""
_OUTLINES = ("Polygon", "Surface", "Collection", "Unknown")
"""Parts of the names of kinds of geometry that may be outlines."""
_DRAWINGS = ("ENGCRS", "ENGINEERINGCRS", "LOCAL_CS")
"""Beginnings of systems without a place on the earth."""
_PARTS = (".shp", ".shx", ".dbf", ".prj", ".cpg")
"""Suffixes of the files of a Shapefile that are read."""
_COMPUTED_TABLES = """
SELECT name FROM sqlite_master
WHERE type = 'view' OR (lower(sql) LIKE 'create virtual table%' AND lower(sql) NOT LIKE '% using rtree%')
ORDER BY name LIMIT 8
"""
"""Spatial indices are virtual tables, which are stored."""


def read_vector_layer(path: Path, layer: str | None = None) -> MapLayer:
    """The features of a layer, in the coordinates of the file.

    Args:
        path: a file ``.gpkg``, ``.fgb``, ``.shp``, or ``.zip`` with Shapefiles.
        layer: name of the layer; None for the only one, or the only one with polygons.

    Raises:
        AssetError: If the file is broken, too large, or not what its name says.
        UsageError: If there are several layers, or none of this name; if the extra ``city`` is missing.
    """
    with named_extras():
        from pyogrio.errors import DataSourceError  # noqa: PLC0415  # an extra
    _check_content(path)
    try:
        with warnings.catch_warnings(record=True) as messages:
            warnings.simplefilter("always")
            source, name = _source(path, layer)
            read = _read(path, source, name)
    # A definition that is not text ends in an unset variable inside pyogrio.
    except (DataSourceError, OSError, RuntimeError, ValueError, pa.ArrowException, UnboundLocalError) as error:
        raise AssetError(f"{path}: this file is broken: {printable(str(error))[:400]}.") from error
    texts = sorted({printable(str(message.message))[:200] for message in messages})
    remarks = [Remark(str(path), "record", text) for text in texts[:_MOST_REMARKS]]
    if read.unread:
        names = ", ".join(sorted(read.unread)[:8])
        remarks.append(Remark(str(path), "property", f"{NOT_USED}: {names}"))
    return MapLayer(
        name=str(path) if layer is None else f"{path}:{layer}",
        bodies=read.bodies,
        attributes=united(read.columns, [len(chunk) for chunk in read.bodies]),
        crs=read.crs,
        remarks=tuple(remarks),
    )


class _Read:
    """What has been read of a layer."""

    def __init__(self, crs: str | None) -> None:
        self.crs = crs
        self.bodies: list[pa.Array] = []
        self.columns: list[Columns] = []
        self.unread: set[str] = set()


def _read(path: Path, source: str, layer: str) -> _Read:
    with named_extras():
        from pyogrio.raw import open_arrow  # noqa: PLC0415  # an extra
    options = {"layer": layer, "batch_size": _BATCH, "datetime_as_string": True, "use_pyarrow": True}
    with open_arrow(source, **options) as (meta, reader):
        read = _Read(_placed(meta["crs"]))
        geometry_name = meta["geometry_name"] or "wkb_geometry"
        num_features = 0
        for batch in reader:
            num_features += len(batch)
            if num_features > MAX_FEATURES:
                raise AssetError(f"{path}: expected at most {MAX_FEATURES:,} features. Cut out a smaller area.")
            index = batch.schema.get_field_index(geometry_name)
            if index < 0:
                raise UsageError(f"{path}: layer {layer!r} has no outlines. {_listing(path, source)}")
            bodies = batch.column(index).to_numpy(zero_copy_only=False)
            read.bodies.append(bodies_of(_geometries(bodies)))
            columns, unread = plain_columns(batch.drop_columns([geometry_name]))
            read.columns.append(columns)
            read.unread |= unread
    return read


def _geometries(bodies: NDArray[np.object_]) -> NDArray[np.object_]:
    """[n] geometries of well-known binary [n], None for those that cannot be read."""
    # Shapely raises NotImplementedError for kinds of geometry that it has no class for, such as arcs.
    try:
        return shapely.from_wkb(bodies, on_invalid="ignore")
    except (shapely.errors.ShapelyError, NotImplementedError):
        geometry = np.full(len(bodies), None, dtype=object)
        for row, body in enumerate(bodies):
            if body is not None:
                geometry[row] = _geometry(body)
        return geometry


def _geometry(body: bytes) -> shapely.Geometry | None:
    # As above, for one geometry; arcs, for which Shapely has no class, become edges.
    try:
        return shapely.from_wkb(body, on_invalid="ignore")
    except (shapely.errors.ShapelyError, NotImplementedError):
        return straightened(body)


def _placed(crs: str | None) -> str | None:
    """The definition of a system; None for those of GeoPackages that say that they are undefined, and of drawings."""
    if not crs or label(crs).lower().startswith("undefined") or crs.startswith(_DRAWINGS):
        return None
    return crs


def _source(path: Path, layer: str | None) -> tuple[str, str]:
    """GDAL's name of a file, and the name of the layer to read."""
    if path.suffix.lower() == ".zip":
        return _zipped_source(path, layer)
    source = str(path.resolve())
    if any(letter in source for letter in _NO_PATH):
        raise UsageError(f"{path}: the names of maps and of their folders cannot have any of {_NO_PATH}: rename them.")
    if path.suffix.lower() == ".gpkg":
        _check_tables(path)
    names = _layers(source)
    candidates = [name for name, kind in names if kind is not None and any(word in kind for word in _OUTLINES)]
    if layer is not None:
        if layer not in [name for name, _ in names]:
            raise UsageError(f"{path}: unknown layer {layer[:80]!r}. {_listing(path, source)}")
        return source, layer
    if len(names) == 1:
        return source, names[0][0]
    if len(candidates) != 1:
        raise UsageError(f"{path}: expected one layer of polygons, found {len(candidates)}. {_listing(path, source)}")
    return source, candidates[0]


def _layers(source: str) -> list[tuple[str, str | None]]:
    """Names of the layers of a file, and their kinds of geometry; None for tables without one."""
    with named_extras():
        from pyogrio import list_layers  # noqa: PLC0415  # an extra
    return [(str(name), None if kind is None else str(kind)) for name, kind in list_layers(source)]


def _listing(path: Path, source: str) -> str:
    names = [name for name, _ in _layers(source)]
    shown = ", ".join(repr(printable(name)[:60]) for name in names[:20])
    return f"Its layers are {shown}; name one: {path.name}:LAYER"


def _zipped_source(path: Path, layer: str | None) -> tuple[str, str]:
    """The Shapefile in an archive."""
    # zipfile raises NotImplementedError for archives of a version or a kind of compression that it does not know.
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError) as error:
        raise AssetError(f"{path}: this is not a zip archive: {error}.") from error
    entries = [entry for entry in entries if not entry.filename.startswith("__MACOSX/")]
    size = sum(entry.file_size for entry in entries if entry.filename.lower().endswith(_PARTS))
    if len(entries) > _MAX_ZIPPED_FILES or size > MAX_MAP_BYTES:
        raise AssetError(f"{path}: expected at most {MAX_MAP_BYTES:,} bytes in {_MAX_ZIPPED_FILES:,} files.")
    shapes = {Path(entry.filename).stem: entry.filename for entry in entries if entry.filename.lower().endswith(".shp")}
    if layer is None and len(shapes) == 1:
        layer = next(iter(shapes))
    if layer not in shapes:
        names = ", ".join(repr(printable(name)[:60]) for name in sorted(shapes)[:20]) or "none"
        raise UsageError(
            f"{path}: expected one Shapefile, found {names}. " + (f"Name one: {path.name}:LAYER" if shapes else "")
        )
    if any(letter in str(path) + shapes[layer] for letter in _NO_PATH):
        raise UsageError(f"{path}: the names of maps and of their folders cannot have any of {_NO_PATH}: rename them.")
    return f"/vsizip/{path.resolve()}/{shapes[layer]}", layer


def _check_content(path: Path) -> None:
    """Check that a file is a regular one, not too large, and of the format that its name says.

    Raises:
        AssetError: If it is not.
    """
    with open_regular(path, MAX_MAP_BYTES) as file:
        head = file.read(_HEAD_BYTES)
    suffix = path.suffix.lower()
    if not _is_format(head, suffix):
        raise AssetError(f"{path}: its content is not that of a file {suffix}.")
    if suffix == ".shp":
        for part in _siblings(path, _PARTS):
            with open_regular(part, MAX_MAP_BYTES):
                pass


def _is_format(head: bytes, suffix: str) -> bool:
    if suffix == ".gpkg":
        return head.startswith(b"SQLite format 3\0") and head[68:72] in (b"GPKG", b"GP10", b"GP11")
    beginnings = {".fgb": b"fgb\x03", ".shp": b"\0\0\x27\x0a", ".zip": b"PK"}
    return head.startswith(beginnings[suffix])


def _siblings(path: Path, suffixes: Sequence[str]) -> list[Path]:
    candidates = [path.with_suffix(case(suffix)) for suffix in suffixes for case in (str.lower, str.upper)]
    return [candidate for candidate in candidates if candidate.exists()]


def _check_tables(path: Path) -> None:
    """Check that all tables of a GeoPackage are stored ones: GDAL reads some rows of each.

    What a GeoPackage computes when it is opened is a query of a stranger, which may take for ever.

    Raises:
        AssetError: If some are computed, or the file is broken.
    """
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)) as database:
            names = [str(name) for (name,) in database.execute(_COMPUTED_TABLES)]
    except (sqlite3.Error, UnicodeError) as error:
        raise AssetError(f"{path}: this file is broken: {printable(str(error))[:200]}.") from error
    if names:
        listing = ", ".join(repr(printable(name)[:60]) for name in names)
        raise AssetError(
            f"{path}: expected stored tables, found views, which are computed: {listing}. Copy the layer: "
            f"ogr2ogr NEW.gpkg {path.name} LAYER"
        )
