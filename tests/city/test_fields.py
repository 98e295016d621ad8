"""Fields of parcels: right values, whatever else is on the map."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from grammarlab.city.fields import numeric_attribute, parcel_fields
from grammarlab.errors import UsageError
from tests.city.quarters import quarter

PARCELS = quarter(500, height=np.linspace(0, 9, 500), flat=[True, None] * 250, use=["a"] * 500)


def test_area_and_aspect_are_those_of_the_box_turned_in_any_way():
    fields = parcel_fields(PARCELS)
    west, south, east, north = shapely.bounds(PARCELS.outline).T
    sides = np.column_stack([east - west, north - south])
    np.testing.assert_allclose(fields.columns(["area"])[:, 0], sides.prod(axis=1))
    np.testing.assert_allclose(fields.columns(["aspect"])[:, 0], sides.max(axis=1) / sides.min(axis=1), rtol=1e-5)
    assert (shapely.contains_xy(PARCELS.outline, *fields.east_north.T)).all()


def test_distances_are_zero_inside_an_area_and_in_metres():
    near = {"river": shapely.LineString([(-500, -500), (5000, -500)]), "park": shapely.box(-1e4, -1e4, 1e4, 1e4)}
    fields = parcel_fields(PARCELS, near=near)
    np.testing.assert_allclose(fields.columns(["river"])[:, 0], fields.east_north[:, 1] + 500)
    assert not fields.columns(["park"]).any()


def test_fields_of_a_parcel_are_the_same_without_the_others():
    rows = np.array([400, 3])
    every = parcel_fields(PARCELS, attributes=["height"], frontage=np.arange(500.0))
    some = parcel_fields(PARCELS.take(rows), attributes=["height"], frontage=np.array([400.0, 3.0]))
    assert some.name == every.name == ("area", "aspect", "frontage", "height")
    np.testing.assert_array_equal(some.values, every.take(rows).values)
    np.testing.assert_array_equal(some.id, PARCELS.id[rows])


def test_attributes_are_numbers_and_unknown_where_there_is_none():
    np.testing.assert_array_equal(numeric_attribute(PARCELS, "flat")[:2], [1.0, np.nan])
    with pytest.raises(UsageError, match="attribute 'use': expected a column of numbers, one of height, flat"):
        numeric_attribute(PARCELS, "use")
    area = quarter(500, area=np.zeros(500))
    assert parcel_fields(area, attributes=["area"]).name == ("area", "aspect")
    with pytest.raises(UsageError, match="different names"):
        parcel_fields(PARCELS, near={"height": shapely.Point()}, rasters={"height": np.zeros(500)})
