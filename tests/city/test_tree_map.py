"""Trees of maps are points with names, and names have species."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.tree_map import read_mapped_trees
from grammarlab.city.tree_names import SpeciesNames
from grammarlab.errors import AssetError
from tests.city.test_map_shapes import NOWHERE, write


def test_points_are_trees_and_other_shapes_are_not(tmp_path: Path):
    shapes = [shapely.Point(3, 4), shapely.MultiPoint([(5, 6), (7, 8)]), shapely.box(0, 0, 1, 1)]
    names = [{"art": " Tilia cordata "}, {"art": None}, {"art": "Quercus"}]
    file = write(tmp_path / "trees.geojson", shapes, names, crs=None)
    trees = read_mapped_trees(file, "art", NOWHERE)
    np.testing.assert_array_equal(trees.east_north, [[3, 4], [5, 6], [7, 8]])
    assert trees.name.tolist() == ["Tilia cordata", "", ""]


def test_maps_without_the_field_or_without_points_are_refused(tmp_path: Path):
    point = write(tmp_path / "a.geojson", [shapely.Point(3, 4)], [{"art": "Tilia"}], crs=None)
    with pytest.raises(AssetError, match="in the field 'species', found the fields art"):
        read_mapped_trees(point, "species", NOWHERE)
    polygon = write(tmp_path / "b.geojson", [shapely.box(0, 0, 1, 1)], [{"art": "Tilia"}], crs=None)
    with pytest.raises(AssetError, match="expected trees as points, found none"):
        read_mapped_trees(polygon, "art", NOWHERE)


def test_the_longest_known_beginning_decides_about_a_name():
    names = SpeciesNames({"oak": ["Quercus"], "poplar": ["Quercus robur 'Fastigiata'", "populus  nigra"]})
    assert names.of("Quercus petraea") == "oak"
    assert names.of("quercus ROBUR 'fastigiata' Koster") == "poplar"
    assert names.of("Populus nigra") == "poplar"
    assert [names.of(name) for name in ("Populus", "Quercusoides", "", "Pseudo Quercus")] == [None] * 4
    assert SpeciesNames({}).of("Quercus") is None
