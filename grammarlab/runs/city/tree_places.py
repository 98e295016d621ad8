"""Where the trees of a city stand, and which of the grown trees of their species they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.city.packed_outlines import Outlines
from grammarlab.city.street_trees import street_tree_places
from grammarlab.city.tree_file import parse_trees
from grammarlab.city.tree_intensity import TreeIntensity, trees_in
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.area import Area
from grammarlab.randomness import root_keys
from grammarlab.runs.city.planted_parks import PlantedParks, PlantedTrees
from grammarlab.runs.city.survey import Survey
from grammarlab.runs.city.zone_rules import ZoneRules
from grammarlab.runs.sample.species_models import species_to_run
from grammarlab.scene import Scene
from grammarlab.trees.accepted_trees import accepted_rows
from grammarlab.trees.crown_reach import CrownReach
from grammarlab.trees.growth import grow
from grammarlab.trees.planting import HECTARE, Spacing, planted
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.species import Species

NUM_GROWN = 4
"""Number of trees of a species that are grown for a city; all others are instances of these."""
_CROWN_AREA = 1.5
"""Square metres of a park per square metre of crown, where a plan names no density."""
_DECIMALS = 2
"""Decimals of metres of the places of trees."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TreePlaces:
    """T trees of one species in one zone or along the streets."""

    rules: ZoneRules
    """The species."""
    place: Floats
    """[T, 3] bases of the trunks in metres of the frame: x east, y up, z south."""
    grown: Ints
    """[T] number of the grown tree, below `NUM_GROWN`."""

    def __len__(self) -> int:
        return len(self.place)


def tree_places(
    survey: Survey, zones: tuple[ZoneRules, ...], along_streets: ZoneRules | None, folder: Path | None = None
) -> list[TreePlaces]:
    """All trees of a city.

    Args:
        survey: the survey.
        zones: rules of the zones; those of species are parks.
        along_streets: the species along the streets, or the learned ones.
        folder: folder of the city, in which planted parks are kept; None if they are not.

    Raises:
        UsageError: If a park has more trees than can be planted at once, or learned trees are in another system.
    """
    parks = PlantedParks(folder)
    found = [
        places
        for number, rules in enumerate(zones)
        if rules.is_park
        for places in _in_parks(survey, number, rules, parks)
    ]
    parks.drop_others()
    trees = survey.plan.street_trees
    if trees is not None and along_streets is not None and survey.ground.streets is not None:
        points = street_tree_places(
            survey.ground.streets,
            survey.parcels.outline,
            spacing=trees.spacing,
            offset=trees.offset,
            least_width=trees.least_width,
        )
        found += _along_streets(survey, along_streets, points)
    return [places for places in found if len(places)]


def species_of(rules: ZoneRules) -> Species:
    """The species of a zone.

    Raises:
        LanguageError: If its file has mistakes.
    """
    return species_to_run(rules.text, rules.name)


def _outlines(survey: Survey, number: int) -> Outlines:
    """Parcels of a zone."""
    sites = survey.sites
    return survey.parcels.outline[sites.parcel[sites.zone == number]]


def _in_parks(survey: Survey, number: int, rules: ZoneRules, parks: PlantedParks) -> list[TreePlaces]:
    """Trees of all parks of a zone; a park keeps its trees whatever the others are."""
    outlines, frame = _outlines(survey, number), survey.parcels.frame
    if len(outlines) == 0:
        return []
    density = survey.plan.zones[number].trees_per_hectare
    seed = survey.plan.seed
    trees = parks.of_zone(
        number,
        (rules.name, rules.hash, seed, density, frame.crs, frame.origin),
        outlines,
        lambda: _learned(survey, outlines, rules) if rules.species else _of_one(survey, outlines, rules, density),
    )
    return _by_species(survey, rules.species or (rules,), trees.species, trees.east_north)


