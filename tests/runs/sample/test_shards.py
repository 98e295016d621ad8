"""Runs without model files: rows are those of derivations, whoever makes them, and what is finished stays."""

from __future__ import annotations

import json
import pickle
import re
import tracemalloc
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pyarrow.parquet as pq
import pytest
from fsspec import register_implementation
from fsspec.implementations.memory import MemoryFileSystem

from grammarlab.derivation.derive import derive
from grammarlab.errors import AssetError, UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.randomness import root_keys
from grammarlab.runs.sample.grammar_models import summarize_reports
from grammarlab.runs.sample.model_rows import FORMAT
from grammarlab.runs.sample.models import models_of
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.shard_plan import ShardPlan, file_name
from grammarlab.runs.sample.shard_run import ShardRecord, sample_shards
from grammarlab.runs.sample.species_models import SpeciesModels
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.runs.work.machine import this_machine
from grammarlab.runs.work.shard_store import FolderStore, UrlStore, store_at
from grammarlab.trees.accepted_trees import accepted_rows, log_density
from grammarlab.trees.parameters import COLUMNS

TEXT = """
attr height = rand(3, 9)
Lot --> extrude(height) report("height", height) split(y) { ~3: Floor }*
Floor --> 50%: Wall report("area", scope.sx) report("area", 2 * scope.sx) else: NIL
"""
REQUEST = SampleRequest(name="tower", text=TEXT, assets=Path(), num_models=25, seed=3, image=False)


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_rows_are_those_of_the_derivations(tmp_path: Path):
    result = sample_shards(REQUEST, tmp_path, shard_models=10)
    assert (result.plan.num_shards, result.num_made) == (3, 3)
    forest = derive(Grammar.parse(TEXT), 25, seed=3)
    table = pq.read_table(tmp_path / "shards")
    assert table["model"].to_pylist() == list(range(25))
    assert set(table["seed"].to_pylist()) == {3}
    assert table["log_density"].to_pylist() == forest.log_probability().tolist()
    assert table["shapes"].to_pylist() == forest.shapes_per_model().tolist()
    for number, symbol in enumerate(forest.symbols):
        rows = forest.nodes.model[forest.nodes.symbol == number]
        assert table[f"count.{symbol}"].to_pylist() == np.bincount(rows, minlength=25).tolist()
    model = forest.nodes.model[forest.draws.node]
    for name in ("site", "value", "log_density"):
        column = getattr(forest.draws, name)
        expected = [column[model == k].tolist() for k in range(25)]
        assert [[draw[name] for draw in draws] for draws in table["draws"].to_pylist()] == expected
    for reports, summary in zip(table["reports"].to_pylist(), summarize_reports(forest), strict=True):
        assert [report["key"] for report in reports] == list(summary)
        for report in reports:
            assert {name: report[name] for name in ("count", "min", "max")}.items() <= summary[report["key"]].items()
            assert report["sum"] == pytest.approx(summary[report["key"]]["sum"], rel=1e-15)
    index = pq.read_table(tmp_path / "index.parquet").to_pylist()
    assert [(row["file"], row["first_model"], row["num_models"]) for row in index] == [
        (f"shards/{file_name(k)}", 10 * k, min(10, 25 - 10 * k)) for k in range(3)
    ]
    assert [row["num_bytes"] for row in index] == [(tmp_path / row["file"]).stat().st_size for row in index]
    plan = json.loads((tmp_path / "run.json").read_text())
    assert (plan["complete"], plan["machine"]) == (True, this_machine().as_json())
    assert [site["kind"] for site in plan["legend"]["sites"]] == [site.kind for site in forest.sites]


