"""Tasks and results of worker processes. It imports little, since every process loads it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import Finding
from grammarlab.pages.record.judgements import Scores

if TYPE_CHECKING:
    from grammarlab.features.patterns.pattern import Feature

Singles = NDArray[np.float32]
NUM_FITS = 4
"""Number of updates of which a process remembers the predictions, to measure changes from them."""
Factors = dict[str, Scores]
"""Labels by factor and subject."""


@dataclass(frozen=True, slots=True)
class Progress:
    """Progress of a long task."""

    stage: str
    done: int
    total: int

    def as_json(self) -> dict[str, Any]:
        """JSON for the page."""
        return {"stage": self.stage, "done": self.done, "total": self.total}


@dataclass(frozen=True, slots=True)
class Begin:
    """Task: check whether the grammar can be derived: size of the usual pool; an error has the reason."""


@dataclass(frozen=True, slots=True)
class DrawModels:
    """Task: draw pictures of models: `DrawnModels`."""

    models: tuple[str, ...]
    """Addresses."""
    size: int
    """Pixels along each side."""
    samples: int
    """Samples along each side of a pixel: 1 is quick, 2 good."""


@dataclass(frozen=True, slots=True)
class Contrast:
    """A choice on which the scores depend, as two models that differ in it alone."""

    text: str
    """The choice in words."""
    feature: Feature
    """How often it is taken."""
    models: tuple[str, ...]
    """Addresses of models with it; the first one whose seed gives another model without it is shown."""
    without: float
    """Mean predicted score of models without it, 0 to 100."""
    having: float
    """Mean predicted score of models with it, 0 to 100."""


@dataclass(frozen=True, slots=True)
class DrawContrast:
    """Task: draw a model without and with a choice: `DrawnModels`, two pictures in one frame."""

    contrast: Contrast
    size: int
    """Pixels along each side."""
    samples: int
    """Samples along each side of a pixel."""


@dataclass(frozen=True, slots=True)
class DrawnModels:
    """Pictures of models."""

    pictures: tuple[NDArray[np.uint8], ...]
    """[size, size, 3] of each model."""
    warnings: tuple[Finding, ...] = ()
    """Warnings about missing assets in these pictures, or in earlier ones."""


@dataclass(frozen=True, slots=True)
class MakeGlb:
    """Task: make a model as the bytes of a GLB file."""

    model: str
    """Address."""


@dataclass(frozen=True, slots=True)
class FindPart:
    """Task: find the origin of a part of a model, one visible shape: `FoundPart`."""

    model: str
    """Address."""
    number: int
    """Number of the part, modulo the number of parts, or of one of its triangles."""
    is_triangle: bool


@dataclass(frozen=True, slots=True)
class FoundPart:
    """A visible shape of a model."""

    number: int
    count: int
    """Number of parts of the model."""
    triangles: tuple[int, int]
    """Its first triangle among those of the model's file, and the one after its last."""
    path: tuple[tuple[str, str], ...]
    """Symbols from the initial shape down to this one, each with the place (file:line:column) of the branch that
    rewrote it, or where nothing did, of the word that made it."""


@dataclass(frozen=True, slots=True)
class Prepare:
    """Task: count the features of the pool: `Features`."""


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """Options of choosing models."""

    way: str
    """See `grammarlab.preference.queries`."""
    factor: str
    """Factor of the labels and the preference; empty for the product of all."""
    num: int
    seed: int
    without: tuple[str, ...] = ()
    """Addresses of models that are on the page, and are not chosen; with ``already ranked`` and in pairs they may be
    chosen again."""


@dataclass(frozen=True, slots=True)
class Choose:
    """Task: choose models to show: [num] addresses of the pool or, with ``already ranked``, of any scored models."""

    factors: Factors
    numbers: Mapping[str, int]
    """Number of each factor; it stays when the factor is renamed."""
    choice: ModelChoice


