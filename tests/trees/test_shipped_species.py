"""Every shipped species is a file without a remark, whose trees grow and have meshes."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from grammarlab.randomness import root_keys
from grammarlab.scene import triangles
from grammarlab.trees.accepted_trees import accepted_rows
from grammarlab.trees.growth import grow
from grammarlab.trees.measures import MEASURES, measure
from grammarlab.trees.parameters import COLUMNS, PARAMETERS
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.species import Species, drawn
from grammarlab.trees.species_file import check, parse, write
from grammarlab.trees.species_tables import SECTIONS

FOLDER = Path(__file__).parents[2] / "grammars" / "species"
PRIOR = "any"
"""Wide limits that include all species, most of whose trees are implausible."""
NAMES = sorted(path.stem for path in FOLDER.glob("*.toml") if path.stem != PRIOR)
NUM_TREES = 6
HABITS = {
    "apple": {"height": (3.0, 8.0), "crown_ratio": (1.0, 2.0)},
    "birch": {"height": (9.0, 21.0), "crown_ratio": (0.4, 0.85)},
    "oak": {"height": (8.0, 18.0), "crown_ratio": (0.9, 1.4)},
    "palm": {"height": (6.0, 17.0), "num_stems": (15, 60)},
    "poplar": {"height": (15.0, 31.0), "crown_ratio": (0.1, 0.3)},
    "shrub": {"height": (2.0, 6.5), "clear_stem": (0.0, 0.8)},
    "spruce": {"height": (10.0, 24.0), "crown_ratio": (0.3, 0.55)},
    "weeping_willow": {"height": (8.0, 18.0), "crown_ratio": (0.9, 1.5)},
}
"""What a landscape architect knows of each: heights in metres, width by height of the crown."""


def text_of(name: str) -> str:
    return (FOLDER / f"{name}.toml").read_text(encoding="utf-8")


@cache
def species_of(name: str) -> Species:
    return parse(text_of(name), name)


@cache
def trees_of(name: str) -> Skeleton:
    trees = accepted_rows(species_of(name), root_keys(7, np.arange(NUM_TREES)))
    return grow(trees.rows, trees.keys)


def test_there_are_eight_species():
    assert set(NAMES) == set(HABITS)


@pytest.mark.parametrize("name", NAMES)
def test_a_species_is_canonical_and_gives_a_reason_for_every_value(name: str):
    assert check(text_of(name), name) == ()
    assert write(species_of(name)) == text_of(name)
    lines = text_of(name).splitlines()
    named = {line.split(" = ")[0] for line in lines if line.split(" = ")[0] in PARAMETERS}
    assert named == set(species_of(name).why)
    assert [line[1:-1] for line in lines if line.startswith("[")] == [
        section for section in ("look", *SECTIONS) if f"[{section}]" in lines
    ]


@pytest.mark.parametrize("name", NAMES)
def test_the_prior_includes_the_species(name: str):
    low, high = (np.array([getattr(kind, end) for kind in species_of(PRIOR).kinds]) for end in ("low", "high"))
    for kind in species_of(name).kinds:
        outside = (kind.low < low.min(axis=0)) | (kind.high > high.max(axis=0))
        assert [COLUMNS[index] for index in np.flatnonzero(outside)] == []


@pytest.mark.parametrize("name", NAMES)
def test_trees_have_the_habit_of_their_species(name: str):
    values = dict(zip(MEASURES, measure(trees_of(name)).T, strict=True))
    for key, (low, high) in HABITS[name].items():
        assert ((low <= values[key]) & (values[key] <= high)).all(), (key, values[key])
    assert (values["lowest"] >= -0.01).all()
    assert (values["num_stems"] <= 12_000).all()


@pytest.mark.parametrize("name", NAMES)
def test_trees_of_a_species_differ(name: str):
    heights = trees_of(name).scale
    assert len(np.unique(heights)) == NUM_TREES
    assert np.ptp(heights) > 0.1 * heights.mean()
    rows, _ = drawn(species_of(name), root_keys(7, np.arange(200)))
    assert (np.ptp(rows, axis=0) > 0.0).sum() >= 8


@pytest.mark.parametrize("name", NAMES)
def test_trees_have_meshes_of_all_details(name: str):
    rows, _ = drawn(species_of(name), root_keys(7, np.arange(1)))
    tree = grow(rows, root_keys(7, np.arange(1)))
    full, low = (triangles(realize_trees(tree, species_of(name).look, detail)) for detail in ("full", "low"))
    assert np.isfinite(full.vertices).all()
    assert len(low.triangles) < 0.3 * len(full.triangles)
    assert np.allclose(np.ptp(full.vertices, axis=0), np.ptp(low.vertices, axis=0), rtol=0.1)
