"""Answers about zones: a table of parcels with their right zones, or with scores of zones.

```csv
id,zone,score
75118000AB0042,downtown,80
```

Without the column ``score`` each row names the right zone of a parcel. With it, a row says how well a zone suits a
parcel, from 0 (not at all) to 100. Rows without an answer are left out, so a list of questions may be filled in partly.
A parcel may have several rows, by several persons.
"""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import AssetError, TableError, shown
from grammarlab.files import read_bounded
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.label_files import score
from grammarlab.tables import Table, TableRow, read_table

MAX_FILE_BYTES = 16 << 20
"""Largest size of a file in bytes."""
MAX_ANSWERS = 50_000
"""Most rows of a file."""
_MAX_CHARACTERS = 256
"""Most characters of an id or a zone."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ZoneAnswers:
    """n answers."""

    id: NDArray[np.object_]
    """[n] ids of parcels, with repeats."""
    zone: NDArray[np.object_]
    """[n] names of zones."""
    score: Floats | None
    """[n] 0 to 100; None if the zones are the right ones."""
    line: Ints
    """[n] line in the file, from 1."""
    num_blank: int = 0
    """Rows that were left out since they have no answer."""

    def __len__(self) -> int:
        return len(self.id)

    @property
    def hash(self) -> str:
        """SHA-256 of the answers in any order: 64 hexadecimal digits."""
        scores = [""] * len(self) if self.score is None else [repr(value) for value in self.score.tolist()]
        rows = sorted("\0".join(row) for row in zip(self.id, self.zone, scores, strict=True))
        return sha256("\n".join(rows).encode("utf-8", "surrogatepass")).hexdigest()


def read_zone_answers(path: Path) -> ZoneAnswers:
    """The answers of a file.

    Raises:
        AssetError: If there is no such file, it is too large or not such a table; the message names the line.
    """
    try:
        return _answers(read_table(read_bounded(path, MAX_FILE_BYTES), MAX_ANSWERS + 1))
    except OSError as error:
        raise AssetError(
            f"{path}: {error.strerror or error}; expected a table with the columns id and zone."
        ) from error
    except TableError as error:
        raise AssetError(f"{path}: {error}") from error


def canonical_text(text: str) -> str:
    """A name or an id as it is compared: in Unicode's composed form (NFC), without blanks around it."""
    return unicodedata.normalize("NFC", text).strip()


def _answers(table: Table) -> ZoneAnswers:
    header = table.header
    for name in ("id", "zone"):
        if header.count(name) != 1:
            listing = ", ".join(header)[:200] or "none"
            raise TableError(f"expected the columns id and zone, and perhaps score; found {listing}.")
    has_scores = "score" in header
    rows = [(row, cells) for row in table.body if (cells := _cells(header, row)) is not None]
    values = [_score(table, row, cells) if has_scores else MAX_SCORE for row, cells in rows]
    answered = [index for index, value in enumerate(values) if value is not None]
    if not answered:
        raise TableError(f"expected answers, found none in {len(table.body)} rows.")
    return ZoneAnswers(
        id=np.array([rows[index][1]["id"] for index in answered], object),
        zone=np.array([rows[index][1]["zone"] for index in answered], object),
        score=np.array([values[index] for index in answered], np.float64) if has_scores else None,
        line=np.array([rows[index][0].line for index in answered]),
        num_blank=len(table.body) - len(answered),
    )


def _cells(header: tuple[str, ...], row: TableRow) -> dict[str, str] | None:
    """Cells by column; None for a row without a zone."""
    cells = {name: canonical_text(cell) for name, cell in zip(header, row.cells, strict=False)}
    if not cells.get("zone"):
        return None
    if not cells["id"]:
        raise TableError(f"line {row.line}: expected the id of a parcel, found an empty cell.")
    for name in ("id", "zone"):
        if len(cells[name]) > _MAX_CHARACTERS or not cells[name].isprintable():
            raise TableError(
                f"line {row.line}: expected {name} = a line of at most {_MAX_CHARACTERS} characters, "
                f"found {shown(cells[name])}."
            )
    return cells


def _score(table: Table, row: TableRow, cells: dict[str, str]) -> float | None:
    """Score of a row; None for an empty cell."""
    value = score(cells.get("score", ""), table.number)
    if value is None:
        return None
    if not isinstance(value, int | float) or not 0.0 <= value <= MAX_SCORE:
        raise TableError(f"line {row.line}: expected a score from 0 to {MAX_SCORE:g}, found {shown(cells['score'])}.")
    return float(value)
