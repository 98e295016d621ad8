"""Learning which species of trees stand where in a city, and how densely, from a map of trees."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from grammarlab.arrays import Floats
from grammarlab.city.map_shapes import read_shapes
from grammarlab.city.plan import Plan, read_plan
from grammarlab.city.polygon_text import is_polygon_text, polygon_of_text
from grammarlab.city.tree_file import save_trees
from grammarlab.city.tree_intensity import TreeIntensity
from grammarlab.city.tree_learning import learned_intensity
from grammarlab.city.tree_map import MappedTrees, read_mapped_trees
from grammarlab.city.tree_map_plan import SUFFIX, TreeMapPlan, is_tree_file
from grammarlab.city.tree_names import SpeciesNames
from grammarlab.errors import AssetError, UsageError
from grammarlab.files import check_overwrites
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.survey import ground_of
from grammarlab.runs.sample.domains import SPECIES
from grammarlab.runs.sample.shipped import find_rules, shipped_species
from grammarlab.trees.planting import HECTARE

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

AROUND = 500.0
"""Metres around the parcels: trees farther away say little about those in the city."""
NEAR = 50.0
"""Metres around each tree in which a map has all trees, unless the plan says where it has them: both sides of a street.
"""
_MOST_NAMES = 8
"""Largest number of names that are listed."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TreesResult:
    """A learned intensity with what is known about it."""

    file: Path
    intensity: TreeIntensity
    trees: dict[str, int]
    """Trees by species, as the plan names them, most first."""
    hectares: float
    """Area that was learned from."""
    unknown: dict[str, int]
    """Trees in the area by names that are no species of the plan, most first; these trees are left out."""
    num_outside: int
    """Trees outside the area."""
    seconds: float

    def as_json(self) -> dict[str, Any]:
        """The result as plain values, for ``--json``."""
        return {
            "file": str(self.file),
            "trees": self.trees,
            "hectares": round(self.hectares, 2),
            "unknown": self.unknown,
            "outside": self.num_outside,
            "seconds": round(self.seconds, 3),
        }


def learn_trees(plan: Path, output: Path | None = None) -> TreesResult:
    """Learn the intensities of species from the map of trees of a plan, and write their file.

    Args:
        plan: file of the plan.
        output: file to write; None for the one that the plan names, or else the plan's name with `SUFFIX`.

    Raises:
        GrammarlabError: If the plan or one of its files cannot be used, or the map has no tree of a known species.
    """
    start = perf_counter()
    read = read_plan(plan)
    tree_map = read.tree_map
    if tree_map is None:
        raise UsageError(f'{plan}: expected a map of trees, found none: give [tree_map] with file = "FILE".')
    output = _output(read) if output is None else output
    check_overwrites([output], [plan, tree_map.file, *([read.parcels] if read.parcels else [])])
    names = _names(tree_map)
    parcels = ground_of(read).parcels
    around = shapely.buffer(shapely.box(*shapely.total_bounds(parcels.outline)), AROUND, join_style="mitre")
    every = read_mapped_trees(tree_map.file, tree_map.field, parcels.frame)
    area = _area(tree_map, every, around, parcels.frame)
    inside = np.asarray(shapely.contains_xy(area, *every.east_north.T), np.bool_)
    mapped = MappedTrees(every.east_north[inside], every.name[inside])
    if not len(mapped):
        raise AssetError(f"{tree_map.file}: expected trees within {AROUND:g} m of the parcels, found none.")
    species = np.array([names.of(name) or "" for name in mapped.name.tolist()], object)
    unknown = Counter(mapped.name[species == ""].tolist())
    if (species == "").all():
        raise AssetError(_no_species(tree_map, unknown))
    known = species != ""
    labels = np.array([_label(name, output) for name in species[known].tolist()], object)
    intensity = learned_intensity(mapped.east_north[known], labels, area, parcels.frame)
    save_trees(intensity, output)
    return TreesResult(
        file=output,
        intensity=intensity,
        trees=dict(Counter(species[known].tolist()).most_common()),
        hectares=float(area.area) / HECTARE,
        unknown=dict(unknown.most_common()),
        num_outside=int((~inside).sum()),
        seconds=perf_counter() - start,
    )


def _output(plan: Plan) -> Path:
    grammars = [zone.grammar for zone in plan.zones] + ([plan.street_trees.species] if plan.street_trees else [])
    named = {Path(grammar) for grammar in grammars if is_tree_file(grammar)}
    if len(named) > 1:
        listing = ", ".join(sorted(path.name for path in named))
        raise UsageError(
            f"{plan.path}: it names several files of trees ({listing}): give `--output`, the one to learn."
        )
    return named.pop() if named else plan.path.with_name(plan.path.stem + SUFFIX)


def _names(tree_map: TreeMapPlan) -> SpeciesNames:
    """The names of species; those of the plan must be species.

    Raises:
        UsageError: If one is not.
    """
    for name in tree_map.species:
        if find_rules(name).suffix != SPECIES:
            raise UsageError(f"tree map: expected a species, found the rules {name!r}.")
    shipped = {source.name: (source.name,) for source in shipped_species()}
    return SpeciesNames(tree_map.species or shipped)


def _label(species: str, output: Path) -> str:
    """A species as a file of trees names it: a shipped one, or a path from the folder of the file."""
    if not Path(species).suffix:
        return species
    return Path(os.path.relpath(Path(species).resolve(), output.resolve().parent)).as_posix()


def _area(tree_map: TreeMapPlan, trees: MappedTrees, around: BaseGeometry, frame: Frame) -> BaseGeometry:
    """Where the map has all trees, in metres of the frame."""
    if not tree_map.area:
        near = trees.east_north[np.asarray(shapely.contains_xy(around, *trees.east_north.T))]
        return shapely.intersection(_surroundings(near), around)
    if is_polygon_text(tree_map.area):
        area = polygon_of_text(tree_map.area, frame)
    else:
        area = shapely.union_all(read_shapes(Path(tree_map.area), frame).geometry)
    return shapely.intersection(area, around)


def _surroundings(points: Floats) -> BaseGeometry:
    """What is near points [n, 2]."""
    circles = shapely.buffer(np.array(shapely.points(points), dtype=object), NEAR, quad_segs=4)
    return shapely.union_all(circles)


def _no_species(tree_map: TreeMapPlan, unknown: Counter[str]) -> str:
    names = listed(unknown.most_common())
    first = next((name for name, _ in unknown.most_common() if name), "NAME")
    return (
        f"{tree_map.file}: expected the names of species of the plan in the field {tree_map.field!r}, found {names}. "
        f'Say which they are: [tree_map.species] oak = ["{first}"].'
    )


def listed(counts: Iterable[tuple[str, int]]) -> str:
    """The first names with their numbers, in words.

    >>> listed([("Tilia", 12), ("", 3)])
    "'Tilia' (12), none (3)"
    """
    pairs = list(counts)
    names = [f"{repr(name[:40]) if name else 'none'} ({number:,})" for name, number in pairs[:_MOST_NAMES]]
    return ", ".join([*names, *(["…"] if len(pairs) > _MOST_NAMES else [])])
