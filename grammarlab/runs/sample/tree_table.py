"""Trees on disk: one Parquet file per batch with a row per tree, from which it can be grown again.

trees.parquet: model, key, kind, tries, is_accepted, detail (index into `grammarlab.trees.detail.DETAILS`), heading
(radians), position (fixed list of 3, metres), and the parameters by the names of `grammarlab.trees.parameters.COLUMNS`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.errors import AssetError
from grammarlab.files import atomic_folder
from grammarlab.randomness import Keys
from grammarlab.trees.detail import DETAILS
from grammarlab.trees.parameters import COLUMNS, HIGH, IS_INTEGER, LOW

TREES = "trees.parquet"
FILES = (TREES,)
MAX_TREES = 200_000
"""Largest number of trees of a file."""
MAX_FILE_BYTES = 1 << 30
"""Largest size of a file in bytes."""
_NUMBERS = {
    "model": pa.int64(),
    "key": pa.uint64(),
    "kind": pa.int64(),
    "tries": pa.int64(),
    "is_accepted": pa.bool_(),
    "detail": pa.int8(),
    "heading": pa.float64(),
}
_POSITION = pa.list_(pa.float64(), 3)


@dataclass(frozen=True, slots=True, eq=False)
class TreeTable:
    """The n trees of a batch."""

    model: Ints
    """[n] index of each under the seed of its run."""
    key: Keys
    """[n] key below which it grows."""
    kind: Ints
    """[n] index of its kind in the species."""
    tries: Ints
    """[n] number of its candidates."""
    is_accepted: Flags
    """[n] whether a candidate was accepted."""
    detail: tuple[str, ...]
    """[n] level of detail, one of `grammarlab.trees.scene.DETAILS`."""
    heading: Floats
    """[n] radians by which it is turned about the vertical."""
    position: Floats
    """[n, 3] where it stands, metres."""
    rows: Floats
    """[n, P] its parameters."""

    def __len__(self) -> int:
        return len(self.model)

    def part(self, start: int, end: int) -> TreeTable:
        """Consecutive trees."""
        return TreeTable(**{name: getattr(self, name)[start:end] for name in self.__dataclass_fields__})

    @classmethod
    def joined(cls, tables: Sequence[TreeTable]) -> TreeTable:
        """The trees of tables, one after the other."""
        columns = {
            name: np.concatenate([getattr(table, name) for table in tables])
            for name in cls.__dataclass_fields__
            if name != "detail"
        }
        return cls(**columns, detail=tuple(detail for table in tables for detail in table.detail))

    def save(self, folder: Path) -> None:
        """Write the trees into a folder, which has all of them or none if the process is killed."""
        numbers = {name: getattr(self, name) for name in _NUMBERS} | {"detail": list(map(DETAILS.index, self.detail))}
        columns = {name: pa.array(numbers[name], kind) for name, kind in _NUMBERS.items()}
        columns["position"] = pa.FixedSizeListArray.from_arrays(pa.array(self.position.ravel()), 3)
        columns |= {name: pa.array(self.rows[:, index].copy()) for index, name in enumerate(COLUMNS)}
        with atomic_folder(folder, FILES) as part, (part / TREES).open("wb") as stream:
            pq.write_table(pa.table(columns), stream)

    @classmethod
    def load(cls, folder: Path) -> TreeTable:
        """The trees that `save` wrote, equal to the last bit; every number is checked.

        Raises:
            AssetError: If the folder has none, or they are damaged.
        """
        return cls.read(folder / TREES)

    @classmethod
    def read(cls, file: Path) -> TreeTable:
        """The trees of a file, see `load`."""
        if not file.is_file():
            raise AssetError(f"{file.parent}: expected trees here, but {file.name} is missing.")
        try:
            return cls._read(file)
        except (ValueError, LookupError, TypeError, OSError, RecursionError, pa.ArrowException) as error:
            raise AssetError(f"{file}: the trees are damaged ({error}). Sample them again.") from error

    @classmethod
    def _read(cls, file: Path) -> TreeTable:
        if file.stat().st_size > MAX_FILE_BYTES:
            raise ValueError(f"more than {MAX_FILE_BYTES:,} bytes")
        with file.open("rb") as stream, pq.ParquetFile(stream) as table:
            if table.metadata.num_rows > MAX_TREES:
                raise ValueError(f"more than {MAX_TREES:,} trees")
            kinds = {**_NUMBERS, "position": _POSITION, **dict.fromkeys(COLUMNS, pa.float64())}
            for name, kind in kinds.items():
                # Text and lists of strangers may take any memory.
                if table.schema_arrow.field(name).type != kind:
                    raise ValueError(f"expected {kind} in column {name}, found {table.schema_arrow.field(name).type}")
            names = list(kinds)
            values = table.read(columns=names, use_threads=False)
        if any(values.column(name).null_count for name in names):
            raise ValueError("a cell without a value")
        columns: dict[str, Any] = {name: values.column(name).to_numpy() for name in _NUMBERS}
        rows = np.column_stack([values.column(name).to_numpy() for name in COLUMNS])
        if not ((rows >= LOW) & (rows <= HIGH)).all() or (rows[:, IS_INTEGER] % 1.0).any():
            raise ValueError("a parameter is out of its range")
        numbers = columns.pop("detail").tolist()
        if any(not 0 <= number < len(DETAILS) for number in numbers):
            raise ValueError("an unknown level of detail")
        detail = tuple(DETAILS[number] for number in numbers)
        position = values.column("position").combine_chunks().flatten().to_numpy().reshape(-1, 3)
        if len(position) != len(rows) or not np.isfinite(position).all() or not np.isfinite(columns["heading"]).all():
            raise ValueError("a position or a heading is not finite")
        return cls(**columns, detail=detail, position=position, rows=rows)
