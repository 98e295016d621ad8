"""Boxes with three numbers, as another kind of file for grammarlab: it knows nothing of grammars.

A file holds, as JSON, the range of each number and a table of weights over cells of equal size. A box is drawn from a
cell by weight, and evenly within it. Learning gives another table: of finer cells, weighted by what is liked.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from scipy import sparse

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.density.exact.splitting import Base
from grammarlab.density.targets.rejection import Progress, silent
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.errors import Finding, LanguageError, Location, UsageError
from grammarlab.features.columns.feature_table import FeatureTable
from grammarlab.features.columns.plain_columns import feature_values
from grammarlab.features.patterns.pattern import Draw, Feature
from grammarlab.geometry.meshes.primitives import box
from grammarlab.learning.designs.addresses import Address, hashes_of
from grammarlab.learning.designs.design_space import AbstractDesignSpace, Realized
from grammarlab.learning.round import State, Study
from grammarlab.learning.settings import FeatureOptions
from grammarlab.learning.targets.simplification import predict
from grammarlab.learning.targets.writers import AbstractTargetWriter, LearnedDensity, Making, judged
from grammarlab.runs.sample.domains import DOMAINS, AbstractDomain
from grammarlab.runs.sample.model_rows import ModelRows
from grammarlab.runs.sample.models import AbstractModels, Batch, MadeModels, MadeScene
from grammarlab.runs.sample.request import AttributeValue, SampleRequest
from grammarlab.runs.work import workers
from grammarlab.scene.instances import Scene

NAMES = ("width", "height", "depth")
FINE = 8
"""Cells along each number that are learned."""


@dataclass(frozen=True)
class Columns:
    """The numbers themselves."""

    low: Floats
    high: Floats

    def apply(self, designs: Sequence[Floats], /) -> FeatureTable:
        rows = np.concatenate([np.zeros((0, 3)), *designs])
        features = tuple(map(Draw, NAMES))
        return FeatureTable(sparse.csr_array(rows), features, NAMES, np.arange(3), NAMES, self.high - self.low)


@dataclass(frozen=True, eq=False)
class BoxSpace(AbstractDesignSpace[Floats]):
    """A design is its row of three numbers; the proposal draws them evenly."""

    text: str
    low: Floats
    high: Floats
    weights: Floats
    """[n, n, n] of cells, adding up to 1."""

    @classmethod
    def parse(cls, text: str) -> BoxSpace:
        values = json.loads(text)
        low, high = np.array([values["ranges"][name] for name in NAMES], dtype=np.float64).T
        weights = np.array(values.get("weights", [[[1.0]]]), dtype=np.float64)
        if not (low > 0.0).all() or not (low < high).all() or not (weights >= 0.0).all() or weights.ndim != 3:
            raise ValueError("expected ranges above 0 and weights of at least 0")
        return cls(text, low, high, weights / weights.sum())

    @property
    def hashes(self) -> tuple[str, str]:
        return hashes_of(sha256(self.text.encode()).hexdigest())

    @property
    def longest_path(self) -> int:
        return 1

    def make(self, addresses: Sequence[Address]) -> Floats:
        for address in addresses:
            if address[3:] != ("", "{}", ""):
                raise UsageError("boxes have no start rule, attributes or footprint.")
        return np.array([self._box(address) for address in addresses]).reshape(-1, 3)

    def sample(self, flat: bool, num: int, seed: int, first: int = 0) -> Iterator[Floats]:
        yield self.make([Address(flat, seed, first + number) for number in range(num)])

    def log_ratio(self, designs: Floats) -> Floats:
        with np.errstate(divide="ignore"):
            return np.log(self.density(designs))

    def take(self, designs: Floats, indices: NDArray[np.int64]) -> Floats:
        return designs[indices]

    def vocabulary(self, designs: Sequence[Floats], features: FeatureOptions) -> Columns:
        return Columns(self.low, self.high)

    def values(self, designs: Sequence[Floats], features: Sequence[Feature]) -> Floats:
        rows = np.concatenate([np.zeros((0, 3)), *designs])
        columns: dict[str, Floats] = dict(zip(NAMES, rows.T, strict=True))
        return np.column_stack([rows[:, :0], *(feature_values(columns, feature) for feature in features)])

    def realize(self, addresses: Sequence[Address]) -> Realized:
        size = self.make(addresses)
        num, one = len(size), np.zeros(len(size), np.int32)
        position = size * [-0.5, 0.0, -0.5]
        materials, frames, maps = (
            Materials(np.array([[*CHANNELS.values()]]), ("",)),
            np.eye(3)[None],
            np.zeros((0, 2, 4)),
        )
        columns = np.arange(num, dtype=np.int32), one, one, position, size, one
        return Realized(Scene(num, box(), materials, *columns, frames, one - 1, maps, np.zeros((num, 3))))

    @cached_property
    def even(self) -> Floats:
        """The weights of the proposal."""
        return np.full_like(self.weights, 1.0 / self.weights.size)

    def density(self, designs: Floats) -> Floats:
        """[n] density of boxes by the even one."""
        shape = np.array(self.weights.shape)
        cells = np.minimum(((designs - self.low) / (self.high - self.low) * shape).astype(np.int64), shape - 1)
        return self.weights[tuple(cells.T)] * self.weights.size

    def _box(self, address: Address) -> Floats:
        random = np.random.default_rng([address.seed, address.model, address.flat])
        weights = self.even if address.flat else self.weights
        cell = np.unravel_index(random.choice(weights.size, p=weights.ravel()), weights.shape)
        return self.low + (self.high - self.low) * (cell + random.random(3)) / weights.shape


def by(one: Floats, other: Floats) -> Floats:
    """The ratio of densities; 0 where the space has no boxes."""
    return np.divide(one, other, out=np.zeros(len(one)), where=other > 0.0)


@dataclass(frozen=True)
class LearnedBoxes:
    """A table that was learned."""

    text: str
    base: Base
    before: BoxSpace
    method: str = "cells"
    accept_rate: float | None = None
    findings: tuple[str, ...] = ()

    @cached_property
    def space(self) -> BoxSpace:
        return BoxSpace.parse(self.text)

    @property
    def rules_before(self) -> int:
        return self.before.weights.size

    @property
    def units(self) -> tuple[str, str]:
        return "cell", "cells"

    @property
    def rules_after(self) -> int:
        return self.space.weights.size

    def ratio(self, designs: Floats, /) -> Floats:
        return by(self.space.density(designs), self.before.density(designs))

    def scene(self, num: int, seed: int, /) -> Scene:
        return self.space.scene(num, seed)


@dataclass(frozen=True)
class BoxWriter(AbstractTargetWriter[Floats]):
    """Makes tables."""

    space: BoxSpace

    @property
    def methods(self) -> tuple[str, ...]:
        return ("cells",)

    def learn(
        self,
        study: Study[Floats],
        state: State,
        making: Making,
        lines: Sequence[str] = (),
        on_progress: Progress = silent,
    ) -> LearnedDensity[Floats]:
        self.method(making.method)
        space, predicted, scales = self.space, predict(study, state), study.table(state).scales
        cells = (np.indices((FINE, FINE, FINE)).reshape(3, -1).T + 0.5) / FINE
        centres = space.low + (space.high - space.low) * cells
        own = {"grammar": space.density(centres), "uniform": np.ones(len(centres))}[making.base]
        assert state.product is not None
        columns = np.column_stack([centres, space.values([centres], state.columns.extra)])
        liked = np.clip(state.product.predict(columns / scales).mean, 0.0, None)
        weights = (own * liked).reshape(FINE, FINE, FINE)
        ranges = {name: [low, high] for name, low, high in zip(NAMES, space.low, space.high, strict=True)}
        text = json.dumps({"about": list(lines), "ranges": ranges, "weights": weights.tolist()})
        of_base = {"grammar": None, "uniform": lambda designs: by(np.ones(len(designs)), space.density(designs))}[
            making.base
        ]
        learned = LearnedBoxes(text, making.base, space)
        looked_at: dict[Feature, str] = {Draw(name): name for name in NAMES}
        return judged(study, state, learned, predicted, predicted.scores, looked_at, of_base)


@dataclass(frozen=True)
class BoxModels(AbstractModels):
    """Models of files without attributes or rules; they are not saved but made again."""

    space: BoxSpace

    def attributes(self, texts: Sequence[str]) -> dict[str, AttributeValue]:
        if texts:
            raise UsageError(f"attribute {texts[0]!r}: files of this kind have no attributes; leave it out.")
        return {}

    def asset_names(self) -> tuple[str, ...]:
        return ()

    def left_out(self) -> tuple[Finding, ...]:
        return ()

    def check(self, request: SampleRequest) -> None:
        options = {"attributes": request.attributes, "start rule": request.start_rule, "footprint": request.footprints}
        given = [name for name, value in options.items() if value]
        if given:
            raise UsageError(f"files of this kind have no {given[0]}; leave it out.")

    def make(self, request: SampleRequest, batch: Batch) -> MadeModels:
        realized = self.space.realize(_addresses(request, batch))
        scene = realized.scene
        return MadeModels(
            scenes=[
                MadeScene(
                    scene=scene,
                    shapes=np.bincount(scene.model, minlength=scene.num_models).tolist(),
                    reports=[{}] * scene.num_models,
                )
            ],
            log_probability=[None] * scene.num_models,
            missing_assets=realized.missing_assets,
        )

    def rows(self, request: SampleRequest, batch: Batch) -> ModelRows:
        boxes = self.space.make(_addresses(request, batch))
        columns = {name: pa.array(np.ascontiguousarray(boxes[:, k])) for k, name in enumerate(NAMES)}
        num = batch.num_models
        return ModelRows(
            columns=columns,
            log_density=pa.nulls(num, pa.float64()),
            tries=np.ones(num, dtype=np.int64),
            accepted=np.ones(num, dtype=np.bool_),
        )

    def legend(self) -> dict[str, Any]:
        return {}

    def stored(self, request: SampleRequest, batch: Batch, folder: Path) -> Iterator[Scene]:
        yield self.space.realize(_addresses(request, batch)).scene


def _addresses(request: SampleRequest, batch: Batch) -> list[Address]:
    return [Address(False, request.seed, batch.first_model + number) for number in range(batch.num_models)]


class BoxDomain(AbstractDomain[BoxSpace, BoxModels]):
    """What such files mean."""

    def read(self, path: Path, library: Path | str | None = None) -> str:
        return path.read_text()

    def open(self, text: str, name: str, assets: AssetRoot) -> BoxSpace:
        try:
            return BoxSpace.parse(text)
        except (ValueError, LookupError, TypeError) as error:
            finding = Finding("error", "bad-boxes", f"these are no boxes: {error}", Location(file=f"{name}.boxes"))
            raise LanguageError((finding,), text) from error

    def models(self, text: str, name: str, assets: AssetRoot) -> BoxModels:
        return BoxModels(self.open(text, name, assets))

    def writer(self, space: BoxSpace) -> BoxWriter:
        return BoxWriter(space)


BOXES = f"{BoxDomain.__module__}:{BoxDomain.__name__}"
"""Entry of `DOMAINS`."""
_begin = workers._begin


def begin(target: Callable[..., None], there: Connection, *arguments: Any) -> None:
    """The start of a worker process that knows boxes."""
    DOMAINS[".boxes"] = BOXES
    _begin(target, there, *arguments)
