"""Addresses of buildings: seed and index of the model of each parcel, by its id and by pins.

The index is the first 8 bytes of SHA-256 of the id, a zero byte and the number of rerolls. It depends on no other
parcel and on no order, and two of a million parcels have one index with a probability of 3e-8.

Pins are a table (``pins.csv``) that people edit: id, seed, model, reroll, zone. All cells but the id may be empty.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Ints
from grammarlab.city.parcel_ids import canonical_id
from grammarlab.errors import AssetError, TableError, UsageError, shown
from grammarlab.files import read_bounded, write_bytes
from grammarlab.preference.label_files import integer
from grammarlab.tables import Table, TableRow, read_table

COLUMNS = ("id", "seed", "model", "reroll", "zone")
EXCLUDED = "-"
"""Zone of parcels that stay empty; zones of plans begin with a letter or a digit."""
MAX_FILE_BYTES = 64 << 20
"""Largest size of a table of pins in bytes."""
MAX_PINS = 1_000_000
"""Largest number of pins in a table."""
_LAST_WORD = 2**64 - 1
_LAST_REROLL = 2**31 - 1


@dataclass(frozen=True, slots=True)
class Pin:
    """What is fixed about one parcel."""

    id: str
    """Canonical id of the parcel."""
    seed: int | None = None
    """Seed of its building; None for that of the city."""
    model: int | None = None
    """Index of its model; None for that of its id and rerolls."""
    reroll: int = 0
    """How often it was rerolled, 0 <= reroll < 2**31."""
    zone: str = ""
    """Its zone; empty for that of the plan, `EXCLUDED` for a parcel that stays empty."""

    @property
    def is_empty(self) -> bool:
        """Whether nothing is fixed."""
        return self == Pin(self.id)


@dataclass(frozen=True)
class Pins:
    """What is fixed about parcels, ordered by id; at most one pin per parcel."""

    rows: tuple[Pin, ...] = field(default=())

    def __post_init__(self) -> None:
        ids = [pin.id for pin in self.rows]
        if any(one >= other for one, other in pairwise(ids)):
            raise UsageError("pins: expected different ids in ascending order")

    @classmethod
    def of(cls, rows: Iterable[Pin]) -> Pins:
        """Pins in any order.

        Raises:
            UsageError: If two have one id.
        """
        return cls(tuple(sorted(rows, key=lambda pin: pin.id)))

    def __len__(self) -> int:
        return len(self.rows)

    @cached_property
    def by_id(self) -> Mapping[str, Pin]:
        """Pins by the ids of their parcels."""
        return {pin.id: pin for pin in self.rows}

    def get(self, parcel: str) -> Pin:
        """The pin of a parcel; one that fixes nothing if there is none."""
        return self.by_id.get(parcel, Pin(parcel))


@dataclass(frozen=True, eq=False, kw_only=True)
class Addresses:
    """Addresses of the buildings of N parcels."""

    seed: NDArray[np.uint64]
    """[N] seed."""
    model: NDArray[np.uint64]
    """[N] index of the model under the seed."""
    reroll: Ints
    """[N] how often the parcel was rerolled."""
    zone: NDArray[np.object_]
    """[N] name of the zone that is fixed; empty for none."""
    is_excluded: Flags
    """[N] whether the parcel stays empty."""


def addresses(ids: NDArray[np.object_], seed: int, pins: Pins) -> Addresses:
    """Addresses of the buildings of parcels.

    Args:
        ids: [N] different canonical ids.
        seed: seed of the city, 0 <= seed < 2**64.
        pins: pins of these and of other parcels.
    """
    rows = [(row, pins.by_id[parcel]) for row, parcel in enumerate(ids) if parcel in pins.by_id] if len(pins) else []
    reroll = np.zeros(len(ids), np.int64)
    seeds = np.full(len(ids), seed, np.uint64)
    zone = np.full(len(ids), "", object)
    for row, pin in rows:
        reroll[row], zone[row] = pin.reroll, pin.zone
        seeds[row] = seed if pin.seed is None else pin.seed
    model = model_indices(ids, reroll)
    for row, pin in rows:
        if pin.model is not None:
            model[row] = pin.model
    is_excluded = (zone == EXCLUDED).astype(np.bool_)
    return Addresses(seed=seeds, model=model, reroll=reroll, zone=zone, is_excluded=is_excluded)


def model_indices(ids: Sequence[str] | NDArray[np.object_], rerolls: NDArray[np.integer]) -> NDArray[np.uint64]:
    """[N] indices of models of parcels: the first 8 bytes of SHA-256 of the id, a zero byte, and the number of rerolls.

    >>> model_indices(["75118000AB0042"], np.array([0])).tolist()
    [4857428368070355551]
    """
    texts = (f"{parcel}\0{reroll}" for parcel, reroll in zip(ids, rerolls.tolist(), strict=True))
    digests = b"".join(sha256(text.encode("utf-8", "surrogatepass")).digest()[:8] for text in texts)
    return np.frombuffer(digests, ">u8").astype(np.uint64)


# Changes -------------------------------------------------------------------------------------------------------------


def rerolled(pins: Pins, parcel: str) -> Pins:
    """Pins with which a parcel has another building; a pinned building is released, a fixed zone is kept."""
    pin = pins.get(parcel)
    return _with(pins, Pin(parcel, reroll=pin.reroll + 1, zone="" if pin.zone == EXCLUDED else pin.zone))


def pinned(pins: Pins, parcel: str, *, seed: int, model: int, zone: str) -> Pins:
    """Pins with which a parcel keeps a building, whatever the seed of the city and wherever its zones are.

    Args:
        pins: the pins so far.
        parcel: id of the parcel.
        seed: seed of the building.
        model: its index.
        zone: its zone.

    Raises:
        UsageError: If a number is out of range, or there is no zone.
    """
    if zone in ("", EXCLUDED):
        raise UsageError(f"expected the zone of the building to keep, found {shown(zone)}")
    for name, value in (("seed", seed), ("model", model)):
        if not 0 <= value <= _LAST_WORD:
            raise UsageError(f"expected 0 <= {name} < 2**64, found {shown(value)}")
    return _with(pins, replace(pins.get(parcel), seed=seed, model=model, zone=zone))


def placed_in(pins: Pins, parcel: str, zone: str) -> Pins:
    """Pins with which a parcel is in a zone; an empty name leaves it to the plan."""
    return _with(pins, replace(pins.get(parcel), zone=zone))


def excluded(pins: Pins, parcel: str) -> Pins:
    """Pins with which a parcel stays empty."""
    return placed_in(pins, parcel, EXCLUDED)


def released(pins: Pins, parcel: str) -> Pins:
    """Pins that fix nothing about a parcel."""
    return _with(pins, Pin(parcel))


def _with(pins: Pins, pin: Pin) -> Pins:
    rows = {**pins.by_id, pin.id: pin}
    return Pins.of(row for row in rows.values() if not row.is_empty)


# Files ---------------------------------------------------------------------------------------------------------------


def save_pins(pins: Pins, path: Path) -> None:
    """Write a table of pins atomically; an existing file is replaced."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([getattr(pin, name) for name in COLUMNS] for pin in pins.rows)
    write_bytes(path, text.getvalue().encode("utf-8"))


