"""Runs of species: a tree is the same however its run is cut, interrupted or repeated."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import trimesh

import grammarlab as gl
from grammarlab.errors import AssetError, UsageError
from grammarlab.randomness import root_keys
from grammarlab.runs.sample import species_models
from grammarlab.runs.sample.domains import CONVERTED, domain_of, opened_models
from grammarlab.runs.sample.manifest import read_manifest
from grammarlab.runs.sample.models import cut_batches
from grammarlab.runs.sample.records import StoredScenes
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import RunResult, repeat_run, sample_run
from grammarlab.runs.sample.shipped import find_rules, shipped_examples, shipped_species
from grammarlab.runs.sample.sources import ShippedGrammar, ShippedSpecies
from grammarlab.runs.sample.species_models import checked_value, with_attributes
from grammarlab.runs.sample.tree_table import TREES, TreeTable
from grammarlab.runs.work.executors import SERIAL, Processes
from grammarlab.trees.measures import MEASURES
from grammarlab.trees.parameters import COLUMN, COLUMNS
from grammarlab.trees.species import drawn
from grammarlab.trees.species_file import parse
from tests.trees.small_species import SMALL

Sample = Callable[..., RunResult]


@pytest.fixture
def species(tmp_path: Path) -> Path:
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


@pytest.fixture
def sample(species: Path, tmp_path: Path) -> Sample:
    """Sample the small species into a folder of a name."""

    def run(folder: str, *, executor: Any = SERIAL, resume: bool = False, **options: Any) -> RunResult:
        options = {"seed": 3, "image": False, **options}
        request = SampleRequest.of(species, **options)
        return sample_run(request, tmp_path / folder, executor=executor, resume=resume)

    return run


def contents(result: RunResult) -> dict[str, bytes]:
    """The files of the models of a run by name."""
    return {model.file: (result.folder / model.file).read_bytes() for model in result.models}


def trees_of(result: RunResult) -> TreeTable:
    folders = sorted(path.parent for path in result.derivations.glob(f"*/{TREES}"))
    return TreeTable.joined([TreeTable.load(folder) for folder in folders])


def test_a_tree_is_the_same_alone_in_a_batch_and_in_another_process(sample: Sample):
    alone = contents(sample("alone", num_models=2))
    together = contents(sample("together", num_models=67))
    elsewhere = contents(sample("elsewhere", num_models=67, executor=Processes(2)))
    assert alone.items() <= together.items()
    assert together == elsewhere
    assert len(set(together.values())) == 67


def test_trees_do_not_depend_on_the_parts_that_are_in_memory_together(sample: Sample, monkeypatch: pytest.MonkeyPatch):
    whole = contents(sample("whole", num_models=9))
    monkeypatch.setattr(species_models, "_MAX_NODES", 1)
    parts = sample("parts", num_models=9)
    assert contents(parts) == whole
    scenes = list(StoredScenes(parts.request, parts.folder, cut_batches(parts.request)))
    assert [scene.num_models for scene in scenes] == [1] * 9


def test_an_interrupted_run_goes_on_to_the_same_files(sample: Sample):
    result = sample("run", num_models=5, image=True)
    before = {path.name: path.read_bytes() for path in result.folder.iterdir() if path.is_file()}
    (result.folder / "small-00003.glb").unlink()
    (result.folder / "small.png").unlink()
    again = sample("run", num_models=5, image=True, resume=True)
    after = {path.name: path.read_bytes() for path in again.folder.iterdir() if path.is_file()}
    assert after == before
    with pytest.raises(UsageError, match="attributes was"):
        sample("run", num_models=5, image=True, resume=True, attributes={"scale": 4.0})


def test_a_manifest_repeats_a_run_bit_for_bit(sample: Sample, tmp_path: Path):
    result = sample("first", num_models=3, attributes={"scale": 4.0, "detail": "low"})
    _, different = repeat_run(read_manifest(result.manifest), tmp_path / "second")
    assert not different


def test_a_manifest_has_the_measures_of_every_tree(sample: Sample):
    result = sample("run", num_models=4)
    models = json.loads(result.manifest.read_text())["models"]
    for model in models:
        assert tuple(model["reports"]) == tuple(MEASURES)
        assert model["reports"]["height"]["count"] == 1
        assert model["shapes"] == 1 + model["reports"]["num_stems"]["mean"] - 1 + model["reports"]["num_leaves"]["mean"]
        scene = trimesh.load_scene(result.folder / model["file"])
        assert scene.extents[1] == pytest.approx(model["reports"]["height"]["mean"], rel=0.1)


def test_a_value_of_an_attribute_changes_no_other_parameter(sample: Sample):
    plain, fixed = (
        trees_of(sample("plain", num_models=8)),
        trees_of(sample("fixed", num_models=8, attributes={"scale": 4.0})),
    )
    others = np.arange(len(COLUMNS)) != COLUMN["scale"]
    assert (fixed.rows[:, COLUMN["scale"]] == 4.0).all()
    assert np.array_equal(plain.rows[:, others], fixed.rows[:, others])
    assert np.array_equal(plain.key, fixed.key)
    assert np.array_equal(plain.key, root_keys(3, np.arange(8)))
    assert np.array_equal(plain.rows, drawn(parse(SMALL, "small"), plain.key)[0])


def test_leaves_change_no_stem(sample: Sample):
    with_leaves, bare = (
        json.loads(sample(name, num_models=3, attributes=attributes).manifest.read_text())["models"]
        for name, attributes in (("leafy", {}), ("bare", {"leaves": 0.0}))
    )
    for one, other in zip(with_leaves, bare, strict=True):
        assert one["reports"]["num_stems"] == other["reports"]["num_stems"]
        assert other["reports"]["num_leaves"]["mean"] == 0.0 < one["reports"]["num_leaves"]["mean"]


def test_coarser_trees_have_the_measures_of_the_full_ones(sample: Sample):
    runs = [sample(detail, num_models=3, attributes={"detail": detail}) for detail in ("full", "medium", "low")]
    reports = [[model.reports for model in run.models] for run in runs]
    assert reports[0] == reports[1] == reports[2]
    triangles = np.array([[model.triangles for model in run.models] for run in runs])
    assert (np.diff(triangles, axis=0) < 0).all()


def test_all_trees_in_one_file_are_those_of_the_single_files(sample: Sample):
    single = sample("single", num_models=3, single_file=True)
    assert [model.triangles for model in single.models] == [m.triangles for m in sample("each", num_models=3).models]
    assert len(list(single.folder.glob("*.glb"))) == 1


def test_a_tree_stands_in_the_middle_of_its_footprint_with_the_values_of_the_map(species: Path, tmp_path: Path):
    corners = [(100, 0), (110, 0), (110, -20), (100, -20)]
    entries = [
        {
            "type": "Feature",
            "properties": properties,
            "geometry": {"type": "Polygon", "coordinates": [[(x + shift, y) for x, y in [*corners, corners[0]]]]},
        }
        for shift, properties in ((0, {"scale": "4 m", "name": "lime"}), (50, {"scale": 900.0, "detail": "low"}))
    ]
    file = tmp_path / "lots.geojson"
    crs = {"type": "name", "properties": {"name": "EPSG:25832"}}
    file.write_text(json.dumps({"type": "FeatureCollection", "features": entries, "crs": crs}))
    request = SampleRequest.of(species, footprint=str(file), image=False)
    result = sample_run(request, tmp_path / "out")
    trees = trees_of(result)
    assert np.ptp(trees.position, axis=0) == pytest.approx([50.0, 0.0, 0.0])
    assert [model.origin for model in result.models] == [tuple(place) for place in trees.position.tolist()]
    assert trees.rows[0, COLUMN["scale"]] == 4.0 != trees.rows[1, COLUMN["scale"]]
    assert trees.detail == ("full", "low")
    assert [remark.kind for remark in result.request.remarks] == ["property"]
    assert "expected 0.05 to 120 m" in result.request.remarks[0].reason


def test_trees_on_disk_are_equal_to_the_last_bit(sample: Sample, tmp_path: Path):
    trees = trees_of(sample("run", num_models=5))
    trees.save(tmp_path / "copy")
    again = TreeTable.load(tmp_path / "copy")
    for name in TreeTable.__dataclass_fields__:
        assert np.array_equal(getattr(again, name), getattr(trees, name)), name


def _with(trees: TreeTable, name: str, value: float) -> TreeTable:
    rows = trees.rows.copy()
    rows[1, COLUMN[name]] = value
    return replace(trees, rows=rows)


@pytest.mark.parametrize(
    "change",
    [
        lambda trees: _with(trees, "scale", np.nan),
        lambda trees: _with(trees, "branches_1", 1e9),
        lambda trees: _with(trees, "levels", 2.5),
        lambda trees: replace(trees, position=trees.position + np.inf),
    ],
)
def test_damaged_trees_are_refused(change: Callable[[TreeTable], TreeTable], sample: Sample, tmp_path: Path):
    change(trees_of(sample("run", num_models=3))).save(tmp_path / "bad")
    with pytest.raises(AssetError, match="the trees are damaged"):
        TreeTable.load(tmp_path / "bad")
    file = tmp_path / "bad" / TREES
    table = pq.read_table(file)
    for name, column in (("detail", [9] * 3), ("scale", ["4"] * 3), ("position", [[0.0] * 4] * 3), ("key", [None] * 3)):
        index = table.column_names.index(name)
        kind = table.schema.field(name).type if name in ("detail", "key") else None
        pq.write_table(table.set_column(index, name, pa.array(column, kind)), file)
        with pytest.raises(AssetError, match="the trees are damaged"):
            TreeTable.load(tmp_path / "bad")
    (tmp_path / "bad" / TREES).write_bytes(b"PAR1")
    with pytest.raises(AssetError, match="the trees are damaged"):
        TreeTable.load(tmp_path / "bad")
    (tmp_path / "bad" / TREES).unlink()
    with pytest.raises(AssetError, match="is missing"):
        TreeTable.load(tmp_path / "bad")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("scal", 12.0, r"unknown attribute 'scal'\. Did you mean 'scale'\?"),
        ("scale", 500.0, "'scale': expected 0.05 to 120 m, found '500.0'"),
        ("scale", "tall", "found 'tall'"),
        ("scale", True, "found 'True'"),
        ("scale", float("nan"), "found 'nan'"),
        ("levels", 9.0, "expected a whole number from 1 to 4"),
        ("levels", 1.5, "expected a whole number from 1 to 4"),
        ("curve_1_v", 900.0, "expected -720 to 720 deg"),
        ("detail", "lo", "expected one of full, medium, low, cards"),
    ],
)
def test_impossible_attributes_are_explained(name: str, value: float | str | bool, message: str):
    with pytest.raises(UsageError, match=message):
        checked_value(name, value)


def test_unknown_attributes_are_explained_before_anything_is_drawn(sample: Sample, tmp_path: Path):
    for name in ("scal", "leaf"):
        with pytest.raises(UsageError, match="unknown attribute"):
            with_attributes(parse(SMALL, "small"), {"scale": 4.0, name: 3.0})
        with pytest.raises(UsageError, match="unknown attribute"):
            sample("run", attributes={name: 3.0})
    with pytest.raises(UsageError, match="no rules; leave it out"):
        sample("run", start_rule="Lot")
    assert not (tmp_path / "run").exists()


def test_lengths_may_have_units():
    assert checked_value("scale", "40 ft") == pytest.approx(12.192)
    assert checked_value("levels", "3") == 3.0


def test_an_invalid_acceptance_rule_is_an_error_with_its_line(species: Path):
    species.write_text(f'acceptance = "$scal < 4"\n{SMALL}')
    with pytest.raises(gl.GrammarlabError, match=r"small\.toml:1:1: error: .*scale"):
        gl.load(species)


def test_trees_are_accepted_by_the_rule_of_their_species(species: Path, sample: Sample):
    species.write_text(f'acceptance = "choose($scale < 4, 1, 0)"\n{SMALL}')
    result = sample("run", num_models=12)
    assert (trees_of(result).rows[:, COLUMN["scale"]] < 4.0).all()
    assert result.accept_rate is not None
    assert 0.05 < result.accept_rate < 0.6
    stored = list(StoredScenes(result.request, result.folder, cut_batches(result.request)))
    assert sum(scene.num_models for scene in stored) == 12


def test_shipped_examples_have_the_names_that_type_checkers_know():
    for names, sources in ((ShippedGrammar, shipped_examples()), (ShippedSpecies, shipped_species())):
        assert sorted(names.__args__) == [source.name for source in sources]


@pytest.mark.parametrize("source", shipped_species(), ids=lambda source: source.name)
def test_every_shipped_species_is_found_by_name_and_says_what_it_is(source: Any):
    assert find_rules(source.name) == source
    assert 20 < len(source.description()) < 160
    loaded = gl.load(source.name)
    assert (loaded.name, loaded.assets) == (source.name, source.assets)


def test_files_of_arbaro_are_species(species: Path, tmp_path: Path):
    file = tmp_path / "small.xml"
    file.write_text(domain_of(".toml").formatted(SMALL, "small.toml", ".xml"))
    source = find_rules(str(file))
    assert source.suffix == CONVERTED[".xml"] == ".toml"
    models = opened_models(source.suffix, source.text(), source.name, source.assets)
    assert np.array_equal(models.species.typical, parse(SMALL, "small").typical)
    result = sample_run(SampleRequest.of(file, num_models=2, image=False), tmp_path / "out")
    _, different = repeat_run(read_manifest(result.manifest), tmp_path / "again")
    assert not different
