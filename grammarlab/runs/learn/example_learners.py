"""Learning files of one kind from example models of them, by the suffix of the kind."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Generic

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.learning.designs.design_space import AbstractDesignSpace, Designs
from grammarlab.learning.targets.writers import Learned
from grammarlab.runs.sample.domains import DEFAULT, SPECIES

LEARNERS = {
    DEFAULT: "grammarlab.runs.learn.example_models:GrammarExamples",
    SPECIES: "grammarlab.runs.learn.tree_examples:TreeExamples",
}
"""Module and name of the `AbstractExampleLearner` of each suffix, imported when needed; made from a design space."""


class AbstractExampleLearner(ABC, Generic[Designs]):
    """Learns a file that makes example models likely."""

    @property
    @abstractmethod
    def methods(self) -> tuple[str, ...]:
        """Methods, the default first."""

    @abstractmethod
    def read(self, path: Path) -> Designs:
        """Examples from the output of ``grammarlab sample``: its folder, or a part of it.

        Raises:
            UsageError: If there are none, or they are not designs of the space.
            AssetError: If files are damaged or too large.
        """

    @abstractmethod
    def count(self, designs: Designs) -> int:
        """Number of examples."""

    @abstractmethod
    def take(self, designs: Designs, indices: Ints) -> Designs:
        """Selected examples, by ascending index."""

    @abstractmethod
    def learn(self, designs: Designs, method: str, lines: Sequence[str]) -> tuple[Learned[Any], int]:
        """A sampler near the space that makes the examples likely, and the number of its components.

        Args:
            designs: the examples.
            method: one of `methods`.
            lines: comment lines at the top of the new file.

        Raises:
            UsageError: If the examples are not designs of the space.
        """

    @abstractmethod
    def ratio(self, learned: Any, designs: Designs) -> Floats:
        """[n] density of examples under a result of `learn`, divided by that under the space."""

    @abstractmethod
    def pool(self, learned: Any, seed: int) -> tuple[Floats, Floats]:
        """Learned density of m designs of a pool divided by that of the space, and importance weights of these."""


def example_learner(suffix: str, space: AbstractDesignSpace[Any]) -> AbstractExampleLearner[Any]:
    """The learner of files of a suffix.

    Raises:
        UsageError: If there is none.
    """
    if suffix not in LEARNERS:
        raise UsageError(f"files that end in {suffix!r} cannot be learned from examples: give labels.")
    module, name = LEARNERS[suffix].split(":")
    return getattr(import_module(module), name)(space)