def test_the_page_of_clusters_describes_every_column_and_its_type(tmp_path: Path):
    """Columns are found by name and type, or by the part before a dot for those of symbols and parameters."""
    page = (Path(__file__).parents[3] / "docs" / "grammars" / "clusters.md").read_text()
    assert f"Version {FORMAT} of the columns" in page
    rows = [line.split("|")[1:3] for line in page.splitlines() if line.startswith("| `")]
    types = {name: cells[1].strip() for cells in rows for name in re.findall(r"`([\w.]+)`", cells[0])}
    for request in (REQUEST, SampleRequest.of("birch", num_models=1, image=False)):
        sample_shards(request, tmp_path / request.name, shard_models=25)
        schema = pq.read_schema(tmp_path / request.name / "shards" / file_name(0))
        assert schema.metadata[b"grammarlab.format"] == str(FORMAT).encode()
        for field in schema:
            name = field.name if field.name in types else f"{field.name.partition('.')[0]}.SYMBOL"
            if field.name.startswith(("position.", "parameter.", "kind", "heading")):
                continue  # described in a sentence
            assert str(field.type).partition("<")[0] in types[name], field


def test_what_is_finished_stays_and_what_is_missing_is_made(tmp_path: Path):
    sample_shards(REQUEST, tmp_path, shard_models=10)
    before = files(tmp_path)
    (tmp_path / "shards" / file_name(1)).unlink()
    (tmp_path / "index.parquet").unlink()
    assert sample_shards(REQUEST, tmp_path, shard_models=10).num_made == 1
    assert sample_shards(REQUEST, tmp_path, shard_models=10).num_made == 0
    assert files(tmp_path) == before


@pytest.mark.parametrize(
    ("request_", "shard_models", "message"),
    [
        (replace(REQUEST, seed=4), 10, "seed was 3 and is 4"),
        (replace(REQUEST, text=TEXT + "// more"), 10, "the file of the models differs"),
        (REQUEST, 9, "shards had 10 models and have 9"),
    ],
)
def test_another_run_is_refused(tmp_path: Path, request_: SampleRequest, shard_models: int, message: str):
    plan = ShardPlan(request=REQUEST, asset_files={}, machine=this_machine(), shard_models=10)
    (tmp_path / "run.json").write_text(plan.to_text())
    with pytest.raises(UsageError, match=f"holds another run: {message}.*-o"):
        sample_shards(request_, tmp_path, shard_models=shard_models)


def test_shards_of_another_machine_are_not_mixed_with_those_of_this_one(tmp_path: Path):
    machine = replace(this_machine(), processor={"instructions": "X86_V2", "BLAS": "Haswell"})
    plan = ShardPlan(request=REQUEST, asset_files={}, machine=machine, shard_models=10)
    (tmp_path / "run.json").write_text(plan.to_text())
    with pytest.raises(UsageError, match=r"not X86_V2 as before.*NPY_DISABLE_CPU_FEATURES"):
        sample_shards(REQUEST, tmp_path, shard_models=10)


@pytest.mark.parametrize("content", ["", "[]", '{"format": 99}', '{"format": 1}', "[" * 100_000, '{"format": 1e999}'])
def test_a_plan_of_a_stranger_is_refused(tmp_path: Path, content: str):
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(AssetError, match=r"run\.json: "):
        sample_shards(REQUEST, tmp_path)


def test_shards_without_a_plan_are_refused(tmp_path: Path):
    (tmp_path / "shards").mkdir()
    (tmp_path / "shards" / file_name(0)).write_text("?")
    with pytest.raises(UsageError, match=r"no run\.json"):
        sample_shards(REQUEST, tmp_path)


class Refusing(MemoryFileSystem):
    """A store that takes a number of files, and then none."""

    protocol = "refusing"
    left: ClassVar[list[int]] = [0]

    def pipe_file(self, path: str, value: bytes, *options: Any, **named: Any) -> None:
        # As file systems of fsspec do that cannot create a file only if there is none; the code under test expects it.
        if "mode" in named:
            raise NotImplementedError
        if not self.left[0]:
            raise ConnectionResetError("the store does not answer")
        self.left[0] -= 1
        super().pipe_file(path, value, *options, **named)


def stored_files() -> dict[str, bytes]:
    prefix = "refusing://run/"
    return {
        path.removeprefix(prefix): file.getvalue()
        for path, file in MemoryFileSystem.store.items()
        if path.startswith(prefix)
    }


