"""Elements as JSON or NPZ files, with the truth of synthetic scenes; docs/matching/file.md describes the format."""

from __future__ import annotations

import json
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.errors import FacadeError
from grammarlab.facade.values import a_list, a_number, a_text, a_whole_number, an_object, numbers, parse_json
from grammarlab.files import write_bytes, write_text
from grammarlab.matching.elements import MOST_ELEMENTS, MOST_POINTS, Elements, Truth, check

FORMAT = "grammarlab elements"
VERSION = 1
_MARGIN_RATIO = 0.1
"""Margin of a box made from the points of an element, as a fraction of its extent."""
_MAX_KINDS = 10_000
"""Largest number of kinds of a file."""
_MAX_UNPACKED_BYTES = 1 << 31
"""Bytes of all arrays of an NPZ file, which may be packed a thousandfold."""
_COLUMNS = {"offsets": "iu", "points": "iuf", "boxes": "iuf", "row": "iu", "column": "iu", "kind": "iu"}
"""Arrays of an NPZ file, and which kinds of numbers each may have."""
_DTYPES = {"iu": "a list of whole numbers", "iuf": "rows of real numbers"}


def dumps(elements: Elements) -> str:
    """The text of a file, numbers to the last bit."""
    rows = []
    for element in range(len(elements)):
        values: dict[str, Any] = {"box": [*elements.low[element].tolist(), *elements.high[element].tolist()]}
        if elements.row[element] >= 0:
            values["row"] = int(elements.row[element])
        if elements.column[element] >= 0:
            values["column"] = int(elements.column[element])
        if elements.truth is not None:
            values["kind"] = int(elements.truth.kind[element])
        rows.append(json.dumps({**values, "points": elements.points_of(element).tolist()}))
    truth = elements.truth
    kinds = [] if truth is None else list(zip(truth.names, truth.parameters, strict=True))
    kinds_text = json.dumps([{"template": name, "parameters": values} for name, values in kinds])
    joined = ",\n".join(rows)
    return f'{{"format": "{FORMAT}", "version": {VERSION},\n"kinds": {kinds_text},\n"elements": [\n{joined}\n]}}\n'


def save_elements(elements: Elements, path: Path) -> None:
    """Write elements as JSON or as NPZ, by the suffix of the file."""
    if path.suffix.lower() == ".npz":
        buffer = BytesIO()
        columns: dict[str, Any] = {
            "offsets": elements.offsets,
            "points": elements.points,
            "boxes": np.hstack([elements.low, elements.high]),
            "row": elements.row,
            "column": elements.column,
        }
        if elements.truth is not None:
            columns["kind"] = elements.truth.kind
        np.savez_compressed(buffer, **columns)
        write_bytes(path, buffer.getvalue())
    else:
        write_text(path, dumps(elements))


def loads(content: bytes) -> Elements:
    """The elements of a JSON file.

    Raises:
        FacadeError: If it is not such a file; with the position of the mistake.
    """
    document = parse_json(content)
    if isinstance(document, dict) and "format" not in document and "elements" in document:
        document = {**document, "format": FORMAT, "version": VERSION}
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise FacadeError(f'This is not a file of elements: expected an object with "format": "{FORMAT}".')
    if document.get("version") != VERSION:
        raise FacadeError(f"Expected version {VERSION} of the format, found {document.get('version')!r}.")
    entries = a_list(document.get("elements"), "elements", MOST_ELEMENTS)
    if not entries:
        raise FacadeError("There are no elements: expected at least one box with points in it.")
    clouds = [_points(an_object(entry, f"Element {index}"), f"Element {index}") for index, entry in enumerate(entries)]
    width = {cloud.shape[1] for cloud in clouds if len(cloud)}
    if len(width) > 1:
        raise FacadeError("Points: expected 2 coordinates for every point, or 3 for every point.")
    size = width.pop() if width else 2
    points = np.vstack([np.zeros((0, size)), *(cloud for cloud in clouds if len(cloud))])
    boxes = np.array(
        [
            _box(entry, cloud, f"Element {index}")
            for index, (entry, cloud) in enumerate(zip(entries, clouds, strict=True))
        ]
    )
    row, column = (
        np.array([_index(entry, key, f"Element {index}, {key}") for index, entry in enumerate(entries)], dtype=np.int64)
        for key in ("row", "column")
    )
    offsets = offsets_from_counts(np.array([len(cloud) for cloud in clouds], dtype=np.int64))
    truth = _truth(document, entries)
    return check(
        Elements(
            offsets=offsets, points=points, low=boxes[:, :2], high=boxes[:, 2:], row=row, column=column, truth=truth
        )
    )


