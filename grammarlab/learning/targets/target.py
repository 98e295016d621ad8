"""From what was learned to a file that samples it, whatever the designs are."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol

import numpy as np

from grammarlab.density.samples.sampled import NUM_SAMPLES
from grammarlab.density.splits.splitting import Base
from grammarlab.density.targets.thinning import Progress, silent
from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Feature
from grammarlab.learning.designs.design_space import Designs, Designs_contra, Floats
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.agreement import agreement
from grammarlab.learning.targets.measure import Measured, measured
from grammarlab.learning.targets.simplification import Predicted
from grammarlab.scene.instances import Scene


@dataclass(frozen=True, slots=True)
class Making:
    """How to make what samples a density."""

    method: str = ""
    """Of `AbstractTargetWriter.methods`; empty for the first one."""
    base: Base = "grammar"
    """What the preference multiplies: the density of the space, or the same for every design."""
    num_samples: int = NUM_SAMPLES
    """Designs to learn from, for the methods that need them."""
    max_rules: int | None = None
    """The description may be no larger (`Learned.rules_after`); None for twice the size that it had."""


class Learned(Protocol[Designs_contra]):
    """What samples a learned density."""

    @property
    def text(self) -> str:
        """A file of the kind that the space was read from, which samples the density; empty where there is none."""
        ...

    @property
    def method(self) -> str:
        """How it was made."""
        ...

    @property
    def base(self) -> Base:
        """As in `Making`."""
        ...

    @property
    def rules_before(self) -> int:
        """Size of the description of the space: alternatives of rules, cells of a table."""
        ...

    @property
    def rules_after(self) -> int:
        """That of the text."""
        ...

    @property
    def accept_rate(self) -> float | None:
        """Share of candidates that its acceptance rule keeps; None where it has none."""
        ...

    @property
    def findings(self) -> tuple[str, ...]:
        """What a person should know about how it was made."""
        ...

    def ratio(self, designs: Designs_contra, /) -> Floats:
        """[n] density of designs of the space by their density in the space."""
        ...

    def scene(self, num: int, seed: int, /) -> Scene:
        """Samples, as meshes."""
        ...


@dataclass(frozen=True, slots=True)
class Step:
    """What one step on the way to the file did to the density."""

    name: str
    js: float
    """Divergence in nats between the density before it and after it, on the pool."""


@dataclass(frozen=True)
class LearnedDensity(Generic[Designs]):
    """A density that was learned, made into what samples it.

    >>> import grammarlab as gl
    >>> grammar = gl.Grammar.parse("Lot --> 50% : extrude(3) Low else : extrude(9) High")
    >>> found = gl.learn(grammar, lambda forest: 100 * gl.count(forest, [gl.pattern("High")])[:, 0], budget=16)
    >>> print(found.learned.text.strip().splitlines()[-1])
    Lot --> extrude(9) High
    """

    learned: Learned[Designs]
    predicted: Predicted
    """What was learned."""
    features: tuple[Feature, ...]
    """[K] what the file looks at."""
    names: tuple[str, ...]
    """[K] the same in words."""
    steps: tuple[Step, ...]
    measured: Measured
    """Beside the predicted density, on the pool."""


class AbstractTargetWriter(ABC, Generic[Designs]):
    """Makes files that sample what was learned about a space."""

    @property
    @abstractmethod
    def methods(self) -> tuple[str, ...]:
        """How such a file can be made, the usual way first."""

    @abstractmethod
    def learn(
        self,
        study: Study[Designs],
        state: State,
        making: Making,
        lines: Sequence[str] = (),
        on_progress: Progress = silent,
    ) -> LearnedDensity[Designs]:
        """What samples in proportion to the predictions of a state.

        Args:
            study: of the space of this writer, at whose seed designs are drawn.
            state: what was learned; something is liked.
            making: how to make it.
            lines: of a comment at the top of the new file.
            on_progress: told about designs to learn from.

        Raises:
            UsageError: for an unknown method.
            GrammarlabError: when the density cannot be made.
        """

    def method(self, name: str) -> str:
        """The method of this name; the usual one where the name is empty.

        Raises:
            UsageError: when there is none.
        """
        check_method(name or self.methods[0], self.methods)
        return name or self.methods[0]


def check_method(method: str, known: Sequence[str]) -> None:
    """Makes sure that there is a method of this name.

    Raises:
        UsageError: when there is not.
    """
    if method not in known:
        raise UsageError(f"no method is called {method!r}; those there are: {', '.join(known)}")


def judged(
    study: Study[Designs],
    state: State,
    learned: Learned[Designs],
    predicted: Predicted,
    simple: Floats,
    looked_at: Mapping[Feature, str],
    base_ratio: Callable[[Designs], Floats] | None = None,
) -> LearnedDensity[Designs]:
    """What each step did to the density, and how near the result comes to the predicted one, on the pool.

    Args:
        study: the pool.
        state: what was learned.
        learned: the result.
        predicted: what it was made of.
        simple: [m] the scores of the pool, as the function that it was made into.
        looked_at: the features of this function, in words.
        base_ratio: [n] density that the preference multiplies by that of the space; None where it is that of the space.
    """
    made = study.tables(state.wide).made
    ratio = np.concatenate([learned.ratio(designs) for designs in made.batches])
    of_base = np.ones(len(ratio)) if base_ratio is None else np.concatenate([base_ratio(d) for d in made.batches])
    weights = made.weights * of_base
    relative = np.divide(ratio, of_base, out=np.zeros(len(ratio)), where=of_base > 0.0)
    steps = (
        Step("predictions made simple", agreement(predicted.scores, simple, weights).js),
        Step("made into a sampler", agreement(simple, relative, weights).js),
    )
    against = measured(predicted.scores * of_base, ratio, made.weights)
    return LearnedDensity(learned, predicted, tuple(looked_at), tuple(looked_at.values()), steps, against)
