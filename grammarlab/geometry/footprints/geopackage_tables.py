"""What a GeoPackage would compute when it is opened: a stranger's query may take for ever."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

from grammarlab.errors import AssetError
from grammarlab.printable import printable

_QUERY = """
SELECT name FROM sqlite_master
WHERE type = 'view' OR (lower(sql) LIKE 'create virtual table%' AND lower(sql) NOT LIKE '% using rtree%')
ORDER BY name LIMIT 8
"""
"""Spatial indices are virtual tables, which are stored."""


def check_tables(path: Path) -> None:
    """Check that all tables of a GeoPackage are stored ones: GDAL reads some rows of each.

    Raises:
        AssetError: If some are computed, or the file is broken.
    """
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)) as database:
            names = [str(name) for (name,) in database.execute(_QUERY)]
    except (sqlite3.Error, UnicodeError) as error:
        raise AssetError(f"{path}: this file is broken: {printable(str(error))[:200]}.") from error
    if names:
        listing = ", ".join(repr(printable(name)[:60]) for name in names)
        raise AssetError(
            f"{path}: expected stored tables, found views, which are computed: {listing}. Copy the layer: "
            f"ogr2ogr NEW.gpkg {path.name} LAYER"
        )
