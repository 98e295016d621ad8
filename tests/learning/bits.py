"""A space of designs that are rows of random bits, to try the loop on without a grammar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from grammarlab.features.columns.feature_table import FeatureTable
from grammarlab.features.columns.plain_columns import feature_values
from grammarlab.features.patterns.pattern import Draw
from grammarlab.learning.answers import Answers
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.round import Study
from grammarlab.learning.settings import FeatureOptions, Settings

BITS, SIZE = 5, 192


@dataclass(frozen=True)
class Shown:
    """The columns of the first bits."""

    num: int

    def apply(self, designs):
        rows = np.concatenate([np.zeros((0, BITS)), *designs])[:, : self.num]
        names = tuple(f"bit {number}" for number in range(self.num))
        groups = np.arange(self.num)
        return FeatureTable(sparse.csr_array(rows), tuple(map(Draw, names)), names, groups, names, np.ones(self.num))


@dataclass(frozen=True)
class BitsSpace(AbstractDesignSpace[np.ndarray]):
    """Paths of length 1 show all bits but the last, and longer ones show all. The proposal likes ones."""

    share: float = 0.5
    """Of ones."""
    blind: bool = False
    """Whether even the longest paths never show the last bit."""

    @property
    def longest_path(self):
        return 4

    @property
    def hashes(self):
        return "a" * 64, "b" * 64

    def _row(self, address):
        random = np.random.default_rng([address.seed % 2**32, address.model])
        return (random.random(BITS) < (0.9 if address.flat else self.share)).astype(float)

    def make(self, addresses):
        return np.array([self._row(address) for address in addresses]).reshape(-1, BITS)

    def sample(self, flat, num, seed, first=0):
        yield self.make([Address(flat, seed, first + number) for number in range(num)])

    def log_ratio(self, designs):
        ones, zeros = designs.sum(axis=1), (1 - designs).sum(axis=1)
        return ones * np.log(self.share / 0.9) + zeros * np.log((1 - self.share) / 0.1)

    def take(self, designs, indices):
        return designs[indices]

    def vocabulary(self, designs, features):
        return Shown(BITS - 1 if features.path_length == 1 or self.blind else BITS)

    def values(self, designs, features):
        rows = np.concatenate([np.zeros((0, BITS)), *designs])
        columns = {f"bit {number}": rows[:, number] for number in range(BITS)}
        return np.column_stack([rows[:, :0], *(feature_values(columns, feature) for feature in features)])

    def realize(self, addresses):
        raise AssertionError("nobody looks at bits")


def study_of(space=None, *, size=SIZE, path_length=2, others=(), **settings):
    """A pool of bits and how to learn about them."""
    features = FeatureOptions(path_length, ())
    return Study(space or BitsSpace(), Pool(0, size), Settings(features, **settings), others)


def score_of(rows):
    """[n, 2] what two factors are liked: the first bit, more with the last one; the second bit."""
    return np.column_stack([100.0 * rows[:, 0] * (0.5 + 0.5 * rows[:, -1]), 40.0 + 60.0 * rows[:, 1]])


def answers_about(study, designs, factor=0, score=score_of):
    """Answers of somebody who scores exactly."""
    return Answers(f"factor {factor}", tuple(designs), score(study.space.make(designs))[:, factor])
