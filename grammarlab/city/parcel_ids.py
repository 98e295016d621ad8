"""Canonical ids of parcels, on which what is built depends: not on the format of the map, nor on the order of its rows.

A parcel without an id of its own gets a hash of its outline. Its building stays as long as the outline does.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.attribute_columns import flat_objects, number_text
from grammarlab.geometry.footprints.footprint import Remark

if TYPE_CHECKING:
    import pyarrow as pa

USUAL_FIELDS = ("id", "parcel_id", "parcelid", "apn", "pin", "idu", "gml_id", "identificatie", "uuid", "osm_id")
"""Names of attributes with ids in public maps, which are tried if none is named. Row numbers (``fid``, ``objectid``)
are not among them: they change when a map is exported."""
_MAX_CHARACTERS = 200
"""Longest id; longer texts are something else."""
_WHOLE = re.compile(r"(-?[0-9]+)\.0+")
_PART = re.compile(r"(.*)#[0-9]+", re.DOTALL)
_HASH_DIGITS = 16
"""Hexadecimal digits of a hash: two of a million outlines share one with a chance of 3e-8."""
_MOST_NAMES = 5
"""Ids that a remark names."""


@dataclass(frozen=True, eq=False)
class Identities:
    """Ids of the features of a map."""

    id: NDArray[np.object_]
    """[N] different texts."""
    remarks: tuple[Remark, ...]


def canonical_id(value: Any) -> str:
    """The canonical form of an id; empty for none.

    >>> [canonical_id(value) for value in (7, 7.0, "7.0", " 007 ", None)]
    ['7', '7', '7', '007', '']
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    text = value if isinstance(value, str) else number_text(value)
    if not text.isascii():
        text = unicodedata.normalize("NFC", text)
    text = text.strip()
    match = _WHOLE.fullmatch(text)
    text = match[1] if match else text
    return text if len(text) <= _MAX_CHARACTERS else ""


def identities(attributes: pa.Table, keys: Sequence[bytes], field: str | None, name: str) -> Identities:
    """Ids of features.

    Args:
        attributes: [N] columns of the map.
        keys: [N] outlines in a canonical form.
        field: the attribute with ids; None for one of `USUAL_FIELDS` whose values are all different.
        name: the map, for remarks.

    Raises:
        UsageError: If there is no such attribute.
    """
    if field is None:
        field = _usual_field(attributes, len(keys))
    elif field not in attributes.column_names:
        raise UsageError(
            f"{name}: no attribute {field[:80]!r} for ids; its attributes are {_listing(attributes.column_names)}."
        )
    ids = _texts(attributes, field) if field is not None else [""] * len(keys)
    counts = Counter(ids)
    rows = [row for row, text in enumerate(ids) if text == "" or counts[text] > 1 or _is_part(text, counts)]
    for row, text in zip(rows, _hashes(rows, keys, attributes), strict=True):
        ids[row] = text
    array = np.empty(len(ids), dtype=object)
    array[:] = ids
    return Identities(array, tuple(_remarks(field, rows, counts, len(ids), name)))


def part_ids(ids: NDArray[np.object_], num_parts: NDArray[np.int64]) -> NDArray[np.object_]:
    """[P] ids of the parts of features, ``id#1``, ``id#2`` for several; a single part has the id of its feature.

    Args:
        ids: [N] ids of features.
        num_parts: [N] number of parts of each, at least 1.
    """
    parts = np.repeat(ids, num_parts)
    starts = np.cumsum(num_parts) - num_parts
    for row in np.flatnonzero(num_parts > 1):
        for index in range(num_parts[row]):
            parts[starts[row] + index] = f"{ids[row]}#{index + 1}"
    return parts


def _texts(attributes: pa.Table, field: str) -> list[str]:
    return [canonical_id(value) for value in flat_objects(attributes.column(field))]


def _is_part(text: str, ids: Counter[str]) -> bool:
    """Whether an id is that of a part of a parcel with another id."""
    match = _PART.fullmatch(text)
    return match is not None and match[1] in ids


def _usual_field(attributes: pa.Table, num_features: int) -> str | None:
    """The first usual attribute whose ids are all there and different."""
    names = {name.lower(): name for name in reversed(attributes.column_names)}
    for usual in USUAL_FIELDS:
        if usual in names:
            texts = set(_texts(attributes, names[usual]))
            if len(texts) == num_features and "" not in texts:
                return names[usual]
    return None


def _hashes(rows: Sequence[int], keys: Sequence[bytes], attributes: pa.Table) -> list[str]:
    """Ids of the features at some rows from their outlines.

    Equal outlines are told apart by a number, in the order of their attributes.
    """
    groups: defaultdict[bytes, list[int]] = defaultdict(list)
    for row in rows:
        groups[keys[row]].append(row)
    texts: dict[int, str] = {}
    for key, members in groups.items():
        text = f"outline-{sha256(key).hexdigest()[:_HASH_DIGITS]}"
        if len(members) == 1:
            texts[members[0]] = text
            continue
        records = attributes.take(members).to_pylist() if attributes.num_columns else [{} for _ in members]
        order = sorted(range(len(members)), key=lambda index: repr(records[index]))
        for number, index in enumerate(order, 1):
            texts[members[index]] = f"{text}={number}"
    return [texts[row] for row in rows]


def _remarks(
    field: str | None, rows: Sequence[int], counts: Counter[str], num_features: int, name: str
) -> list[Remark]:
    moving = "moving one of their corners rerolls what is built"
    if field is None:
        return [
            Remark(name, "identity", f"no attribute is named for ids: they are hashes of outlines, so {moving}")
        ] * (num_features > 0)
    if not rows:
        return []
    double = sorted(text for text, count in counts.items() if count > 1 and text)
    examples = f", such as {_listing(double)}" if double else ""
    reason = (
        f"{len(rows):,} of {num_features:,} parcels have no id of their own in {field!r} (empty or double{examples})"
    )
    return [Remark(name, "identity", f"{reason}: theirs are hashes of outlines, so {moving}")]


def _listing(names: Sequence[str]) -> str:
    shown = ", ".join(repr(name[:40]) for name in names[:_MOST_NAMES])
    return shown + (f" and {len(names) - _MOST_NAMES:,} more" if len(names) > _MOST_NAMES else "")
