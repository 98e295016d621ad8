"""Elements from a file of any kind, by its suffix."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.values import UNITS, parse_json, read_bounded
from grammarlab.files import open_regular
from grammarlab.matching.elements import Elements, check
from grammarlab.matching.evidence_maps import FINEST
from grammarlab.matching.scans.element_files import FORMAT, load_arrays, loads
from grammarlab.matching.scans.scan import MESHES, SCANS, read_surfaces
from grammarlab.matching.scans.scan_boxes import FoundBoxes, cut_out, find_boxes, read_boxes

DOCUMENTS = (".json", ".npz")
_MAX_BYTES = 1 << 30
"""Largest size of a file of elements."""
_HEAD_BYTES = 1 << 16
"""Largest size of the head of a PLY file."""
_MAX_SIZE_M = 1_000.0
"""Largest size of a facade, metres."""


def is_elements(path: Path) -> bool:
    """Whether a file has elements or a scan, rather than a facade or a mesh of a building."""
    ending = path.suffix.lower()
    if ending == ".ply":
        return not _has_faces(path)
    if ending != ".json":
        return ending in (".npz", *SCANS)
    try:
        document = parse_json(read_bounded(path, _MAX_BYTES))
    except FacadeError:
        return False
    return isinstance(document, dict) and (document.get("format", FORMAT) == FORMAT) and "elements" in document


def _has_faces(path: Path) -> bool:
    """Whether a PLY file is a mesh, by its head.

    Raises:
        AssetError: If it is a pipe or a device.
    """
    with open_regular(path) as file:
        head = file.read(_HEAD_BYTES).partition(b"end_header")[0]
    return re.search(rb"element\s+face\s+[1-9]", head) is not None


def load_elements(path: Path, boxes: Path | None = None, unit: str = "m", up: str = "") -> Elements:
    """The elements of a file.

    Args:
        path: file of elements, or a scan or mesh of one facade.
        boxes: CSV file of boxes on a scan or mesh, in metres on the facade; boxes are detected if left out.
        unit: unit of the coordinates of a scan or mesh: a key of `UNITS`.
        up: up axis of a scan or mesh: a key of `UP_AXES`; detected if empty.

    Raises:
        FacadeError: If the content is invalid; with the position of the mistake.
        UsageError: If the suffix is unknown, or boxes, a unit or an axis are given for a file that defines them.
    """
    ending = path.suffix.lower()
    if ending not in (*DOCUMENTS, *MESHES, *SCANS):
        raise UsageError(f"{path.name!r}: expected the suffix {', '.join((*DOCUMENTS, *MESHES, *SCANS))}.")
    if ending in DOCUMENTS:
        if boxes is not None:
            raise UsageError("`boxes=`: a file of elements has boxes of its own.")
        if unit != "m" or up:
            raise UsageError("`unit=`, `up=`: a file of elements is in metres, with y up.")
        reader = loads if ending == ".json" else load_arrays
        content = read_bounded(path, _MAX_BYTES)
        try:
            return reader(content)
        except FacadeError as error:
            raise FacadeError(f"{path.name}: {error}") from error
    return check(_on_facade(path, None if boxes is None else read_boxes(read_bounded(boxes)), unit, up))


def _on_facade(path: Path, boxes: Floats | None, unit: str, up: str) -> Elements:
    """The elements of the first facade of a scan or mesh that has any."""
    size = np.zeros(2)
    for axis, surface in read_surfaces(path, UNITS[unit], up):
        detection = find_boxes(surface)
        notes = () if up else (f"{axis} is taken as the up axis; give `up=` if another one is",)
        size = np.maximum(size, np.ptp(surface.points[:, :2], axis=0))
        if boxes is None and len(detection.box):
            of_these = f", {detection.num_repeated} of them by repetition" if detection.num_repeated else ""
            return _cut_out(
                detection, detection.box, f"{len(detection.box)} boxes were found on the facade{of_these}", *notes
            )
        if boxes is not None:
            elements = _cut_out(detection, boxes, f"{len(boxes)} boxes are given on the facade", *notes)
            if elements.counts.any():
                return elements
    where = f"{path.name}: its points span {size[0]:.3g} x {size[1]:.3g} m. "
    if size.max() > _MAX_SIZE_M:
        where += "Expected metres; the unit may be the millimetre (`unit='mm'`). "
    if boxes is None:
        raise FacadeError(
            f"{where}No element was found on the facade: expected holes of 0.25 to 6 m, parts at least 4 cm in "
            "front of or behind the wall, or at least four equal flatter parts in rows or columns. Use `boxes=`."
        )
    raise FacadeError(
        f"{where}No outline lies in any of the boxes. Coordinates are metres from the left end of the wall, and "
        "the height z; outlines are the borders of holes and of parts in front of or behind the wall."
    )


def _cut_out(detection: FoundBoxes, boxes: Floats, *notes: str) -> Elements:
    """The points of each box, with notes."""
    return cut_out(
        detection.outline, boxes, detection.spacing, tuple(filter(None, (*notes, _coarse(detection.spacing))))
    )


def _coarse(spacing: float) -> str:
    """A note if the points of a scan are too far apart for the steps in which sizes are compared."""
    if spacing / 2.0 <= FINEST:
        return ""
    return (
        f"the points of the wall are about {100.0 * spacing:.1f} cm apart: kinds and templates that differ by less "
        "than half of that may be confused"
    )
