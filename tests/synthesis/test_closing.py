"""New buildings of units: closed, of the right size, and made only of units."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from grammarlab.synthesis.analysis.example import Example
from grammarlab.synthesis.assembly import (
    Tiling,
    UnstitchedPieces,
    assemble,
    counts_for,
    natural,
    sources_of,
    stretch_for,
    tile,
)
from grammarlab.synthesis.closing import TOLERANCE, closed, seams
from grammarlab.synthesis.label_grid import LabelGrid
from grammarlab.synthesis.mesh.building_files import read_mesh
from grammarlab.synthesis.mesh.surface import Surface, edge_numbers
from grammarlab.synthesis.stitching import conformed
from grammarlab.synthesis.units import BuildingCut, cut_up
from tests.synthesis.analyses import analysed_once
from tests.synthesis.houses import House, house

SIZES = [(8, 15), (1, 7), (5, 1), (1, 1), (6, 6)]


def random_building(
    known: House, path: Path, rows: int, columns: int, seed: int
) -> tuple[Example, BuildingCut, list[Tiling], UnstitchedPieces]:
    """A building whose units are in random order: no two neighbours fit."""
    random = np.random.default_rng(seed)
    example = analysed_once(read_mesh(known.write(path / "house.obj")))

    def grid(region, shape):
        return LabelGrid.from_labels(random.integers(0, len(region.grid.names), shape), region.grid.names)

    first = grid(example.main, (rows, columns))
    walls = example.regions
    stretch = stretch_for(example, natural(walls, sources_of(walls, (0,), first)), (None, None, None))
    others = [grid(region, counts_for(region, stretch)) for region in example.regions[1:]]
    tilings = [
        tile(walls, own, each, sources_of(walls, (own,), each), stretch) for own, each in enumerate([first, *others])
    ]
    cut = cut_up(example.surface, example.regions)
    return example, cut, tilings, assemble(cut, tilings, stretch)


@pytest.mark.parametrize(("rows", "columns"), SIZES)
def test_a_closed_house_makes_closed_buildings_of_any_size(rows: int, columns: int, tmp_path: Path) -> None:
    example, _, tilings, pieces = random_building(house(broad=((2, 1), (4, 4))), tmp_path, rows, columns, rows)
    surface = closed(pieces, tilings, 0.0, was_closed=True).surface
    # As a reader of files has it: points of equal coordinates are one.
    mesh = trimesh.Trimesh(surface.points, surface.triangles, process=True)
    assert edge_numbers(example.surface).watertight
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0
    assert edge_numbers(surface).boundary == 0
    heights = mesh.area_faces * 2.0 / mesh.edges_unique_length[mesh.faces_unique_edges].max(axis=1)
    assert heights.min() > TOLERANCE / 20.0
    # The walls stay in place: the building is as large as its units and the rest.
    size = np.ptp(example.surface.points, axis=0)
    grown = [
        np.ptp(each) - np.ptp(old)
        for each, old in zip(
            (tilings[0].columns, tilings[0].rows), (example.main.columns.line, example.main.rows.line), strict=True
        )
    ]
    assert np.ptp(surface.points, axis=0)[:2] == pytest.approx(size[:2] + grown, abs=1e-4)


def test_no_open_point_lies_on_an_open_edge_of_a_seam(tmp_path: Path) -> None:
    _, _, tilings, pieces = random_building(house(broad=((2, 1),)), tmp_path, 5, 7, 3)
    surface = closed(pieces, tilings, 0.0, was_closed=False).surface
    again = conformed(surface, seams(tilings), TOLERANCE)
    assert len(again) == len(surface)


def test_every_unit_is_a_unit_of_the_example_up_to_its_size(tmp_path: Path) -> None:
    _, cut, tilings, pieces = random_building(house(broad=((2, 1),)), tmp_path, 3, 5, 4)
    surface = closed(pieces, tilings, 0.0, was_closed=True).surface
    corners = surface.points + 0.0
    piece = 1
    for number, tiling in enumerate(tilings):
        for row, column in np.ndindex(tiling.grid.labels.shape):
            wall, *source = tiling.sources[row, column].tolist()
            assert wall == number
            assert tiling.region.grid.labels[*source] == tiling.grid.labels[row, column]
            unit = cut.cells[wall][source[0]][source[1]]
            own = pieces.surface.points[pieces.first[piece] : pieces.first[piece + 1]]
            # One scale per axis moves the unit to its place, and its points are still there after stitching.
            scale = np.ptp(own, axis=0)
            assert len(own) == len(unit.points)
            assert np.sort(scale)[::-1][:2] == pytest.approx(
                np.sort([np.diff(tiling.columns)[column], np.diff(tiling.rows)[row]])[::-1], abs=1e-6
            )
            distance = np.abs(corners[:, None, :] - own[None, ::7, :]).max(axis=2).min(axis=0)
            assert distance.max() <= 2.0 * TOLERANCE
            piece += 1


@pytest.mark.parametrize("seed", [0, 1])
def test_noise_of_a_centimetre_leaves_no_hole(seed: int, tmp_path: Path) -> None:
    known = house(4, 3, 2, noise=0.01, seed=seed)
    example, _, tilings, pieces = random_building(known, tmp_path, 4, 6, seed)
    done = closed(pieces, tilings, example.main.noise, was_closed=True)
    assert edge_numbers(done.surface).boundary == 0
    assert done.moved > 0
    assert 0.0 < done.farthest <= 0.05


def test_a_house_without_a_roof_makes_buildings_without_one(tmp_path: Path) -> None:
    known = house(4, 3, 2)
    top = known.points[:, 1].max()
    walls = known.triangles[~(known.points[known.triangles, 1] == top).all(axis=1)]
    known = House(known.points, walls, known.labels, known.pitch)
    example, _, tilings, pieces = random_building(known, tmp_path, 4, 6, 1)
    surface = closed(pieces, tilings, 0.0, was_closed=False).surface
    assert edge_numbers(surface).boundary == edge_numbers(example.surface).boundary
    open_ = open_points(surface)
    assert len(open_)
    assert open_[:, 1] == pytest.approx(surface.points[:, 1].max(), abs=1e-6)


@pytest.mark.parametrize("floor", [True, False])
def test_its_own_labels_make_the_same_building(floor: bool, tmp_path: Path) -> None:
    known = house(4, 3, 2, broad=((1, 2),))
    low = (known.points[known.triangles, 1] == 0.0).all(axis=1) & (not floor)
    known = House(known.points, known.triangles[~low], known.labels, known.pitch)
    example = analysed_once(read_mesh(known.write(tmp_path / "house.obj")))
    walls = example.regions
    sources = [sources_of(walls, (own,), each.grid) for own, each in enumerate(walls)]
    stretch = stretch_for(example, natural(walls, sources[0]), (None, None, None))
    tilings = [tile(walls, own, each.grid, sources[own], stretch) for own, each in enumerate(walls)]
    pieces = assemble(cut_up(example.surface, walls), tilings, stretch)
    surface = closed(pieces, tilings, 0.0, was_closed=floor).surface
    one, other = (trimesh.Trimesh(each.points, each.triangles) for each in (example.surface, surface))
    assert other.area == pytest.approx(one.area, rel=1e-5)
    assert other.volume == pytest.approx(one.volume, rel=1e-5)
    assert other.bounds - other.bounds[0] == pytest.approx(one.bounds - one.bounds[0], abs=1e-4)
    # An opening has the edges that it had; what cutting has put on them is gone.
    assert edge_numbers(surface).boundary == edge_numbers(example.surface).boundary
    assert (edge_numbers(surface).boundary == 0) == floor


def open_points(surface: Surface) -> np.ndarray:
    """Points of edges with only one triangle."""
    edges = np.sort(surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return surface.points[np.unique(unique[count == 1])]