def _of_one(survey: Survey, outlines: Outlines, rules: ZoneRules, density: float | None) -> PlantedTrees:
    """Trees of one species in parks, by default as many as cover a share of them."""
    origin = np.array(survey.parcels.frame.origin)
    area = Area(tuple(shapely.transform(outlines, lambda points: points + origin)))
    crowns = CrownReach(species_of(rules), survey.plan.seed)
    spacing = Spacing(crowns, survey.plan.seed)
    if density is None:
        density = HECTARE / (_CROWN_AREA * np.pi * float((spacing.references**2).mean()))
    points = planted(area, spacing, density=density).coordinates - origin
    return PlantedTrees(np.zeros(len(points), np.int64), points)


def _learned(survey: Survey, outlines: Outlines, rules: ZoneRules) -> PlantedTrees:
    """Trees of learned species in parks, as many as were learned."""
    intensity, shift = _placed(survey, rules)
    area = shapely.union_all(shapely.transform(outlines, lambda points: points + shift))
    radii = [_crown(species, survey.plan.seed) for species in rules.species]
    trees = trees_in(area, intensity, radii, survey.plan.seed)
    return PlantedTrees(trees.species, trees.east_north - shift)


def _along_streets(survey: Survey, rules: ZoneRules, points: Floats) -> list[TreePlaces]:
    """Trees at places along streets [n, 2], of one species or of learned ones."""
    if not rules.species:
        return [_places(survey, rules, points)]
    intensity, shift = _placed(survey, rules)
    points = np.round(points, _DECIMALS)
    ids = np.array(_texts(points + survey.parcels.frame.origin), object)
    return _by_species(survey, rules.species, intensity.species_at(points + shift, ids, survey.plan.seed), points)


def _placed(survey: Survey, rules: ZoneRules) -> tuple[TreeIntensity, Floats]:
    """The intensity of learned trees, and the metres [2] to add to places of the survey.

    Raises:
        UsageError: If it was learned in another coordinate system.
    """
    intensity, frame = parse_trees(rules.text.encode()), survey.parcels.frame
    if intensity.frame.crs != frame.crs:
        raise UsageError(
            f"{rules.name}: the trees were learned in {intensity.frame.crs or 'local metres'}, and the parcels are in "
            f"{frame.crs or 'local metres'}: give the map the same `crs`, or learn the trees again."
        )
    return intensity, np.subtract(frame.origin, intensity.frame.origin)


def _by_species(survey: Survey, species: Sequence[ZoneRules], number: Ints, points: Floats) -> list[TreePlaces]:
    """Trees [n] by the numbers of their species."""
    return [_places(survey, rules, points[number == row]) for row, rules in enumerate(species)]


@lru_cache(maxsize=64)
def _crown(rules: ZoneRules, seed: int) -> float:
    """Mean radius in metres of the crowns of a species."""
    return float(Spacing(CrownReach(species_of(rules), seed), seed).references.mean())


def _places(survey: Survey, rules: ZoneRules, points: Floats) -> TreePlaces:
    """Trees at points [n, 2] east and north, on the ground, ordered by place."""
    points = np.round(points, _DECIMALS) + 0.0
    points = points[np.lexsort(points.T)]
    heights = survey.heights(points)
    place = np.column_stack([points[:, 0], heights, -points[:, 1]])
    return TreePlaces(rules=rules, place=place, grown=_grown(rules, points + survey.parcels.frame.origin))


def _grown(rules: ZoneRules, points: Floats) -> NDArray[np.int64]:
    """[n] numbers of grown trees, by places on the earth."""
    digests = b"".join(sha256(f"{rules.name}\0{text}".encode()).digest()[:8] for text in _texts(points))
    return (np.frombuffer(digests, ">u8") % NUM_GROWN).astype(np.int64)


def _texts(points: Floats) -> list[str]:
    """Places [n, 2] on the earth as texts, to the centimetre."""
    return [f"{east:.2f}\0{north:.2f}" for east, north in points.tolist()]


@lru_cache(maxsize=64)
def grown_cards(rules: ZoneRules, seed: int) -> Scene:
    """The `NUM_GROWN` trees of a species as cards, one model each.

    Args:
        rules: the species.
        seed: seed of the city.
    """
    species = species_of(rules)
    trees = accepted_rows(species, root_keys(seed, np.arange(NUM_GROWN, dtype=np.uint64)))
    return realize_trees(grow(trees.rows, trees.keys), species.look, "cards", rules.assets)
