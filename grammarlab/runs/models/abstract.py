"""Models of a file as a run makes them: a batch at a time, with what is recorded about each."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.derivation.forest import MissingAsset
from grammarlab.errors import Finding, UsageError
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
    """[n] as in `ModelRecord`, and so the next two."""
    log_probability: Sequence[float | None]
    reports: Sequence[Report]
    prints: tuple[str, ...] = ()
    """What the rules printed."""
    tries: Sequence[int] = ()
    """[n] candidates that each took (`grammarlab.features.rules.accepting`); none where every first one is taken."""
    kept: Sequence[bool] = ()
    """[n] whether one of them was accepted."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Meshes that the asset folder lacks."""
    save: Callable[[Path], Iterable[str]] = _nothing
    """Keeps how they were made in a folder, and gives the names of the files."""


class AbstractModels(ABC):
    """The models that a file describes."""

    @abstractmethod
    def attributes(self, texts: Sequence[str]) -> dict[str, AttributeValue]:
        """Values of attributes from texts like ``height=12``.

        Raises:
            UsageError: for values that do not fit.
        """

    @abstractmethod
    def left_out(self) -> tuple[Finding, ...]:
        """What of the file no model will show."""

    @abstractmethod
    def check(self, request: SampleRequest) -> None:
        """Makes sure that the options of a request fit the file.

        Raises:
            GrammarlabError: when they do not.
        """

    @abstractmethod
    def make(self, request: SampleRequest, batch: Batch) -> MadeModels:
        """A batch of a request."""

    @abstractmethod
    def stored(self, request: SampleRequest, batch: Batch, folder: Path) -> Scene:
        """The scene of a finished batch, of which `MadeModels.save` has kept in a folder what it keeps."""


@dataclass(frozen=True)
class RealizedModels(AbstractModels):
    """Models of a space whose files have neither attributes nor rules; of them nothing is kept, they are made again."""

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
    """The models of the file of a request.

    Raises:
        LanguageError: when it has errors.
    """
    return domain_of(request.suffix).models(opened(request.suffix, request.text, request.name, request.assets))


def _addresses(request: SampleRequest, batch: Batch) -> list[Address]:
    return [Address(False, request.seed, batch.first_model + number) for number in range(batch.num_models)]