def read_pins(path: Path) -> Pins:
    """Pins from a table; none if there is no such file.

    Raises:
        AssetError: If it is too large or not such a table; the message names the line.
    """
    if not path.exists():
        return Pins()
    try:
        return _pins(read_table(read_bounded(path, MAX_FILE_BYTES), MAX_PINS + 1))
    except (TableError, OSError) as error:
        raise AssetError(f"{path}: {error}") from error


def _pins(table: Table) -> Pins:
    header = table.header
    if header and "id" not in header:
        raise TableError(f"expected the columns {', '.join(COLUMNS)}; missing id; found {', '.join(header)[:200]}.")
    rows = [_pin(header, row) for row in table.body]
    _check_different(rows, table.body)
    return Pins.of(pin for pin in rows if not pin.is_empty)


def _pin(header: Sequence[str], row: TableRow) -> Pin:
    cells = dict(zip(header, row.cells, strict=False))
    parcel = canonical_id(cells.get("id"))
    if not parcel:
        raise TableError(f"line {row.line}: expected the id of a parcel, found an empty cell.")
    return Pin(
        id=parcel,
        seed=_number(row, cells, "seed", _LAST_WORD),
        model=_number(row, cells, "model", _LAST_WORD),
        reroll=_number(row, cells, "reroll", _LAST_REROLL) or 0,
        zone=cells.get("zone", ""),
    )


def _number(row: TableRow, cells: Mapping[str, str], name: str, most: int) -> int | None:
    """A whole number of a cell; None for an empty one."""
    text = cells.get(name, "")
    if not text:
        return None
    try:
        value = integer(name, text)
    except UsageError as error:
        raise TableError(f"line {row.line}: {error}") from error
    if not isinstance(value, int) or not 0 <= value <= most:
        raise TableError(f"line {row.line}: expected {name} = a whole number from 0 to {most}, found {shown(text)}.")
    return value


def _check_different(pins: Sequence[Pin], rows: Sequence[TableRow]) -> None:
    lines: dict[str, int] = {}
    for pin, row in zip(pins, rows, strict=True):
        if pin.id in lines:
            raise TableError(f"line {row.line}: parcel {shown(pin.id)} has a pin on line {lines[pin.id]} already.")
        lines[pin.id] = row.line
