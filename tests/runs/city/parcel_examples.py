"""Rows of parcels for tests."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.parcel_rows import ParcelRows

FRAME = Frame("EPSG:32631", (448000.0, 5412000.0))


def parcel_rows(num: int, seed: int = 1, reports: tuple[str, ...] = ("height",), first: int = 0) -> ParcelRows:
    """Parcels on a grid of 100 columns; every third is empty."""
    number = np.arange(first, first + num)
    rng = np.random.default_rng(seed)
    corner = np.column_stack([number % 100, number // 100]) * 20.0 - 400.0
    outline = shapely.box(*corner.T, *(corner + 18.5).T)
    is_empty = number % 3 == 2
    lot = np.array(shapely.box(*(corner + 2).T, *(corner + 16.25).T), dtype=object)
    lot[is_empty] = None
    edges = np.where(is_empty, 0, 4)
    return ParcelRows(
        id=np.array([f"{value:05d}" for value in number], dtype=object),
        outline=outline,
        lot=lot,
        zone=np.array(["", "centre", "résidence"], dtype=object)[number % 3],
        reason=np.array(["", "", "small"], dtype=object)[number % 3],
        seed=np.full(num, 7, np.uint64),
        model=rng.integers(2**63, 2**64, num, dtype=np.uint64),
        reroll=number % 5,
        grammar=np.where(is_empty, "", "c0ffee").astype(object),
        area=shapely.area(outline),
        street_width=rng.choice([0.0, 8.0, 12.5], int(edges.sum())),
        lot_edges=np.append(0, np.cumsum(edges)),
        tile=np.where(is_empty, "", "t/9/256/257.glb").astype(object),
        reports={name: np.where(is_empty, np.nan, rng.uniform(3, 30, num)) for name in reports},
    )


def selected(rows: ParcelRows, order: np.ndarray) -> ParcelRows:
    """Rows in another order."""
    edges = [rows.street_width[start:end] for start, end in zip(rows.lot_edges, rows.lot_edges[1:], strict=False)]
    columns = {
        name: column[order]
        for name, column in vars(rows).items()
        if name not in ("street_width", "lot_edges", "reports")
    }
    return ParcelRows(
        **columns,
        street_width=np.concatenate([np.zeros(0), *(edges[row] for row in order)]),
        lot_edges=np.append(0, np.cumsum([len(edges[row]) for row in order])),
        reports={name: column[order] for name, column in rows.reports.items()},
    )


def assert_same_rows(rows: ParcelRows, expected: ParcelRows) -> None:
    """Compare all columns; coordinates to a nanometre, as the file has them far from its origin."""
    assert rows.reports.keys() == expected.reports.keys()
    for name, column in {
        **vars(expected),
        **{f"report {key}": expected.reports[key] for key in expected.reports},
    }.items():
        match = rows.reports[name.removeprefix("report ")] if name.startswith("report ") else getattr(rows, name)
        if name in ("outline", "lot"):
            assert (shapely.is_missing(match) == shapely.is_missing(column)).all()
            there = ~shapely.is_missing(column)
            assert shapely.equals_exact(match[there], column[there], 2e-9).all()
        elif name != "reports":
            np.testing.assert_array_equal(match, column)
