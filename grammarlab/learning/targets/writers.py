"""Writers of files that sample a learned density, for any kind of designs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.exact.splitting import Base
from grammarlab.density.samples.sampled import NUM_SAMPLES
from grammarlab.density.targets.rejection import Progress, silent
from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Feature
from grammarlab.learning.designs.design_space import Designs, Designs_contra
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.divergence import Measured, agreement, measured
from grammarlab.learning.targets.simplification import Predicted
from grammarlab.scene.instances import Scene


@dataclass(frozen=True, slots=True)
class Making:
    """Options of making a sampler of a density."""

    method: str = ""
    """Method, one of `AbstractTargetWriter.methods`; empty for the first one."""
    base: Base = "grammar"
    """Density that the preference multiplies: that of the space, or the same for every design."""
    num_samples: int = NUM_SAMPLES
    """Number of designs to learn from, for methods that need them."""
    max_rules: int | None = None
    """Largest size of the description (`Learned.rules_after`); None for twice the original size."""


class Learned(Protocol[Designs_contra]):
    """Sampler of a learned density."""

    @property
    def text(self) -> str:
        """A file of the kind of the space, which samples the density; empty if there is none."""
        ...

    @property
    def method(self) -> str:
        """How it was made."""
        ...

    @property
    def base(self) -> Base:
        """See `Making`."""
        ...

    @property
    def units(self) -> tuple[str, str]:
        """What its size counts: one, and several; for a grammar branches of rules, for a species kinds."""
        ...

    @property
    def rules_before(self) -> int:
        """Size of the description of the space: branches of rules, cells of a table."""
        ...

    @property
    def rules_after(self) -> int:
        """Size of the description in the text."""
        ...

    @property
    def accept_rate(self) -> float | None:
        """Share of candidates that its acceptance rule keeps; None without a rule."""
        ...

    @property
    def findings(self) -> tuple[str, ...]:
        """Remarks for the user about how it was made."""
        ...

    def ratio(self, designs: Designs_contra, /) -> Floats:
        """[n] density of designs of the space, divided by their density in the space."""
        ...

    def scene(self, num: int, seed: int, /) -> Scene:
        """Samples, as meshes."""
        ...


@dataclass(frozen=True, slots=True)
class Step:
    """Change of the density by one step on the way to the file."""

    name: str
    js: float
    """Divergence in nats between the density before it and after it, on the pool."""


@dataclass(frozen=True, repr=False)
class LearnedDensity(Generic[Designs]):
    """A learned density with its sampler.

    >>> import grammarlab as gl
    >>> grammar = gl.Grammar.parse("Lot --> 50% : extrude(3) Low else : extrude(9) High")
    >>> found = gl.learn(grammar, lambda forest: 100 * gl.count(forest, [gl.pattern("High")])[:, 0], budget=16)
    >>> print(found.learned.text.strip().splitlines()[-1])
    Lot --> extrude(9) High
    >>> found
    <LearnedDensity: 1 branch of rules, 2 before. Does not like: Lot = Low (0; others 100).>
    """

    learned: Learned[Designs]
    predicted: Predicted
    """Predictions of the learned preference."""
    features: tuple[Feature, ...]
    """[K] features of the file."""
    names: tuple[str, ...]
    """[K] names of the features in words."""
    steps: tuple[Step, ...]
    measured: Measured
    """Comparison with the predicted density, on the pool."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks for the user, such as that the file needs an acceptance rule, which other engines ignore."""
        return (*self.predicted.findings, *self.learned.findings)

    def __repr__(self) -> str:
        """Size of the file, likes, dislikes, and remarks about how it was made."""
        learned, words = self.learned, self.predicted.words
        remarks = " ".join([*words.lines, *(f"{note[:1].upper()}{note[1:]}." for note in self.notes)])
        unit = learned.units[learned.rules_after != 1]
        size = f"{learned.rules_after} {unit}, {learned.rules_before} before."
        return f"<LearnedDensity: {size} {remarks}>"


class AbstractTargetWriter(ABC, Generic[Designs]):
    """Makes files that sample a density learned on a space."""

    @property
    @abstractmethod
    def methods(self) -> tuple[str, ...]:
        """Methods of making such a file, the default first."""

    @abstractmethod
    def learn(
        self,
        study: Study[Designs],
        state: State,
        making: Making,
        lines: Sequence[str] = (),
        on_progress: Progress = silent,
    ) -> LearnedDensity[Designs]:
        """Sampler in proportion to the predictions of a state.

        Args:
            study: a study of the space of this writer; designs are drawn at its seed.
            state: a state in which something is liked.
            making: options.
            lines: comment lines at the top of the new file.
            on_progress: called with the progress of designs to learn from.

        Raises:
            UsageError: If the method is unknown.
            GrammarlabError: If the density cannot be made.
        """

    def method(self, name: str) -> str:
        """The method of this name; the default if the name is empty.

        Raises:
            UsageError: If there is none.
        """
        check_method(name or self.methods[0], self.methods)
        return name or self.methods[0]


def check_method(method: str, methods: Sequence[str]) -> None:
    """Check that a method exists.

    Raises:
        UsageError: If it does not exist.
    """
    if method not in methods:
        raise UsageError(f"unknown method {method!r}; expected one of {', '.join(methods)}")


def judged(
    study: Study[Designs],
    state: State,
    learned: Learned[Designs],
    predicted: Predicted,
    simple: Floats,
    features: Mapping[Feature, str],
    base_ratio: Callable[[Designs], Floats] | None = None,
) -> LearnedDensity[Designs]:
    """Changes of the density by each step, and the comparison of the result with the predicted one, on the pool.

    Args:
        study: the pool.
        state: the state.
        learned: the result.
        predicted: the predictions it was made from.
        simple: [m] the scores of the pool by the simplified function.
        features: the features of this function, in words.
        base_ratio: [n] base density divided by that of the space; None if it is that of the space.
    """
    pool_designs = study.tables(state.wide).pool_designs
    ratio = np.concatenate([learned.ratio(designs) for designs in pool_designs.batches])
    base_weights = (
        np.ones(len(ratio)) if base_ratio is None else np.concatenate([base_ratio(d) for d in pool_designs.batches])
    )
    weights = pool_designs.weights * base_weights
    relative = np.divide(ratio, base_weights, out=np.zeros(len(ratio)), where=base_weights > 0.0)
    steps = (
        Step("predictions made simple", agreement(predicted.scores, simple, weights).js),
        Step("made into a sampler", agreement(simple, relative, weights).js),
    )
    against = measured(predicted.scores * base_weights, ratio, pool_designs.weights)
    return LearnedDensity(learned, predicted, tuple(features), tuple(features.values()), steps, against)
