"""Models of a run: made in batches, with a record of each."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.derivation.forest import MissingAsset
from grammarlab.errors import Finding, UsageError
from grammarlab.geometry.outlines.footprints import Remark
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.runs.requests.batches import Batch
from grammarlab.runs.requests.domains import domain_of, opened
from grammarlab.runs.requests.request import AttributeValue, SampleRequest
from grammarlab.scene import Scene

Report = Mapping[str, Mapping[str, float | int | None]]


def _nothing(_folder: Path) -> Iterable[str]:
    return ()


@dataclass(frozen=True, kw_only=True)
class MadeModels:
    """A batch of n models."""

    scene: Scene
    shapes: Sequence[int]
    """[n]; this and the next two fields are those of `ModelRecord`."""
    log_probability: Sequence[float | None]
    reports: Sequence[Report]
    prints: tuple[str, ...] = ()
    """Texts printed by the rules."""
    tries: Sequence[int] = ()
    """[n] number of candidates of each (`grammarlab.features.rules.accepting`); none without an acceptance rule."""
    kept: Sequence[bool] = ()
    """[n] whether one of them was accepted."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Meshes that the asset folder lacks."""
    save: Callable[[Path], Iterable[str]] = _nothing
    """Save how they were made in a folder; returns the names of the files."""


class AbstractModels(ABC):
    """Models described by a file."""

    @abstractmethod
    def attributes(self, texts: Sequence[str]) -> dict[str, AttributeValue]:
        """Values of attributes from texts like ``height=12``.

        Raises:
            UsageError: If values have other types.
        """

    @abstractmethod
    def left_out(self) -> tuple[Finding, ...]:
        """Ignored and unsupported features of the file."""

    @abstractmethod
    def check(self, request: SampleRequest) -> None:
        """Check that the options of a request fit the file.

        Raises:
            GrammarlabError: If they do not.
        """

    def remarks(self, request: SampleRequest) -> tuple[Remark, ...]:
        """Remarks about properties of the footprints of a request that cannot be used; none by default."""
        return ()

    @abstractmethod
    def make(self, request: SampleRequest, batch: Batch) -> MadeModels:
        """A batch of a request."""

    @abstractmethod
    def stored(self, request: SampleRequest, batch: Batch, folder: Path) -> Scene:
        """The scene of a finished batch, from the folder of `MadeModels.save`."""


@dataclass(frozen=True)
class RealizedModels(AbstractModels):
    """Models of a space whose files have no attributes or rules; they are not saved but made again."""

    space: AbstractDesignSpace[Any]

    def attributes(self, texts: Sequence[str]) -> dict[str, AttributeValue]:
        if texts:
            raise UsageError(f"attribute {texts[0]!r}: files of this kind have no attributes; leave it out.")
        return {}

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
            scene=scene,
            shapes=np.bincount(scene.model, minlength=scene.num_models).tolist(),
            log_probability=[None] * scene.num_models,
            reports=[{}] * scene.num_models,
            missing_assets=realized.missing_assets,
        )

    def stored(self, request: SampleRequest, batch: Batch, folder: Path) -> Scene:
        return self.space.realize(_addresses(request, batch)).scene


def models_of(request: SampleRequest) -> AbstractModels:
    """Models of the file of a request.

    Raises:
        LanguageError: If it has errors.
    """
    return domain_of(request.suffix).models(opened(request.suffix, request.text, request.name, request.assets))


def _addresses(request: SampleRequest, batch: Batch) -> list[Address]:
    return [Address(False, request.seed, batch.first_model + number) for number in range(batch.num_models)]
