"""Elements from a file of any kind, chosen by its ending."""

from __future__ import annotations

from pathlib import Path

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.templates.elements import Elements, check
from grammarlab.facade.templates.reading.boxes import cut_out, find_boxes, read_boxes
from grammarlab.facade.templates.reading.document import load_arrays, loads
from grammarlab.facade.templates.reading.scan import MESHES, SCANS, read_surface
from grammarlab.facade.values import read_bounded

DOCUMENTS = (".json", ".npz")
_MOST_BYTES = 1 << 30


def load_elements(path: Path, boxes: Path | None = None) -> Elements:
    """The elements of a file.

    Args:
        path: elements, or a scan or mesh of one facade.
        boxes: CSV file of boxes on a scan or mesh, in metres on the facade; found when left out.

    Raises:
        FacadeError: for content that cannot be used: what is wrong, and where.
        UsageError: for an ending that is not known, and boxes of a file that has its own.
    """
    ending = path.suffix.lower()
    if ending not in (*DOCUMENTS, *MESHES, *SCANS):
        raise UsageError(f"{path.name!r}: expected a file that ends in {', '.join((*DOCUMENTS, *MESHES, *SCANS))}.")
    if ending in DOCUMENTS:
        if boxes is not None:
            raise UsageError("--boxes: a file of elements has boxes of its own.")
        reader = loads if ending == ".json" else load_arrays
        try:
            return reader(read_bounded(path, _MOST_BYTES))
        except FacadeError as error:
            raise FacadeError(f"{path.name}: {error}") from error
    surface = read_surface(path)
    found, outline = find_boxes(surface)
    if boxes is not None:
        found = read_boxes(read_bounded(boxes))
    notes = (f"{len(found)} boxes {'were found' if boxes is None else 'are given'} on the facade",)
    return check(cut_out(outline, found, notes))
