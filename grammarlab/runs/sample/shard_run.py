"""Runs without model files: models as rows of Parquet tables (shards), made by one machine or a cluster.

Each shard is a file that is written whole, so what is there is finished: an interrupted run is continued by the same
command, and a shard that two workers have made is the same file twice.
"""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from grammarlab.derivation.forest import MissingAsset, by_path, by_place
from grammarlab.errors import AssetError, Finding, UsageError
from grammarlab.runs.sample.checks import first_difference, hash_assets, warnings_of
from grammarlab.runs.sample.model_rows import FORMAT, ModelRows, table_of
from grammarlab.runs.sample.models import BATCH_MODELS, AbstractModels, Batch, models_of
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.shard_plan import (
    MAX_PLAN_BYTES,
    PLAN,
    SHARD_MODELS,
    SHARDS,
    ShardPlan,
    file_name,
    file_names,
)
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.runs.work.results import Progress
from grammarlab.runs.work.shard_store import AbstractStore, store_at

INDEX = "index.parquet"
"""Table with a row per shard: shard, file, first_model, num_models, num_bytes."""
_SHAPES_AT_ONCE = 500_000
"""Shapes that are derived at once, a budget: some 150 MB."""
_MOST_MODELS_AT_ONCE = 4096
_MOST_TEXTS = 20
"""Largest number of printed texts of a shard that are reported."""
_CODEC, _LEVEL = "zstd", 1
_ROWS_AT_ONCE = 1_000
"""Rows that are compressed together: fewer make larger files, more take memory."""


