"""Plan of a run without model files: everything that determines its shards, written before the first of them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import AssetError, UsageError
from grammarlab.runs.sample.manifest import place_of
from grammarlab.runs.sample.model_rows import FORMAT
from grammarlab.runs.sample.models import Batch
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.work.json_members import member, texts
from grammarlab.runs.work.machine import PINNED, Machine

PLAN = "run.json"
SHARDS = "shards"
"""Folder of the shards."""
SHARD_MODELS = 5_000
"""Usual number of models of a shard: a few seconds of work, and a file of a few megabytes."""
MAX_SHARD_MODELS = 100_000
MAX_PLAN_BYTES = 1 << 26
"""Largest size of a plan in bytes."""
_DIGITS = 7
"""Digits of the name of a shard, or more."""
_NAME = re.compile(r"(\d{7,12})\.parquet")


@dataclass(frozen=True, slots=True, kw_only=True)
class ShardPlan:
    """The models of a request, cut into shards of consecutive ones."""

    request: SampleRequest
    asset_files: Mapping[str, str]
    """SHA-256 of the asset files that the request names, by path relative to its asset folder."""
    machine: Machine
    """Software and processors that make the shards."""
    legend: Mapping[str, Any] = field(default_factory=dict)
    """Meaning of the numbers in the columns (`AbstractModels.legend`)."""
    shard_models: int = SHARD_MODELS
    """Number of models of all shards but the last."""

    def __post_init__(self) -> None:
        if self.request.models:
            raise UsageError("models: rows of tables are made of whole runs; leave it out, and select rows by `model`.")
        if not 1 <= self.shard_models <= MAX_SHARD_MODELS:
            raise UsageError(
                f"models of a shard: expected 1 to {MAX_SHARD_MODELS:,} (all in memory), found {self.shard_models:,}."
            )

    @property
    def num_shards(self) -> int:
        """Number of shards, at least 1."""
        return -(-self.request.total_models // self.shard_models)

    def shard(self, number: int) -> Batch:
        """The models of a shard."""
        first = number * self.shard_models
        return Batch(number, first, min(self.shard_models, self.request.total_models - first))

    def number_of(self, name: str) -> int | None:
        """Number of the shard of a file; None if it is not the name of one."""
        match = _NAME.fullmatch(name)
        number = int(match[1]) if match else -1
        return number if 0 <= number < self.num_shards and name == file_name(number) else None

    def difference(self, earlier: ShardPlan) -> str:
        """Why shards of an earlier plan cannot be used for this one; empty if they can."""
        mine, theirs = self.request, earlier.request
        if (mine.text, mine.suffix) != (theirs.text, theirs.suffix):
            return "the file of the models differs"
        before, now = theirs.as_json(), mine.as_json()
        for name, value in now.items():
            if before.get(name) != value:
                return f"{name} was {before.get(name)!r:.60} and is {value!r:.60}"
        if self.asset_files != earlier.asset_files:
            return "an asset file differs"
        if self.shard_models != earlier.shard_models:
            return f"shards had {earlier.shard_models:,} models and have {self.shard_models:,}"
        if difference := self.machine.difference(earlier.machine):
            return (
                f"now it would be made with {difference} as before, which may change last bits (pin processors with "
                f"{PINNED})"
            )
        return ""

    def to_text(self, num_bytes: int | None = None) -> str:
        """Text of the file.

        Args:
            num_bytes: size of all shards, once they are finished.
        """
        values = {
            "format": FORMAT,
            "complete": num_bytes is not None,
            "grammar": {"name": self.request.name, "sha256": self.request.text_hash, "text": self.request.text},
            "request": self.request.as_json(),
            "place": place_of(self.request),
            "remarks": [asdict(remark) for remark in self.request.remarks],
            "asset_files": dict(self.asset_files),
            "machine": self.machine.as_json(),
            "legend": dict(self.legend),
            "shard_models": self.shard_models,
            "num_shards": self.num_shards,
            "num_bytes": num_bytes,
        }
        return json.dumps(values, indent=1) + "\n"

    @classmethod
    def from_text(cls, content: bytes, assets: AssetRoot) -> Self:
        """Plan from the text of `to_text`, without its legend.

        Args:
            content: the text, perhaps of a stranger.
            assets: folder of the assets.

        Raises:
            AssetError: If it is damaged, or of a newer version.
        """
        try:
            values = json.loads(content)
        except (ValueError, RecursionError) as error:
            raise AssetError(f"the plan is damaged: {error!s:.200}") from error
        if (version := member(values, "format", int)) != FORMAT:
            raise AssetError(f"expected a plan of format {FORMAT}, found format {version!r:.20}.")
        text = member(member(values, "grammar", dict), "text", str, "grammar")
        return cls(
            request=SampleRequest.from_json(member(values, "request", dict), text, assets),
            asset_files=texts(values, "asset_files"),
            machine=Machine.from_json(member(values, "machine", dict), "machine"),
            shard_models=member(values, "shard_models", int),
        )


def file_names(numbers: NDArray[np.int64]) -> pa.Array:
    """[n] paths of the files of shards in the folder of a run."""
    digits = pc.call_function("utf8_lpad", [pa.array(numbers).cast(pa.string())], pc.PadOptions(_DIGITS, "0"))
    return pc.call_function("binary_join_element_wise", [f"{SHARDS}/", digits, ".parquet", ""])


def file_name(number: int) -> str:
    """Name of the file of a shard in the folder of shards."""
    return f"{number:0{_DIGITS}d}.parquet"
