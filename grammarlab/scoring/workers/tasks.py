"""What a session asks other processes to do, and what they answer. Light, since every process loads it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import Finding
from grammarlab.scoring.record.said import Scores

Singles = NDArray[np.float32]
Factors = dict[str, Scores]
"""What was said by factor and subject."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far something is that takes long."""

    stage: str
    done: int
    total: int

    def as_json(self) -> dict[str, Any]:
        """As the page is told."""
        return {"stage": self.stage, "done": self.done, "total": self.total}


@dataclass(frozen=True, slots=True)
class Begin:
    """Asks whether the grammar can be derived; an error says why not."""


@dataclass(frozen=True, slots=True)
class DrawModels:
    """Asks for pictures of models: `DrawnModels`."""

    models: tuple[str, ...]
    """Addresses."""
    size: int
    """Pixels along each side."""
    samples: int
    """Along each side of a pixel: 1 is quick, 2 good."""


@dataclass(frozen=True, slots=True)
class DrawnModels:
    """Pictures of models."""

    pictures: tuple[NDArray[np.uint8], ...]
    """[size, size, 3] of each model."""
    warnings: tuple[Finding, ...] = ()
    """What is not on them, or on those drawn before, as the rules mean it."""


@dataclass(frozen=True, slots=True)
class MakeGlb:
    """Asks for a model as the bytes of a GLB file."""

    model: str
    """Address."""


@dataclass(frozen=True, slots=True)
class FindPart:
    """Asks where a part of a model, one visible shape, comes from: `FoundPart`."""

    model: str
    """Address."""
    number: int
    """Of the part, or of one of its triangles; parts are counted round and round."""
    is_triangle: bool


@dataclass(frozen=True, slots=True)
class FoundPart:
    """A visible shape of a model."""

    number: int
    count: int
    """How many parts the model has."""
    triangles: tuple[int, int]
    """Its first triangle among those of the model's file, and the one after its last."""
    path: tuple[tuple[str, str], ...]
    """Symbols from the initial shape down to this one, each with the place (file:line:column) of the branch that
    rewrote it, or where nothing did, of the word that made it."""


@dataclass(frozen=True, slots=True)
class Prepare:
    """Asks for the features of the pool: `Features`."""


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """How to choose models."""

    way: str
    """See `grammarlab.preference.questions.queries`."""
    factor: str
    """Whose labels and preference are looked at; empty for the product of all."""
    num: int
    seed: int


@dataclass(frozen=True, slots=True)
class Choose:
    """Asks for models to show: [num] addresses, of the pool or, with those already ranked, of any that have a score."""

    factors: Factors
    numbers: Mapping[str, int]
    """Of the factors; they stay when a factor is renamed."""
    choice: ModelChoice


@dataclass(frozen=True, slots=True)
class Update:
    """Asks to learn from all scores: `LearnedUpdate`."""

    factors: Factors
    numbers: Mapping[str, int]
    """As of `Choose`."""
    choice: ModelChoice | None
    """What to show then; None for nothing new, and to keep the pool as it is."""
    known: int = 0
    """`Features.version` of the features that need not be sent again."""
    wide: bool = False
    """Whether the pool has been widened for rare models; if not, it is widened once liked models are rare."""


@dataclass(frozen=True, slots=True)
class Features:
    """What models are told apart by: those of the pool, then those of `LearnedUpdate.elsewhere`."""

    version: int
    """1, 2, 3 …"""
    rows: Singles
    """[m + e, F] scaled."""
    names: tuple[str, ...]
    """[F] all different."""


@dataclass(frozen=True, slots=True)
class Predictions:
    """What is expected of the models of the pool, and then of those of `LearnedUpdate.elsewhere`."""

    mean: Singles
    """[m + e] 0 to 100, or a little beyond."""
    std: Singles
    """[m + e]"""
    weights: Singles | None
    """[F] of the kernel, where it has such."""
    relevance: tuple[tuple[str, str, float], ...]
    """Name, level and share of what matters most."""


@dataclass(frozen=True, slots=True)
class LearnedUpdate:
    """What an update found."""

    features: Features | None
    """Where they are others than those that are known."""
    wide: bool
    """Whether this is about the pool that is widened for rare models."""
    elsewhere: tuple[str, ...]
    """[e] addresses of models that have a score and are not of the pool."""
    factors: Mapping[str, Predictions]
    """Of the factors that have labels."""
    product: Predictions | None
    """Of the factors that have a score above 0; None where there are none."""
    left_out: tuple[str, ...]
    """Why factors are not part of the product."""
    js: float
    """How far the density moved since the update before, or since the grammar itself, in nats."""
    chosen: tuple[str, ...] | None
    """Addresses of the models to show."""
    words: tuple[str, ...] = ()
    """What is liked and what is not, a sentence each."""
    gain: float | None = None
    """Nats by which 16 more scores are expected to bring the density nearer; None where that cannot be told."""


@dataclass(frozen=True, slots=True)
class WriteLabels:
    """Asks for the bytes of a label file."""

    factors: Factors
    suffix: str
    """Such as ``.csv``."""


@dataclass(frozen=True, slots=True)
class ReadLabels:
    """Asks for what is in a label file: `Factors`."""

    content: bytes
    suffix: str


@dataclass(frozen=True, slots=True)
class LearnGrammar:
    """Asks for a grammar learned from scores, beside the session file: `LearnedFile`."""

    factors: Factors
    wide: bool
    """Whether the pool has been widened for rare models."""


@dataclass(frozen=True, slots=True)
class LearnedFile:
    """A learned grammar."""

    file: str
    """Name, without a folder."""
    text: str
    js: float
    """Divergence in nats from what was learned."""
    rules_before: int
    rules_after: int
    findings: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DrawSheet:
    """Asks for a picture of samples of the learned grammar, as the bytes of a PNG file."""

    num: int
    seed: int
