"""Models of a run: made in batches, each of which is recorded and resumed separately."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grammarlab.derivation.forest import MissingAsset
from grammarlab.derivation.lots import Lots
from grammarlab.errors import Finding, UsageError
from grammarlab.geometry.footprints.footprint import Footprint, Remark
from grammarlab.language.attribute_values import AttributeValue, usable_properties
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.domains import opened_models
from grammarlab.scene import Scene

if TYPE_CHECKING:  # these load libraries that most runs do without
    from grammarlab.runs.sample.model_rows import ModelRows
    from grammarlab.runs.sample.request import SampleRequest
    from grammarlab.trees.planting import Crowns

BATCH_MODELS = 64
"""Number of models of a batch: small enough to lose little when a run is interrupted."""
EMPTY_MODELS = "empty-models"
"""Code of the warning that models have no shape."""
Report = Mapping[str, Mapping[str, float | int | None]]


@dataclass(frozen=True, slots=True)
class Batch:
    """Consecutive models of a run, on one or several footprints."""

    index: int
    first_model: int
    num_models: int

    def __str__(self) -> str:
        return f"models {self.first_model} to {self.first_model + self.num_models - 1}"


def _nothing(_folder: Path) -> Iterable[str]:
    return ()


@dataclass(frozen=True, kw_only=True)
class MadeScene:
    """Consecutive models of a batch, as many as fit into memory: k of them."""

    scene: Scene
    shapes: Sequence[int]
    """[k] number of shapes of each model, as in `ModelRecord`."""
    reports: Sequence[Report]
    """[k] summaries of the reports of each model, as in `ModelRecord`."""


@dataclass(frozen=True, kw_only=True)
class MadeModels:
    """A batch of n models."""

    scenes: Iterable[MadeScene]
    """The scenes of all models, in order; iterated once."""
    log_probability: Sequence[float | None]
    """[n] log-density of the draws of each model, as in `ModelRecord`."""
    prints: tuple[str, ...] = ()
    """Texts printed by the rules."""
    tries: Sequence[int] = ()
    """[n] number of candidates of each model (`grammarlab.features.acceptance`); none without a rule."""
    accepted: Sequence[bool] = ()
    """[n] whether a candidate was accepted."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Meshes that the asset folder lacks."""
    warnings: tuple[Finding, ...] = ()
    """What the rules passed over."""
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
        """Ignored and unsupported features of the file, and operations that do not exist."""

    @abstractmethod
    def check(self, request: SampleRequest) -> None:
        """Check that the options of a request fit the file.

        Raises:
            GrammarlabError: If they do not.
        """

    @abstractmethod
    def asset_names(self) -> Iterable[str]:
        """Texts of the file that may name files of its asset folder (`grammarlab.runs.sample.checks`)."""

    def crowns(self, seed: int, attributes: Mapping[str, AttributeValue]) -> Crowns:
        """Radii of the crowns of models under a seed, for planting them on an area.

        Raises:
            UsageError: If the models are not trees.
        """
        raise UsageError("only trees are planted on areas; models of a grammar stand on a footprint: --footprint.")

    def remarks(self, request: SampleRequest) -> tuple[Remark, ...]:
        """Remarks about properties of the footprints of a request that cannot be used; none by default."""
        return ()

    @abstractmethod
    def make(self, request: SampleRequest, batch: Batch) -> MadeModels:
        """A batch of a request."""

    @abstractmethod
    def rows(self, request: SampleRequest, batch: Batch) -> ModelRows:
        """A batch of a request without geometry."""

    @abstractmethod
    def legend(self) -> dict[str, Any]:
        """Meaning of the numbers in the columns of `rows`, as plain values."""

    @abstractmethod
    def stored(self, request: SampleRequest, batch: Batch, folder: Path) -> Iterator[Scene]:
        """The scenes of a finished batch, in order, from the folder of `MadeModels.save`."""


def cut_batches(request: SampleRequest) -> tuple[Batch, ...]:
    """The batches of a run: its models in order, cut where a batch is full or a number is missing."""
    batches: list[Batch] = []
    for first, end in _consecutive(request.model_numbers):
        for start in range(first, end, BATCH_MODELS):
            batches.append(Batch(len(batches), start, min(BATCH_MODELS, end - start)))
    return tuple(batches)


def _consecutive(numbers: Sequence[int]) -> Iterator[tuple[int, int]]:
    """First number and end of each longest range of ascending numbers."""
    if isinstance(numbers, range):
        yield numbers.start, numbers.stop
        return
    first = numbers[0]
    for number, following in zip(numbers, (*numbers[1:], None), strict=True):
        if following is None or following > number + 1:
            yield first, number + 1
            first = following or 0


def lots_of(request: SampleRequest, batch: Batch, grammar: Grammar) -> Lots:
    """Lots of a batch.

    Properties of a footprint replace attributes, options of the request replace both. Unusable properties have no
    effect (`property_remarks`).
    """
    first, end = batch.first_model, batch.first_model + batch.num_models
    start_rule = request.start_rule or None
    if not request.footprints:
        return Lots.of(
            end - first, request.seed, first_model=first, attributes=request.attributes, start_rule=start_rule
        )
    parts = []
    for number in range(first // request.num_models, (end - 1) // request.num_models + 1):
        footprint = request.footprints[number]
        low, high = max(first, number * request.num_models), min(end, (number + 1) * request.num_models)
        attributes = {**usable_properties(footprint.properties, grammar).values, **request.attributes}
        parts.append(
            Lots.of(
                high - low,
                request.seed,
                first_model=low,
                footprint=footprint.polygon,
                attributes=attributes,
                start_rule=start_rule,
            )
        )
    return Lots.concatenate(parts)


def property_remarks(footprint: Footprint, grammar: Grammar) -> tuple[Remark, ...]:
    """Remarks about properties of a footprint that have the names of attributes, and values that these cannot take."""
    problems = dict(usable_properties(footprint.properties, grammar).problems)
    for name in footprint.unread:
        if name in grammar.attributes and not grammar.attributes[name].constant:
            problems[name] = f"attribute {name!r}: expected a finite number, a text, true or false"
    return tuple(Remark(footprint.name, "property", problem) for problem in problems.values())


def models_of(request: SampleRequest) -> AbstractModels:
    """Models of the file of a request.

    Raises:
        LanguageError: If it has errors.
    """
    return opened_models(request.suffix, request.text, request.name, request.assets)
