"""Learning grammars from example models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.density.samples.examples import EXAMPLE_METHODS, ExampleMethod, learn_from_examples
from grammarlab.derivation.forest import Forest
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool, PoolDesigns
from grammarlab.learning.targets.writers import Learned
from grammarlab.runs.learn.example_learners import AbstractExampleLearner
from grammarlab.runs.learn.example_models import example_models


@dataclass(frozen=True)
class GrammarExamples(AbstractExampleLearner[Forest]):
    """Learns the maximum-likelihood grammar of models near a grammar."""

    space: GrammarSpace

    @property
    def methods(self) -> tuple[str, ...]:
        return EXAMPLE_METHODS

    def read(self, path: Path) -> Forest:
        return example_models(path, self.space.grammar)

    def count(self, designs: Forest) -> int:
        return designs.num_models

    def take(self, designs: Forest, indices: Ints) -> Forest:
        return self.space.take(designs, indices)

    def learn(self, designs: Forest, method: str, lines: Sequence[str]) -> tuple[Learned[Forest], int]:
        chosen, grammar = cast(ExampleMethod, method), self.space.grammar
        learned = learn_from_examples(grammar, designs, chosen, header=lines, assets=self.space.assets)
        return learned, len(learned.components)

    def ratio(self, learned: Learned[Forest], designs: Forest) -> Floats:
        return learned.ratio(designs)

    def pool(self, learned: Learned[Forest], seed: int) -> tuple[Floats, Floats]:
        pool_designs = PoolDesigns.of(self.space, Pool(seed))
        return np.concatenate([learned.ratio(forest) for forest in pool_designs.batches]), pool_designs.weights
