"""Densities over the models of a grammar that can be sampled and evaluated."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, overload

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.lots import Lots
from grammarlab.errors import check_type
from grammarlab.features.acceptance import Acceptance, derive_accepted
from grammarlab.language.grammar import EXAMPLE, Grammar
from grammarlab.randomness import root_keys
from grammarlab.scene.instances import Scene, realize
from grammarlab.trees.species import Species

if TYPE_CHECKING:
    from grammarlab.trees.skeleton import Skeleton


class AbstractSampler(ABC):
    """A density over the derivation trees of one grammar."""

    @abstractmethod
    def sample(self, num_models: int, seed: int) -> Forest:
        """Models drawn from the density, as trees of its grammar.

        Args:
            num_models: number of models.
            seed: 0 <= seed < 2**64; the same seed gives the same models.
        """

    def scene(self, num_models: int, seed: int) -> Scene:
        """The models of `sample`, as meshes."""
        return realize(self.sample(num_models, seed))

    @abstractmethod
    def log_density(self, forest: Forest) -> Floats:
        """Natural logarithm of the density [models] of trees of the grammar; -inf where it is 0."""


class GrammarSampler(AbstractSampler):
    """A grammar's own density; with an acceptance rule it is known up to a factor.

    Args:
        grammar: the grammar.
        assets: folder of its meshes and images, by default that of the grammar.
    """

    def __init__(self, grammar: Grammar, assets: AssetRoot | None = None) -> None:
        check_type("grammar", grammar, Grammar, EXAMPLE)
        self._grammar = grammar
        self._assets = grammar.assets if assets is None else assets

    def sample(self, num_models: int, seed: int) -> Forest:
        acceptance = Acceptance.of(self._grammar.tree)
        assets = None if self._assets is None else AssetFolder(self._assets)
        return derive_accepted(compile_grammar(self._grammar), acceptance, Lots.of(num_models, seed), assets).forest

    def log_density(self, forest: Forest) -> Floats:
        acceptance = Acceptance.of(self._grammar.tree)
        if acceptance is None:
            return forest.log_probability()
        with np.errstate(divide="ignore"):
            return forest.log_probability() + np.log(acceptance.probabilities(forest))


@overload
def sample(grammar: Grammar, num_models: int, seed: int = ..., *, assets: AssetRoot | None = ...) -> Forest: ...
@overload
def sample(grammar: Species, num_models: int, seed: int = ..., *, assets: AssetRoot | None = ...) -> Skeleton: ...
def sample(
    grammar: Grammar | Species, num_models: int, seed: int = 0, *, assets: AssetRoot | None = None
) -> Forest | Skeleton:
    """Models of a grammar, or trees of a species, that the acceptance rule of the file keeps.

    `derive` ignores acceptance rules, and gives the same for a grammar without one.

    Args:
        grammar: the grammar or species.
        num_models: how many.
        seed: 0 <= seed < 2**64; the same seed gives the same models.
        assets: folder of meshes and images, by default that of the grammar; the stems of trees need none.

    >>> import grammarlab as gl
    >>> grammar = gl.Grammar.parse("Lot --> 50% : extrude(3) Low else : extrude(9) High")
    >>> gl.sample(grammar, 5, seed=1).num_models
    5
    >>> palm = gl.load("palm")
    >>> trees = gl.sample(palm, 2, seed=1)
    >>> gl.realize_trees(trees, palm.look, "low", palm.assets).num_models
    2
    """
    check_type("grammar", grammar, (Grammar, Species), EXAMPLE)
    if isinstance(grammar, Grammar):
        return GrammarSampler(grammar, assets).sample(num_models, seed)
    from grammarlab.trees.accepted_trees import accepted_rows  # noqa: PLC0415  # grammars do without trees
    from grammarlab.trees.growth import grow  # noqa: PLC0415

    trees = accepted_rows(grammar, root_keys(seed, np.arange(num_models)))
    return grow(trees.rows, trees.keys)