@dataclass(frozen=True, slots=True)
class Update:
    """Task: learn from all scores: `LearnedUpdate`."""

    factors: Factors
    numbers: Mapping[str, int]
    """Number of each factor; it stays when the factor is renamed."""
    choice: ModelChoice | None
    """Models to choose afterwards; None for no new models, and an unchanged pool."""
    known_version: int = 0
    """`Features.version` of the features that are already known."""
    wide: bool = False
    """Whether the pool has been widened for rare models; if not, it is widened once liked models are rare."""
    since: int = 0
    """`LearnedUpdate.number` of the update from which the change is measured, one of the last `NUM_FITS` with a choice.
    For other numbers, such as 0 or those of another process, it is the update from which the process measured last, or
    else the grammar."""


@dataclass(frozen=True, slots=True)
class Features:
    """Features of models: those of the pool, then those of `LearnedUpdate.elsewhere`."""

    version: int
    """1, 2, 3 …"""
    rows: Singles
    """[m + e, F] scaled features."""
    names: tuple[str, ...]
    """[F] different names of the features."""


@dataclass(frozen=True, slots=True)
class Predictions:
    """Predictions for the models of the pool, and then for those of `LearnedUpdate.elsewhere`."""

    mean: Singles
    """[m + e] predicted scores, 0 to 100 or a little beyond."""
    std: Singles
    """[m + e] standard deviations of the scores."""
    weights: Singles | None
    """[F] weights of the kernel, if any."""
    relevance: tuple[tuple[str, str, float], ...]
    """Name, level and share of the most relevant groups."""


@dataclass(frozen=True, slots=True)
class LearnedUpdate:
    """Result of an update."""

    features: Features | None
    """Features, if they differ from the known ones."""
    wide: bool
    """Whether it uses the pool widened for rare models."""
    elsewhere: tuple[str, ...]
    """[e] addresses of scored models outside the pool."""
    factors: Mapping[str, Predictions]
    """Predictions of the factors with labels."""
    product: Predictions | None
    """Predictions of the product of factors with a score above 0; None if there are none."""
    left_out: tuple[str, ...]
    """Reasons why factors are not part of the product."""
    js: float
    """Change of the density since `Update.since`, in nats."""
    chosen: tuple[str, ...] | None
    """Addresses of the models to show."""
    words: tuple[str, ...] = ()
    """Liked and disliked kinds, one sentence each."""
    contrasts: tuple[Contrast, ...] = ()
    """Choices of which `words` speak, the most important ones first."""
    is_explained: bool = False
    """Whether the scores have a pattern that replaces more than half of the original."""
    gain: float | None = None
    """Expected gain of 16 more scores in nats; None if it is unknown."""
    turn: str = ""
    """Factor whose scores would tell most; empty if there is one factor only."""
    number: int = 0
    """Number of this update; those of other processes differ."""


@dataclass(frozen=True, slots=True)
class WriteLabels:
    """Task: make the bytes of a label file."""

    factors: Factors
    suffix: str
    """Suffix of the file, such as ``.csv``."""


@dataclass(frozen=True, slots=True)
class ReadLabels:
    """Task: read a label file: `LabelledFactors`."""

    content: bytes
    suffix: str


@dataclass(frozen=True, slots=True)
class LabelledFactors:
    """Scores of a label file."""

    factors: Factors
    notes: tuple[str, ...]
    """Notes on how the file was read; see `Labels.notes`."""


@dataclass(frozen=True, slots=True)
class LearnGrammar:
    """Task: learn a grammar from scores, beside the session file: `LearnedFile`."""

    factors: Factors
    wide: bool
    """Whether the pool has been widened for rare models."""


@dataclass(frozen=True, slots=True)
class LearnedFile:
    """A learned grammar."""

    file: str
    """Name of the file, without a folder."""
    text: str
    js: float
    """Divergence in nats from the learned density."""
    rules_before: int
    rules_after: int
    findings: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DrawSheet:
    """Task: draw samples of the learned grammar, as the bytes of a PNG file."""

    num: int
    seed: int
