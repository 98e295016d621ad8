"""Building parcels of a city again after a change of its plan or pins."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from time import time_ns

from grammarlab.errors import AssetError, UsageError
from grammarlab.export.cityjson import levels_of
from grammarlab.files import read_bounded
from grammarlab.runs.city.build import CITY, BuildOptions, build_city
from grammarlab.runs.city.parcel_listing import TILES

_MAX_BYTES = 1 << 26


def rebuild(folder: Path, parcels: Sequence[str]) -> list[str]:
    """Build a city again where it has changed.

    Args:
        folder: folder of a built city.
        parcels: ids of parcels that have changed; shards without changes are kept whatever they are.

    Returns:
        Addresses below the folder of the tiles that were written.

    Raises:
        GrammarlabError: If the folder has no city, or its plan cannot be used.
    """
    if not parcels:
        return []
    plan, options = plan_of_city(folder)
    start = time_ns()
    build_city(plan, folder, cityjson=options.cityjson, implicit=options.implicit)
    tiles = sorted(path for path in (folder / TILES).rglob("*.glb") if path.stat().st_mtime_ns >= start)
    return [path.relative_to(folder).as_posix() for path in tiles]


def plan_of_city(folder: Path) -> tuple[Path, BuildOptions]:
    """The plan of a built city, and which files it has.

    Raises:
        UsageError: If the folder has no city, or the plan is gone.
    """
    try:
        values = json.loads(read_bounded(folder / CITY, _MAX_BYTES))
        levels = levels_of(",".join(values["cityjson"])) if values["cityjson"] else ()
        plan, options = Path(values["plan"]), BuildOptions(implicit=bool(values["implicit"]), cityjson=levels)
    except (AssetError, UsageError, OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise UsageError(f"{folder}: expected a city. Make one: grammarlab city build PLAN.toml -o {folder}") from error
    if not plan.is_file():
        raise UsageError(f"{folder}: its plan {plan} is gone. Build it from another one: grammarlab city build")
    return plan, options
