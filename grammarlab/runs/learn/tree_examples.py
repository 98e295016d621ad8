"""Learning species from example trees."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.density.samples.tree_kinds import species_of_examples
from grammarlab.errors import AssetError, UsageError
from grammarlab.files import PART_PREFIX
from grammarlab.learning.designs.species_space import SpeciesSpace
from grammarlab.learning.targets.species_target import LearnedSpecies
from grammarlab.randomness import root_keys
from grammarlab.runs.learn.example_learners import AbstractExampleLearner
from grammarlab.runs.sample.records import DERIVATIONS
from grammarlab.runs.sample.tree_table import MAX_TREES, TREES, TreeTable
from grammarlab.trees.accepted_trees import accepted_rows, log_density
from grammarlab.trees.species_file import write

METHODS = ("kinds",)
_POOL_TREES = 5_000
"""Number of trees of the original species that densities are compared on."""
_MAX_FOLDERS = 20_000
"""Largest number of batches in a folder."""


@dataclass(frozen=True)
class TreeExamples(AbstractExampleLearner[Floats]):
    """Learns a species with the kinds of the original, divided by bounds on parameters; its rule is the original one.

    An example is its parameters [P], so that n examples are an array [n, P].
    """

    space: SpeciesSpace

    @property
    def methods(self) -> tuple[str, ...]:
        return METHODS

    def read(self, path: Path) -> Floats:
        parts: list[Floats] = []
        for file in _files(path):
            parts.append(TreeTable.read(file).rows)
            if sum(map(len, parts)) > MAX_TREES:
                raise AssetError(f"{path}: more than {MAX_TREES:,} trees. Give a part of them.")
        return np.concatenate(parts)

    def count(self, designs: Floats) -> int:
        return len(designs)

    def take(self, designs: Floats, indices: Ints) -> Floats:
        return designs[indices]

    def learn(self, designs: Floats, method: str, lines: Sequence[str]) -> tuple[LearnedSpecies, int]:
        species = species_of_examples(self.space.species, designs)
        head = "".join(f"# {line}\n" for line in lines)
        learned = LearnedSpecies(
            text=f"{head}\n{write(species)}",
            method=method,
            base="grammar",
            before=self.space.species,
            accept_rate=None,
            findings=(),
            assets=self.space.assets,
        )
        return learned, len(species.kinds)

    def ratio(self, learned: LearnedSpecies, designs: Floats) -> Floats:
        ratio = self._ratio(learned, designs)
        # Both species have one acceptance rule, and keep different shares of their trees.
        return ratio / self.pool(learned, 0)[0].mean() if self.space.species.acceptance else ratio

    def pool(self, learned: LearnedSpecies, seed: int) -> tuple[Floats, Floats]:
        rows = accepted_rows(self.space.species, root_keys(seed, np.arange(_POOL_TREES))).rows
        return self._ratio(learned, rows), np.ones(len(rows))

    def _ratio(self, learned: LearnedSpecies, rows: Floats) -> Floats:
        return np.exp(log_density(learned.space.species, rows) - log_density(self.space.species, rows))


def _files(path: Path) -> Iterator[Path]:
    """The tables of trees at a path."""
    if path.is_file():
        if path.suffix != ".parquet":
            raise UsageError(f"{path}: expected a folder that grammarlab sample wrote, or its {TREES}.")
        yield path
        return
    if not path.is_dir():
        raise UsageError(f"no examples at {str(path)!r}: expected a folder that grammarlab sample wrote.")
    for folder in (path / DERIVATIONS, path):
        # A folder of a batch that was killed may lack rows.
        files = sorted(file for file in folder.glob(f"*/{TREES}") if not file.parent.name.startswith(PART_PREFIX))
        if (folder / TREES).is_file():
            files = [folder / TREES]
        if len(files) > _MAX_FOLDERS:
            raise AssetError(f"{folder}: {len(files):,} batches; {_MAX_FOLDERS:,} can be read.")
        if files:
            yield from files
            return
    raise UsageError(f"{path}: expected trees in this folder, as grammarlab sample writes them, found none.")