def test_a_store_that_refuses_keeps_what_it_has(tmp_path: Path):
    register_implementation("refusing", Refusing, clobber=True)
    Refusing.left[0] = 3  # the plan and two shards
    with pytest.raises(OSError, match=r"ConnectionResetError: the store does not answer") as raised:
        sample_shards(REQUEST, "refusing://run", shard_models=5)
    assert str(raised.value.filename) == "refusing://run/shards/0000002.parquet"
    assert len(stored_files()) == 3
    Refusing.left[0] = 10
    assert sample_shards(REQUEST, "refusing://run", shard_models=5).num_made == 3
    sample_shards(REQUEST, tmp_path, shard_models=5)
    assert stored_files() == files(tmp_path)
    with pytest.raises(UsageError, match="expected a folder or a URL that fsspec can open"):
        sample_shards(REQUEST, "nowhere://run")


def test_of_two_runs_that_begin_at_once_in_a_store_one_is_refused(monkeypatch: pytest.MonkeyPatch):
    sample_shards(REQUEST, "memory://begun", shard_models=5)
    before = dict(MemoryFileSystem.store)
    read, num_reads = UrlStore.read, 0

    def late(store: UrlStore, name: str, most: int) -> bytes | None:
        nonlocal num_reads
        num_reads += 1
        return None if num_reads == 1 else read(store, name, most)

    monkeypatch.setattr(UrlStore, "read", late)
    monkeypatch.setattr(UrlStore, "sizes", lambda *_: iter(()))
    with pytest.raises(UsageError, match="memory://begun holds another run: seed was 3 and is 4"):
        sample_shards(replace(REQUEST, seed=4), "memory://begun", shard_models=5)
    assert MemoryFileSystem.store == before


def test_a_run_whose_plan_is_replaced_meanwhile_is_not_complete():
    def replace_plan(_what: str, done: int, _total: int) -> None:
        if done == 10:
            store_at("memory://replaced").write("run.json", other.to_text().encode())

    other = ShardPlan(request=replace(REQUEST, seed=4), asset_files={}, machine=this_machine(), shard_models=5)
    with pytest.raises(UsageError, match="memory://replaced holds another run: seed was 4 and is 3"):
        sample_shards(REQUEST, "memory://replaced", shard_models=5, on_progress=replace_plan)
    assert not MemoryFileSystem().exists("memory://replaced/index.parquet")


@dataclass(frozen=True)
class Counting(AbstractExecutor):
    """Finishes the first of a million tasks, and forgets the others."""

    def run(self, work: Any, tasks: Any, then: Any) -> None:
        first = next(tasks)
        then(0, ShardRecord(first, 1000, 1))
        assert first + 1 + sum(1 for _ in tasks) == 10**6

    def share(self, num_tasks: int) -> AbstractExecutor:
        return self

    def with_environment(self, values: Any) -> Any:
        return self


def test_a_billion_models_are_planned_in_little_memory(tmp_path: Path):
    request = replace(REQUEST, num_models=10**9)
    tracemalloc.start()
    sample_shards(request, tmp_path, shard_models=1000, executor=Counting())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 200e6
    assert pq.read_metadata(tmp_path / "index.parquet").num_rows == 10**6
    assert (tmp_path / "run.json").stat().st_size < 10_000


def test_a_worker_that_does_not_see_the_folder_says_so(tmp_path: Path):
    store = pickle.loads(pickle.dumps(FolderStore(tmp_path / "elsewhere")))  # noqa: S301 - made right here
    with pytest.raises(UsageError, match="does not see the run's folder"):
        store.write("shards/0000000.parquet", b"")


def test_trees_are_rows_of_their_parameters(tmp_path: Path):
    request = SampleRequest.of("birch", num_models=3, seed=2, image=False)
    sample_shards(request, tmp_path, shard_models=2)
    table = pq.read_table(tmp_path / "shards")
    models = models_of(request)
    assert isinstance(models, SpeciesModels)
    trees = accepted_rows(models.species, root_keys(2, np.arange(3)))
    assert [table[f"parameter.{name}"].to_pylist() for name in COLUMNS] == trees.rows.T.tolist()
    assert table["log_density"].to_pylist() == log_density(models.species, trees.rows).tolist()
    assert (table["kind"].to_pylist(), table["tries"].to_pylist()) == (trees.kind.tolist(), trees.tries.tolist())