def _points(values: dict[str, Any], where: str) -> Floats:
    listed = a_list(values.get("points"), f"{where}, points", MOST_POINTS)
    if not listed:
        return np.zeros((0, 2))
    size = len(listed[0]) if isinstance(listed[0], list) and len(listed[0]) in {2, 3} else 2
    try:
        points = np.array(listed, dtype=np.float64)
    except (ValueError, TypeError, OverflowError):
        points = np.zeros(0)
    if points.shape != (len(listed), size) or not np.isfinite(points).all():
        for index, point in enumerate(listed):  # raises with its index
            numbers(point, f"{where}, point {index}", size)
    return points


def _box(values: dict[str, Any], points: Floats, where: str) -> list[float]:
    if "box" in values:
        return numbers(values["box"], f"{where}, box", 4)
    if not len(points):
        return [0.0, 0.0, 1.0, 1.0]
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    room = np.maximum(_MARGIN_RATIO * (high - low), 1e-6)
    return [*(low - room).tolist(), *(high + room).tolist()]


def _index(values: dict[str, Any], key: str, where: str) -> int:
    return a_whole_number(values[key], where, 0, MOST_ELEMENTS) if values.get(key) is not None else -1


def _truth(document: dict[str, Any], entries: list[dict[str, Any]]) -> Truth | None:
    has_kind = ["kind" in entry for entry in entries]
    if not any(has_kind):
        return None
    if not all(has_kind):
        raise FacadeError(f"Element {has_kind.index(False)}: expected a kind, since other elements have one.")
    kind = np.array(
        [a_whole_number(entry["kind"], f"Element {index}, kind", 0, _MAX_KINDS) for index, entry in enumerate(entries)],
        dtype=np.int64,
    )
    kinds = [an_object(definition, "kinds") for definition in a_list(document.get("kinds", []), "kinds", _MAX_KINDS)]
    names = tuple(a_text(definition.get("template"), "kinds, template") for definition in kinds)
    parameters = tuple(
        {
            a_text(key, "kinds"): a_number(value, f"kinds, {key}")
            for key, value in an_object(definition.get("parameters", {}), "kinds").items()
        }
        for definition in kinds
    )
    return Truth(kind, names, parameters)


def load_arrays(content: bytes) -> Elements:
    """The elements of an NPZ file.

    Raises:
        FacadeError: If it is not such a file.
    """
    columns = _columns(content)
    missing = [name for name in ("offsets", "points", "boxes") if name not in columns]
    if missing:
        raise FacadeError(f"Arrays: expected offsets, points and boxes, found no {', '.join(missing)}.")
    for name, values in columns.items():
        if values.dtype.kind not in _COLUMNS[name] or not values.ndim:
            raise FacadeError(f"Arrays: {name}: expected {_DTYPES[_COLUMNS[name]]}, found {values.dtype}.")
    offsets, points, boxes = columns["offsets"].astype(np.int64), columns["points"].astype(float), columns["boxes"]
    boxes, number = boxes.astype(float), len(boxes)
    row, column = (columns.get(name, np.full(number, -1)).astype(np.int64) for name in ("row", "column"))
    kind = columns["kind"].astype(np.int64) if "kind" in columns else None
    fits = (
        boxes.shape == (number, 4)
        and offsets.shape == (number + 1,)
        and points.ndim == 2
        and points.shape[1] in {2, 3}
        and row.shape == column.shape == (number,)
        and (kind is None or (kind.shape == (number,) and ((kind >= 0) & (kind < _MAX_KINDS)).all()))
        and offsets[0] == 0
        and offsets[-1] == len(points)
        and (np.diff(offsets) >= 0).all()
    )
    if not fits:
        raise FacadeError("Arrays: expected boxes [N, 4], offsets [N + 1] that rise to P, points [P, 2 or 3], row [N].")
    truth = None if kind is None else Truth(kind, (), ())
    return check(
        Elements(
            offsets=offsets, points=points, low=boxes[:, :2], high=boxes[:, 2:], row=row, column=column, truth=truth
        )
    )


def _columns(content: bytes) -> dict[str, np.ndarray]:
    """The arrays of an NPZ file that elements are made of.

    Raises:
        FacadeError: when it cannot be read, or unfolds to too many bytes.
    """
    try:
        with zipfile.ZipFile(BytesIO(content)) as packed:
            size = sum(member.file_size for member in packed.infolist())
        fits = size <= _MAX_UNPACKED_BYTES
        with np.load(BytesIO(content), allow_pickle=False) as archive:
            columns = {name: np.asarray(archive[name]) for name in _COLUMNS if fits and name in archive.files}
    except Exception as error:  # zipfile, zlib and NumPy raise whatever they trip over
        raise FacadeError(f"This is not an NPZ file that can be read: {error}.") from error
    if not fits:
        raise FacadeError(f"This NPZ file unfolds to {size:,} bytes; expected at most {_MAX_UNPACKED_BYTES:,}.")
    return columns
