"""Places of the trees of parks, kept in the folder of a city, since planting takes longer than reading them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, final
from zipfile import BadZipFile

import numpy as np
import shapely

from grammarlab.about import __version__
from grammarlab.arrays import Floats, Ints
from grammarlab.city.parcels import Outlines
from grammarlab.errors import AssetError
from grammarlab.export.model_files import write_whole
from grammarlab.files import file_below, folder_below, read_bounded, remove_parts

FOLDER = "parks"
"""Folder below that of the city, with one file for each zone of parks."""
_MAX_BYTES = 1 << 30
"""Largest size of a file in bytes: forty million trees."""
_DIGEST_BYTES = 32


@dataclass(frozen=True, slots=True)
class PlantedTrees:
    """T trees of the parks of one zone."""

    species: Ints
    """[T] number of the species in the zone."""
    east_north: Floats
    """[T, 2] places in metres of the frame."""


@final
class PlantedParks:
    """The trees of all zones of parks of a city.

    A file is a SHA-256 of the key and of the rest, which is an archive of numpy.

    Args:
        folder: folder of the city; None if nothing is kept.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._names: set[str] = set()

    def of_zone(
        self, zone: int, general: Sequence[Any], outlines: Outlines, plant: Callable[[], PlantedTrees]
    ) -> PlantedTrees:
        """Trees of the parks of a zone: those that are kept, if they are of the same parks.

        Args:
            zone: number of the zone.
            general: what decides about the trees beside the parks, with a complete `repr`.
            outlines: the parks in metres of the frame.
            plant: plants the trees.
        """
        if self._folder is None:
            return plant()
        key = repr((__version__, *general)).encode("utf-8", "surrogatepass") + b"".join(shapely.to_wkb(outlines))
        name = f"{zone}.trees"
        self._names.add(name)
        trees = _read(self._folder, name, key)
        if trees is None:
            trees = plant()
            _write(self._folder / FOLDER / name, key, trees)
        return trees

    def drop_others(self) -> None:
        """Remove the files of zones that were not asked for."""
        home = None if self._folder is None else folder_below(self._folder, FOLDER)
        if home is not None:
            remove_parts(home)
            for path in home.glob("*.trees"):
                if path.name not in self._names:
                    path.unlink()


def _read(folder: Path, name: str, key: bytes) -> PlantedTrees | None:
    path = file_below(folder, f"{FOLDER}/{name}")
    try:
        content = memoryview(read_bounded(path, _MAX_BYTES)) if path else memoryview(b"")
        digest, archive = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
        if digest != _digest(key, archive):
            return None
        with np.load(BytesIO(archive), allow_pickle=False) as columns:
            return PlantedTrees(columns["species"], columns["east_north"])
    except (AssetError, OSError, BadZipFile, LookupError, ValueError, EOFError):
        return None


def _write(path: Path, key: bytes, trees: PlantedTrees) -> None:
    archive = BytesIO()
    np.savez(archive, species=trees.species, east_north=trees.east_north)
    content = archive.getvalue()
    write_whole(path, _digest(key, content) + content)


def _digest(key: bytes, archive: bytes | memoryview) -> bytes:
    digest = sha256(sha256(key).digest())
    digest.update(archive)
    return digest.digest()
