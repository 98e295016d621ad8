"""Terrain: heights of the ground from a raster in a GeoTIFF file, read in windows."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.errors import AssetError, UsageError
from grammarlab.extras import named_extras
from grammarlab.files import open_regular
from grammarlab.geometry.footprints.coordinates import UNPLACED, height_unit, horizontal, transformed
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.printable import printable

if TYPE_CHECKING:
    from rasterio import DatasetReader

_WINDOW = 1024
"""Pixels of a side of a window."""
_MAX_BLOCK_BYTES = 512 << 20
"""Largest block of a file, which is unpacked as a whole: a strip of a raster that is not tiled."""
_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
"""First bytes of TIFF and BigTIFF."""
_METRES = {
    "": 1.0,
    "m": 1.0,
    "metre": 1.0,
    "meter": 1.0,
    "metres": 1.0,
    "meters": 1.0,
    "cm": 0.01,
    "ft": 0.3048,
    "foot": 0.3048,
    "feet": 0.3048,
    "us survey foot": 1200 / 3937,
    "us-ft": 1200 / 3937,
    "ftus": 1200 / 3937,
}
"""Metres per unit of height by its name in a file."""
_HEIGHTS = (-500.0, 9_000.0)
"""Metres between which land lies; other heights, such as -9999, are those of missing values."""


@dataclass(frozen=True, slots=True)
class Terrain:
    """Heights of the ground at points, in metres above the zero of its file: in most files the mean sea."""

    path: Path
    """GeoTIFF file; it is opened for each call of `heights`, so that workers share nothing."""
    crs: str
    """Definition of its coordinate reference system; empty if it is that of all frames."""
    size: tuple[int, int]
    """Pixels across and down."""
    affine: tuple[float, float, float, float, float, float]
    """a, b, c, d, e, f: pixel (column, row) has its upper left corner at x = a column + b row + c, y = d column + e row
    + f."""
    nodata: float | None
    """Value of pixels without a height, in the units of the file."""
    scale: float
    """Metres per unit of the values of the file."""
    offset: float
    """Metres of a value of zero."""

    def heights(self, frame: Frame, east_north: Floats) -> Floats:
        """[n] heights in metres at points, bilinear between the middles of pixels; NaN outside and where there is none.

        Args:
            frame: frame of the points.
            east_north: [n, 2] metres to the east and to the north of the frame's origin.

        Raises:
            AssetError: If the file cannot be read any more.
            UsageError: If the extra ``city`` is missing, or the place of the frame is unknown and that of the file is
                not.
        """
        pixels = self._pixels(frame, east_north)
        heights = np.full(len(pixels), np.nan)
        inside = np.flatnonzero(_is_inside(pixels, self.size))
        if len(inside) == 0:
            return heights
        pixels = pixels[inside]
        # The middle of the first pixel is at 0.5; beyond the outer middles, heights go on level.
        low = np.clip(np.floor(pixels - 0.5), 0, np.maximum(np.array(self.size) - 2, 0)).astype(np.int64)
        share = np.clip(pixels - 0.5 - low, 0.0, 1.0)
        with _opened(self.path) as raster:
            if (raster.width, raster.height) != self.size:
                raise AssetError(f"{self.path}: the raster has changed since it was opened.")
            for rows, window in _windows(low):
                corners = self._corners(raster, window, low[rows])
                heights[inside[rows]] = _between(corners, share[rows])
        return heights

    def _pixels(self, frame: Frame, east_north: Floats) -> Floats:
        """[n, 2] columns and rows of points, with fractions."""
        points = east_north + np.array(frame.origin)
        if self.crs and not frame.has_place:
            raise UsageError(f"{self.path}: it has a place on the earth, and the map has none: name its crs.")
        if self.crs and self.crs != frame.crs:
            points = transformed(points, frame.crs, self.crs)
        a, b, c, d, e, f = self.affine
        with np.errstate(invalid="ignore"):
            x, y = points[:, 0] - c, points[:, 1] - f
            return np.column_stack([e * x - b * y, a * y - d * x]) / (a * e - b * d)

    def _corners(self, raster: DatasetReader, window: tuple[int, int, int, int], low: Ints) -> Floats:
        """[n, 2, 2] heights of the four pixels around points, NaN without one; rows before columns.

        Args:
            raster: the open file.
            window: first column and row, and number of columns and rows, to read.
            low: [n, 2] column and row of the upper left pixel of each point.
        """
        with named_extras():
            from rasterio.errors import RasterioError  # noqa: PLC0415  # an extra
            from rasterio.windows import Window  # noqa: PLC0415
        try:
            values = raster.read(1, window=Window(*window)).astype(np.float64)  # ty: ignore[too-many-positional-arguments]  # pyright: ignore[reportCallIssue]  # attrs
        except (RasterioError, OSError, ValueError, MemoryError) as error:
            raise AssetError(f"{self.path}: the raster is broken: {printable(str(error))[:200]}.") from error
        if self.nodata is not None:
            values[values == self.nodata] = np.nan
        values = values * self.scale + self.offset
        with np.errstate(invalid="ignore"):
            values[~((values >= _HEIGHTS[0]) & (values <= _HEIGHTS[1]))] = np.nan
        column, row = (low - np.array(window[:2])).T
        right, below = np.minimum(column + 1, values.shape[1] - 1), np.minimum(row + 1, values.shape[0] - 1)
        return np.stack(
            [
                np.stack([values[row, column], values[row, right]], axis=-1),
                np.stack([values[below, column], values[below, right]], axis=-1),
            ],
            axis=-2,
        )


def read_terrain(path: str | Path, *, crs: str | None = None, default_crs: str | None = None) -> Terrain:
    """The terrain of a GeoTIFF file: the first band of its raster.

    Args:
        path: the file.
        crs: coordinate reference system instead of the file's; ``local`` for that of the frame.
        default_crs: the system of a file that names none.

    Raises:
        AssetError: If it is missing, not a GeoTIFF file with heights, or its blocks are too large; if it does not name
            its system.
        UsageError: If the extra ``city`` is missing.
    """
    path = Path(path)
    if not path.is_file():
        raise AssetError(f"{path}: no such terrain: expected a GeoTIFF file.")
    with open_regular(path) as file:
        if file.read(4) not in _TIFF:
            raise AssetError(f"{path}: expected a GeoTIFF file.")
    with _opened(path) as raster:
        _check(path, raster)
        a, b, c, d, e, f = raster.transform[:6]
        definition = _definition(path, raster, crs, default_crs)
        try:
            system = "" if definition == UNPLACED else horizontal(definition)
            unit = _unit(path, raster, definition)
        except AssetError as error:
            raise AssetError(f"{path}: {str(error).removeprefix(f'{path}: ').rstrip('.')}.") from error
        nodata = raster.nodata
        return Terrain(
            path=path,
            crs=system,
            size=(raster.width, raster.height),
            affine=(a, b, c, d, e, f),
            nodata=None if nodata is None or math.isnan(nodata) else float(nodata),
            scale=float(raster.scales[0]) * unit,
            offset=float(raster.offsets[0]) * unit,
        )


@contextmanager
def _opened(path: Path) -> Iterator[DatasetReader]:
    """The raster of a file.

    Raises:
        AssetError: If it cannot be opened.
        UsageError: If the extra ``city`` is missing.
    """
    with named_extras():
        import rasterio  # noqa: PLC0415  # an extra
        from rasterio.errors import RasterioError  # noqa: PLC0415
    try:
        # The driver by name: others follow references to other files. No look at the files beside it.
        with warnings.catch_warnings(), rasterio.Env(GDAL_DISABLE_READDIR_ON_OPEN="EMPTY_DIR"):
            warnings.simplefilter("ignore")
            raster = rasterio.open(path.resolve(), driver="GTiff")
    except (RasterioError, OSError, ValueError) as error:
        raise AssetError(f"{path}: the raster is broken: {printable(str(error))[:200]}.") from error
    with raster:
        yield raster


def _check(path: Path, raster: DatasetReader) -> None:
    """Refuse rasters that have no place or are too large to read."""
    columns, rows = raster.block_shapes[0]
    kind = np.dtype(raster.dtypes[0])
    if kind.kind not in "iuf":
        raise AssetError(f"{path}: expected heights, found values of type {kind}.")
    if raster.count >= 3 and kind == np.uint8:
        raise AssetError(f"{path}: expected heights, found a picture of {raster.count} bands.")
    if columns * rows * kind.itemsize * max(raster.count, 1) > _MAX_BLOCK_BYTES:
        raise AssetError(
            f"{path}: its blocks of {rows} x {columns} pixels are too large to read: tile it, "
            "gdal_translate -co TILED=YES -co COMPRESS=DEFLATE OLD NEW"
        )
    a, b, _, d, e, _ = raster.transform[:6]
    if raster.transform.is_identity or not math.isfinite(a * e - b * d) or a * e == b * d:
        raise AssetError(f"{path}: it does not say where it is (no world coordinates of its pixels).")


def _definition(path: Path, raster: DatasetReader, crs: str | None, default_crs: str | None) -> str:
    """Definition of the system of a raster.

    Raises:
        AssetError: If neither the file nor the caller says.
    """
    if crs is not None:
        return crs
    if raster.crs is None and default_crs is not None:
        return default_crs
    if raster.crs is None:
        raise AssetError(f'{path}: it does not name its coordinate reference system. Name it: crs = "EPSG:…".')
    return str(raster.crs.to_wkt())


def _unit(path: Path, raster: DatasetReader, definition: str) -> float:
    """Metres per unit of height: that of the band, otherwise that of a system with heights, otherwise metres."""
    name = (raster.units[0] or "").strip().lower()
    if name not in _METRES:
        raise AssetError(f"{path}: expected heights in metres or feet, found {printable(name)[:40]!r}.")
    return _METRES[name] if name or definition == UNPLACED else height_unit(definition)


def _is_inside(pixels: Floats, size: tuple[int, int]) -> Flags:
    """[n] whether points are on the raster."""
    with np.errstate(invalid="ignore"):
        return np.all((pixels >= 0) & (pixels <= np.array(size)), axis=1)


def _windows(low: Ints) -> Iterator[tuple[Ints, tuple[int, int, int, int]]]:
    """Rows of points with upper left pixels [n, 2] in one window, and the smallest window with their four pixels."""
    tiles = low // _WINDOW
    order = np.lexsort((tiles[:, 0], tiles[:, 1]))
    starts = np.flatnonzero((np.diff(tiles[order], axis=0, prepend=-1) != 0).any(axis=1))
    for start, end in zip(starts, np.append(starts[1:], len(order)), strict=True):
        rows = order[start:end]
        first, last = low[rows].min(axis=0), low[rows].max(axis=0) + 2
        column, row, right, below = (*first.tolist(), *last.tolist())
        yield rows, (column, row, right - column, below - row)


def _between(corners: Floats, share: Floats) -> Floats:
    """[n] bilinear means of corners [n, 2, 2]; those that are NaN count nothing, unless the point is on them alone.

    Args:
        corners: heights, rows before columns.
        share: [n, 2] position between the columns and between the rows, 0 to 1.
    """
    column = np.stack([1 - share[:, 0], share[:, 0]], axis=-1)
    row = np.stack([1 - share[:, 1], share[:, 1]], axis=-1)
    weights = row[:, :, None] * column[:, None, :] * np.isfinite(corners)
    total = weights.sum(axis=(1, 2))
    with np.errstate(invalid="ignore", divide="ignore"):
        return (weights * np.nan_to_num(corners)).sum(axis=(1, 2)) / total
