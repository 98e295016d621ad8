"""Tables of parcels come back as they were, in any reader of GeoParquet, whatever the order of their rows."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pyproj
import pytest
import shapely

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.parcel_reading import frame_of_table, read_parcel_table
from grammarlab.runs.city.parcel_rows import ParcelRows
from grammarlab.runs.city.parcel_table import GROUP_ROWS, ParcelTableWriter
from tests.runs.city.parcel_examples import FRAME, assert_same_rows, parcel_rows, selected


def written(path: Path, *parts: ParcelRows, frame: Frame = FRAME) -> Path:
    with ParcelTableWriter(path, frame) as writer:
        for part in parts:
            writer.add(part)
    return path


def by_id(rows: ParcelRows) -> ParcelRows:
    return selected(rows, np.argsort(rows.id))


def test_a_table_comes_back(tmp_path):
    rows = parcel_rows(200, reports=("height", "floors"))
    path = written(tmp_path / "parcels.parquet", rows)
    assert frame_of_table(path) == FRAME
    assert_same_rows(by_id(read_parcel_table(path)), rows)


def test_bytes_depend_neither_on_the_order_of_rows_nor_on_parts(tmp_path):
    rows = parcel_rows(300)
    order = np.random.default_rng(3).permutation(300)
    shuffled = selected(rows, order)
    one = written(tmp_path / "one.parquet", rows)
    other = written(
        tmp_path / "other.parquet", *(selected(shuffled, part) for part in np.array_split(np.arange(300), 7))
    )
    assert one.read_bytes() == other.read_bytes()


def test_groups_of_rows_are_places_in_morton_order(tmp_path):
    path = written(tmp_path / "parcels.parquet", parcel_rows(15_000), parcel_rows(15_000, first=15_000))
    metadata = pq.read_metadata(path)
    assert [metadata.row_group(group).num_rows for group in range(2)] == [GROUP_ROWS, 30_000 - GROUP_ROWS]
    middles = shapely.get_coordinates(shapely.centroid(read_parcel_table(path).outline))
    steps = np.hypot(*np.diff(middles, axis=0).T)
    assert np.median(steps) <= 20.0 * np.sqrt(2)


def test_a_box_selects_the_parcels_that_meet_it(tmp_path):
    rows = parcel_rows(400)
    path = written(tmp_path / "parcels.parquet", rows)
    box = (-100.0, -400.0, 100.0, -330.0)
    expected = rows.id[shapely.intersects(rows.outline, shapely.box(*box))]
    assert sorted(read_parcel_table(path, box=box).id) == sorted(expected)
    assert by_id(read_parcel_table(path, ids=np.array(["00007", "00123", "?"], object))).id.tolist() == [
        "00007",
        "00123",
    ]


def test_reports_of_some_grammars_are_null_for_the_others(tmp_path):
    path = written(tmp_path / "p.parquet", parcel_rows(6, reports=("a",)), parcel_rows(6, reports=("b",), first=6))
    rows = by_id(read_parcel_table(path))
    assert np.isnan(rows.reports["b"][:6]).all()
    assert np.isfinite(rows.reports["b"][[6, 7, 9, 10]]).all()


@pytest.mark.parametrize("crs", ["EPSG:32631", ""], ids=["in place", "local"])
def test_other_readers_find_the_same_places(tmp_path, crs):
    frame = Frame(crs, FRAME.origin)
    rows = parcel_rows(50)
    path = written(tmp_path / "parcels.parquet", rows, frame=frame)
    geo = json.loads(pq.read_schema(path).metadata[b"geo"])
    assert geo["version"] == "1.1.0"
    for column in ("geometry", "lot"):
        system = geo["columns"][column]["crs"]
        assert system is None if not crs else pyproj.CRS.from_json_dict(system) == pyproj.CRS(crs)
    bounds = shapely.total_bounds(rows.outline) + np.tile(frame.origin, 2)
    np.testing.assert_allclose(geo["columns"]["geometry"]["bbox"], bounds)


def test_a_table_without_parcels_is_a_table(tmp_path):
    assert len(read_parcel_table(written(tmp_path / "parcels.parquet"))) == 0


def test_a_table_that_fails_is_not_there(tmp_path):
    with pytest.raises(ZeroDivisionError), ParcelTableWriter(tmp_path / "p.parquet", FRAME) as writer:
        writer.add(parcel_rows(1 // 0))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("damage", ["empty", "cut", "other"])
def test_files_that_are_no_tables_are_refused(tmp_path, damage):
    path = written(tmp_path / "parcels.parquet", parcel_rows(30))
    content = path.read_bytes()
    if damage == "other":
        pq.write_table(pq.read_table(path).replace_schema_metadata({b"grammarlab": b'{"format":9}'}), path)
    else:
        path.write_bytes(b"" if damage == "empty" else content[: len(content) // 2])
    with pytest.raises(AssetError, match=r"expected (the|a) table of parcels"):
        read_parcel_table(path)