@dataclass(frozen=True, slots=True)
class ShardRecord:
    """A shard that this run has made, without its rows."""

    number: int
    num_models: int
    num_bytes: int
    prints: tuple[str, ...] = ()
    missing_assets: tuple[MissingAsset, ...] = ()
    warnings: tuple[Finding, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ShardsResult:
    """A finished run."""

    plan: ShardPlan
    place: str
    """Path or URL of the folder of the run."""
    num_made: int
    """Number of shards that were missing."""
    num_bytes: int
    """Size of all shards in bytes."""
    prints: tuple[str, ...] = ()
    """Texts that the rules printed for the shards made now, a few of each."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Missing meshes of the shards made now, by path."""
    warnings: tuple[Finding, ...] = ()
    """What the rules passed over in the shards made now, by place."""

    def findings(self) -> tuple[Finding, ...]:
        """The warnings, and one for each missing mesh."""
        return (*self.warnings, *warnings_of(self.missing_assets, self.plan.request.assets))


def sample_shards(
    request: SampleRequest,
    target: str | Path,
    *,
    shard_models: int = SHARD_MODELS,
    executor: AbstractExecutor = SERIAL,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> ShardsResult:
    """Derive the models of a request, and write a row of each.

    Args:
        request: the request; options of files and pictures have no effect.
        target: a folder, or the URL of one in a store that fsspec opens. Finished shards of the same run stay.
        shard_models: number of models of a shard, at most `grammarlab.runs.sample.shard_plan.MAX_SHARD_MODELS`.
        executor: makes the shards, whose bytes do not depend on it.
        on_progress: called with the number of finished models after each shard.

    Raises:
        UsageError: If the target holds another run.
        GrammarlabError: If the grammar or the assets cannot be used.
        OSError: If the target does not take a file.
    """
    models = models_of(request)
    models.check(request)
    remarks = tuple(dict.fromkeys((*request.remarks, *models.remarks(request))))
    plan = ShardPlan(
        request=replace(request, image=False, remarks=remarks),
        asset_files=hash_assets(request),
        machine=executor.machine(),
        legend=models.legend(),
        shard_models=shard_models,
    )
    store = store_at(target)
    with store.only_run(SHARDS):
        _begin(plan, store)
        sizes = _finished(plan, store)
        made = _Made(sizes, plan, on_progress)
        made.report()
        executor.run(ShardMaker(plan, store), made.missing(), made.add)
        _check_plan(plan, store)  # a store has no locks, and perhaps not even exclusive files
        store.write(INDEX, _index(plan, sizes))
        num_bytes = int(sizes.sum())
        store.write(PLAN, plan.to_text(num_bytes).encode())
    return ShardsResult(
        plan=plan,
        place=str(store),
        num_made=made.num_made,
        num_bytes=num_bytes,
        prints=tuple(made.prints),
        missing_assets=by_path(made.missing_assets),
        warnings=by_place(made.warnings),
    )


@dataclass(frozen=True)
class ShardMaker:
    """Makes shards, in any process of any machine that sees the store and the assets."""

    plan: ShardPlan
    store: AbstractStore

    def __call__(self, number: int) -> ShardRecord:
        """Make and write a shard.

        Raises:
            AssetError: If an asset file is missing on this machine, or differs.
        """
        request, batch = self.plan.request, self.plan.shard(number)
        file = _ParquetFile({"grammarlab.format": str(FORMAT)})
        prints: list[str] = []
        missing_assets: set[MissingAsset] = set()
        warnings: set[Finding] = set()
        for part, rows in _parts(self._models, request, batch):
            file.add(table_of(request, part.first_model, rows))
            prints += rows.prints[: _MOST_TEXTS - len(prints)]
            missing_assets |= set(rows.missing_assets)
            warnings |= set(rows.warnings)
        content = file.content()
        self.store.write(f"{SHARDS}/{file_name(number)}", content)
        return ShardRecord(
            number=number,
            num_models=batch.num_models,
            num_bytes=len(content),
            prints=tuple(prints),
            missing_assets=by_path(missing_assets),
            warnings=by_place(warnings),
        )

    @cached_property
    def _models(self) -> AbstractModels:
        """The models, once this machine is known to have the assets of the plan; others would change them."""
        request = self.plan.request
        if difference := first_difference(self.plan.asset_files, hash_assets(request)):
            raise AssetError(
                f"{request.assets}: {difference} on machine {platform.node()!r}. All machines need the same assets, by "
                "the same path."
            )
        return models_of(request)


def _parts(models: AbstractModels, request: SampleRequest, batch: Batch) -> Iterator[tuple[Batch, ModelRows]]:
    """The models of a batch, as many at once as fit into memory; a row does not depend on that."""
    done, at_once = 0, BATCH_MODELS
    while done < batch.num_models:
        part = Batch(batch.index, batch.first_model + done, min(at_once, batch.num_models - done))
        rows = models.rows(request, part)
        yield part, rows
        done += part.num_models
        at_once = min(max(1, _SHAPES_AT_ONCE * part.num_models // max(1, rows.num_shapes)), _MOST_MODELS_AT_ONCE)


def _begin(plan: ShardPlan, store: AbstractStore) -> None:
    """Write the plan, unless the place has it.

    Raises:
        UsageError: If it has another one, or files of shards without one.
    """
    if store.read(PLAN, MAX_PLAN_BYTES) is None:
        if next(store.sizes(SHARDS), None) is not None:
            raise UsageError(f"{store}: files in {SHARDS}, but no {PLAN} that says of which run. Use another place.")
        if store.create(PLAN, plan.to_text().encode()):
            return
    _check_plan(plan, store)


def _check_plan(plan: ShardPlan, store: AbstractStore) -> None:
    """Check that the place has the plan of this run.

    Raises:
        UsageError: If it has another one, or none.
    """
    content = store.read(PLAN, MAX_PLAN_BYTES)
    if content is None:
        raise UsageError(f"{store}: {PLAN} has disappeared. Write into another place with -o.")
    try:
        earlier = ShardPlan.from_text(content, plan.request.assets)
    except AssetError as error:
        raise AssetError(f"{store}/{PLAN}: {error} Write into another place with -o.") from error
    if difference := plan.difference(earlier):
        raise UsageError(f"{store} holds another run: {difference}. Write into another place with -o.")


def _finished(plan: ShardPlan, store: AbstractStore) -> NDArray[np.int64]:
    """[num_shards] size of each finished shard, 0 for the others."""
    sizes = np.zeros(plan.num_shards, np.int64)
    for name, size in store.sizes(SHARDS):
        if (number := plan.number_of(name)) is not None:
            sizes[number] = size
    return sizes


class _Made:
    """What has been made so far, of all shards and in this run."""

    def __init__(self, sizes: NDArray[np.int64], plan: ShardPlan, on_progress: Progress) -> None:
        self._sizes, self._plan, self._on_progress = sizes, plan, on_progress
        self._done = int(np.count_nonzero(sizes)) * plan.shard_models
        if sizes[-1]:
            self._done -= plan.shard_models - plan.shard(plan.num_shards - 1).num_models
        self.num_made = 0
        self.prints: list[str] = []
        self.missing_assets: set[MissingAsset] = set()
        self.warnings: set[Finding] = set()

    def missing(self) -> Iterator[int]:
        """Numbers of the shards that were missing at the start, in order."""
        return map(int, np.flatnonzero(self._sizes == 0))

    def add(self, _index: int, record: ShardRecord) -> None:
        """Note a shard that has been made."""
        self._sizes[record.number] = record.num_bytes
        self._done += record.num_models
        self.num_made += 1
        self.prints += record.prints[: _MOST_TEXTS * 5 - len(self.prints)]
        self.missing_assets |= set(record.missing_assets)
        self.warnings |= set(record.warnings)
        self.report()

    def report(self) -> None:
        """Report the number of finished models."""
        self._on_progress("models", self._done, self._plan.request.total_models)


def _index(plan: ShardPlan, sizes: NDArray[np.int64]) -> bytes:
    """The index as a file."""
    numbers = np.arange(plan.num_shards, dtype=np.int64)
    first = numbers * plan.shard_models
    columns: dict[str, pa.Array] = {
        "shard": pa.array(numbers),
        "file": file_names(numbers),
        "first_model": pa.array(first),
        "num_models": pa.array(np.minimum(plan.shard_models, plan.request.total_models - first)),
        "num_bytes": pa.array(sizes),
    }
    file = _ParquetFile({"grammarlab.format": str(FORMAT)})
    file.add(pa.table(columns))
    return file.content()


class _ParquetFile:
    """A table as a file in memory; the schema of Arrow, which repeats that of Parquet, is left out."""

    def __init__(self, metadata: Mapping[str, str]) -> None:
        self._metadata = metadata
        self._buffer = pa.BufferOutputStream()
        self._writer: pq.ParquetWriter | None = None
        self._tables: list[pa.Table] = []

    def add(self, table: pa.Table) -> None:
        """Add rows."""
        self._tables.append(table)
        if sum(len(table) for table in self._tables) >= _ROWS_AT_ONCE:
            self._compress()

    def content(self) -> bytes:
        """The file, to which nothing is added any more."""
        self._compress()
        if self._writer is not None:
            self._writer.add_key_value_metadata(self._metadata)
            self._writer.close()
        return self._buffer.getvalue().to_pybytes()

    def _compress(self) -> None:
        if not self._tables:
            return
        table = pa.concat_tables(self._tables)
        self._tables.clear()
        self._writer = self._writer or pq.ParquetWriter(
            self._buffer, table.schema, compression=_CODEC, compression_level=_LEVEL, store_schema=False
        )
        self._writer.write_table(table)
