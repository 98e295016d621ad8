"""Parcels of a map: every feature once, by its id, as usable or with the reason why not.

A bad outline never stops a file. Neither the order of the rows nor the format of the map matter.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city import parcel_reasons
from grammarlab.city.drawn_edges import first_edges
from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.city.parcel_ids import identities, part_ids
from grammarlab.city.parcel_outlines import Pieces, pieces_of
from grammarlab.city.parcel_overlaps import Disjoint, disjoint
from grammarlab.city.parcels import Parcels
from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.coordinates import UNPLACED, MetricSystem, check_sizes, metric_system, transformed
from grammarlab.geometry.footprints.crs import label
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.geometry.footprints.map_file import read_layer, split_layer
from grammarlab.geometry.footprints.map_layer import MapLayer

ID = "id"
"""Name of the attribute of maps that have no attributes."""
_AREAS = [shapely.GeometryType[kind].value for kind in ("POLYGON", "MULTIPOLYGON", "GEOMETRYCOLLECTION")]
_MIN_AREA, _MIN_SIDE = 30.0, 2.0
"""Square metres and metres of the smallest parcel."""
_STREET_AREA, _STREET_COMPACTNESS = 500.0, 0.1
"""Square metres and 4πA/P² of parcels that are streets."""


@dataclass(frozen=True, eq=False)
class ParcelMap:
    """What a map of parcels says."""

    parcels: Parcels
    """All features, each at least once: the parts of a feature are parcels of their own."""
    remarks: tuple[Remark, ...] = ()
    """About the map as a whole: its coordinates, ids and repairs. What is wrong with one parcel is its reason."""


def read_parcels(
    path: str | Path,
    *,
    crs: str | None = None,
    id_field: str | None = None,
    layer: str | None = None,
    frame: Frame | None = None,
) -> ParcelMap:
    """The parcels of a map, in the order of their ids.

    Args:
        path: file of GeoJSON, GeoPackage, Shapefile (also zipped), FlatGeobuf or CityJSON; ``:LAYER`` may follow.
        crs: coordinate reference system of the coordinates, instead of the file's; ``local`` for metres at an unknown
            place.
        id_field: attribute with the ids; None for a usual one (`grammarlab.city.parcel_ids.USUAL_FIELDS`).
        layer: layer of the file, if it has several.
        frame: frame of an earlier reading, so that the same parcels have the same coordinates; None for a new one
            around their middle.

    Raises:
        AssetError: If the file is missing, broken or too large, if its coordinates cannot be those of parcels, or none
            of its features is an outline.
        UsageError: If the layer or the attribute is unknown, or the extra ``city`` is missing.
    """
    file, suffix = split_layer(str(path)) or (Path(path), None)
    # The layer is handed over: its outlines need not stay until the parcels are finished.
    return _parcels(read_layer(file, layer or suffix), crs, id_field, frame)


def _parcels(layer: MapLayer, crs: str | None, id_field: str | None, frame: Frame | None) -> ParcelMap:
    name = layer.name
    try:
        system, pieces = _pieces(layer, crs, frame)
        attributes, remarks = layer.attributes, [*layer.remarks, *_remarks(layer, crs, system, pieces)]
        del layer
        ids = identities(attributes, pieces.key, id_field, name)
        order, names = _order(pieces, ids.id)
        reason, separate = _reasons(pieces, ids.id, order)
    except AssetError as error:
        raise AssetError(f"{name}: {str(error).removeprefix(f'{name}: ').rstrip('.')}.") from error
    if frame is None:
        frame = Frame.around(system.target, _middles(pieces))
    if not attributes.num_columns:
        attributes = pa.table({ID: ids.id.tolist()})
    outlines, first_edge = _in_frame(separate.outlines, frame)
    parcels = Parcels(
        frame=frame,
        id=names,
        outlines=outlines,
        elevation=pieces.elevation[order],
        attributes=attributes.take(pieces.feature[order]).combine_chunks(),
        first_edge=np.where(separate.is_cut, np.int32(0), first_edge),
        reason=reason,
    )
    return ParcelMap(parcels, (*remarks, *ids.remarks))


def _pieces(layer: MapLayer, crs: str | None, frame: Frame | None) -> tuple[MetricSystem, Pieces]:
    """The polygons of a layer in metres, and their system.

    Raises:
        AssetError: If the coordinates cannot be those of parcels, or no outline can be used.
    """
    centres = _centres(layer)
    system = metric_system(_definition(layer, crs, centres), centres)
    pieces = pieces_of(layer.blocks(), _projection(system, frame), system.height_unit)
    if not pieces.usable.any():
        counts = Counter(pieces.reason)
        raise AssetError(f"no outline can be used: {', '.join(f'{n:,} {reason}' for reason, n in counts.items())}")
    check_sizes(pieces.outlines.area[pieces.usable], system.source)
    return system, pieces


def _middles(pieces: Pieces) -> Floats:
    """[n, 2] centroids of the usable outlines."""
    centroids = [shapely.get_coordinates(shapely.centroid(outline)) for _, outline in _usable(pieces).blocks()]
    return np.concatenate([np.zeros((0, 2)), *centroids])


def _usable(pieces: Pieces) -> PackedOutlines:
    return pieces.outlines.take(np.flatnonzero(pieces.usable))


def _in_frame(outlines: PackedOutlines, frame: Frame) -> tuple[PackedOutlines, NDArray[np.int32]]:
    """[P] outlines from the origin of a frame, drawn in one way: counter-clockwise from the lowest leftmost corner.

    The second result is [P] which edge was drawn first.

    Shapefiles turn rings around, and the same outline should be the same building however it was drawn. The origin
    comes off last, and exactly: all that was computed before does not depend on it.
    """
    parts, first = list[PackedOutlines](), [np.zeros(0, np.int32)]
    for _, drawn in outlines.blocks():
        parts.append(PackedOutlines.of(shapely.reverse(shapely.normalize(drawn))))
        first.append(first_edges(drawn, parts[-1]))
    packed = PackedOutlines.concatenate(parts)
    return replace(packed, points=packed.points - np.array(frame.origin)), np.concatenate(first)


def _centres(layer: MapLayer) -> Floats:
    """[n, 2] centres of the boxes of all features with polygons, in the coordinates of the file.

    Raises:
        AssetError: If there is none.
    """
    areas = (block[np.isin(shapely.get_type_id(block), _AREAS)] for block in layer.blocks())
    bounds = np.concatenate([np.zeros((0, 4)), *(shapely.bounds(block) for block in areas)])
    centres = (bounds[:, :2] + bounds[:, 2:]) / 2
    centres = centres[np.isfinite(centres).all(axis=1)]
    if len(centres) == 0:
        raise AssetError(f"expected polygons, found none in {len(layer):,} features")
    return centres


def _definition(layer: MapLayer, crs: str | None, centres: Floats) -> str:
    """The coordinate reference system of a layer.

    Raises:
        AssetError: If neither the file nor the caller says.
    """
    if crs is not None:
        return crs
    if layer.crs is not None:
        return layer.crs
    x, y = np.median(np.abs(centres), axis=0).tolist()  # a wrong outline is no reason to refuse the others
    if layer.default_crs and x <= 180.0 and y <= 90.0:
        return layer.default_crs
    x, y = np.median(centres, axis=0).tolist()
    raise AssetError(
        f"it does not name its coordinate reference system, and its middle is x = {x:.10g}, y = {y:.10g}. Name it: "
        f'crs = "EPSG:…", or "{UNPLACED}" for metres at an unknown place'
    )


def _projection(system: MetricSystem, frame: Frame | None) -> Callable[[Floats], Floats]:
    """The way to the metres of a system, or to those of a given frame.

    Raises:
        AssetError: If the place of only one of them is known.
    """
    if frame is None or frame.crs == system.target:
        return system.metres
    if not frame.crs or not system.target:
        raise AssetError("its place on the earth is known and that of its frame is not, or the other way round")
    target = frame.crs
    return lambda points: transformed(points, system.source, target)


def _order(pieces: Pieces, ids: NDArray[np.object_]) -> tuple[Ints, NDArray[np.object_]]:
    """Rows of pieces in the order of their ids, and these ids."""
    names = part_ids(ids, np.bincount(pieces.feature, minlength=len(ids)))
    order = np.argsort(names, kind="stable")
    return order, names[order]


def _reasons(pieces: Pieces, ids: NDArray[np.object_], order: Ints) -> tuple[NDArray[np.object_], Disjoint]:
    """Reasons and outlines without overlaps of pieces in the order of their ids."""
    reason, outlines = pieces.reason[order], pieces.outlines.take(order)
    is_copy = _is_copy(ids, pieces.key)[pieces.feature[order]]
    reason[is_copy & (reason == "")] = parcel_reasons.DUPLICATE
    rows = np.flatnonzero(reason == "")
    separate = disjoint(outlines, rows)
    shapes = np.concatenate(
        [np.zeros(0, object), *(_unbuildable(outline) for _, outline in separate.outlines.take(rows).blocks())]
    )
    reason[rows] = np.where(separate.is_covered[rows], parcel_reasons.OVERLAP, shapes)
    return reason, separate


def _is_copy(ids: NDArray[np.object_], keys: Sequence[bytes]) -> NDArray[np.bool_]:
    """[N] whether a feature with a smaller id has the same outlines."""
    is_copy = np.zeros(len(ids), dtype=np.bool_)
    seen: set[bytes] = set()
    for row in np.argsort(ids, kind="stable"):
        is_copy[row] = keys[row] in seen
        seen.add(keys[row])
    return is_copy


def _remarks(layer: MapLayer, crs: str | None, system: MetricSystem, pieces: Pieces) -> list[Remark]:
    remarks = []
    if crs is not None and layer.crs is not None and crs != layer.crs:
        remarks.append(f"crs = {crs} is used instead of {label(layer.crs)}, which the file names")
    if system.note:
        remarks.append(system.note)
    remarks = [Remark(layer.name, "coordinates", reason) for reason in remarks]
    if pieces.num_repaired:
        remarks.append(Remark(layer.name, "repair", f"{pieces.num_repaired:,} outlines cross themselves: repaired"))
    if pieces.num_slivers:
        reason = f"{pieces.num_slivers:,} parts of less than 1 m² are left out: their parcels have larger ones"
        remarks.append(Remark(layer.name, "outline", reason))
    return remarks


def _unbuildable(outline: Outlines) -> NDArray[np.object_]:
    """[N] why nothing can be built inside valid outlines because of their shapes; empty for the others."""
    reason = np.full(len(outline), "", dtype=object)
    area = shapely.area(outline)
    with np.errstate(divide="ignore", invalid="ignore"):
        compactness = 4 * np.pi * area / shapely.length(outline) ** 2
    reason[_is_narrow(outline, area)] = parcel_reasons.NARROW
    reason[area < _MIN_AREA] = parcel_reasons.SMALL
    reason[(compactness < _STREET_COMPACTNESS) & (area > _STREET_AREA)] = parcel_reasons.STREET
    return reason


def _is_narrow(outline: Outlines, area: Floats) -> Flags:
    """[N] whether the smallest box around an outline has a side below `_MIN_SIDE`."""
    bounds = shapely.bounds(outline)
    diagonal = np.hypot(bounds[:, 2] - bounds[:, 0], bounds[:, 3] - bounds[:, 1])
    # The box is no longer than the diagonal, so a larger area has a wider box.
    rows = np.flatnonzero((area > 0) & (area < _MIN_SIDE * diagonal))
    narrow = np.zeros(len(outline), dtype=np.bool_)
    corners = [shapely.get_coordinates(box)[:3] for box in shapely.oriented_envelope(outline[rows])]
    for row, corner in zip(rows, corners, strict=True):
        sides = np.hypot(*np.diff(corner, axis=0).T) if len(corner) == 3 else np.zeros(1)
        narrow[row] = sides.min() < _MIN_SIDE
    return narrow
