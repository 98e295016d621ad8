"""The derivation trees of a whole batch of models, as flat columns.

One row a node: every shape that a rule was applied to, and every leaf. Node ids are row numbers and a parent stands
before its children. One row a draw: every stochastic choice and every random number, where it was made and its
log-density.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.lots import Lots
from grammarlab.derivation.values.materials import Materials
from grammarlab.errors import Location
from grammarlab.geometry.meshes.mesh import Meshes

Floats = NDArray[np.float64]
NodeIds: TypeAlias = NDArray[np.int16 | np.int32]
"""As wide as the grammar needs: int16 where it has at most 32,767 symbols, rules, random expressions and successors."""


@dataclass(frozen=True, slots=True)
class RuleName:
    """One way to rewrite a symbol: a leaf of the case and stochastic tree of a rule."""

    symbol: str
    parameters: int
    """How many parameters the rule has (overloads differ in it)."""
    branch: tuple[int, ...]
    """Which branch at each level of the tree, from the top; empty when the rule has no choice."""
    line: int
    """Where the branch stands in the rule file, from 1."""


SiteKind: TypeAlias = Literal["choice", "uniform", "bernoulli", "file", "item"]


@dataclass(frozen=True, slots=True)
class Site:
    """One random expression of a grammar."""

    name: str
    """What people call it: ``height`` where the draw is the value of that attribute, so that ``$height`` in an
    expression means what it says; else the rule, function or attribute it stands in, numbered in the order of the text
    where that has several: ``Wall``, ``Wall#2``. An attribute drawn from one of several ranges
    (``25%: rand(1, 2) else: rand(2, 5)``) has one name for all of them; every other name stands for one site."""
    kind: SiteKind
    """``N%`` lists, ``rand``, ``p``, ``fileRandom``, and ``listRandom`` and others that draw an item of a list."""
    definition: str
    """The rule, function or attribute it stands in."""
    line: int
    """Where it stands in the rule file, from 1."""
    choices: int
    """How many branches a choice has; 0 for the other kinds."""


@dataclass(frozen=True, slots=True)
class Nodes:
    """N nodes."""

    model: NDArray[np.int32]
    """[N] model, from 0 within the batch."""
    parent: NDArray[np.int32]
    """[N] row of the parent, -1 for a root; parent < child."""
    symbol: NodeIds
    """[N] index into `Forest.symbols`."""
    rule: NodeIds
    """[N] index into `Forest.rules`, -1 for a leaf."""
    child: NodeIds
    """[N] which successor of the parent's rule, counted from 0 through the text of the branch."""
    repeat: NDArray[np.int32]
    """[N] which of the shapes that this successor made under one parent, from 0 in order of derivation."""

    def __len__(self) -> int:
        return len(self.model)


@dataclass(frozen=True, slots=True)
class Leaves:
    """L leaf shapes with geometry: a mesh placed by ``position + frames[frame] @ (size * point)``."""

    node: NDArray[np.int32]
    """[L] the node."""
    position: Floats
    """[L, 3] origin of the scope in metres along the world's axes, from the origin of its model (`Forest.origins`)."""
    size: Floats
    """[L, 3] size of the scope in metres, >= 0."""
    frame: NDArray[np.int32]
    """[L] index into `Forest.frames`: the directions of the scope's axes."""
    mesh: NDArray[np.int32]
    """[L] index into `Forest.meshes`, whose points lie in the unit cube."""
    material: NDArray[np.int32]
    """[L] index into `Forest.materials`."""
    texture_map: NDArray[np.int32]
    """[L] index into `Forest.texture_maps`, -1 for leaves without texture coordinates."""

    def __len__(self) -> int:
        return len(self.node)


@dataclass(frozen=True, slots=True)
class Draws:
    """D recorded random draws."""

    node: NDArray[np.int32]
    """[D] the node during whose rewriting it was made."""
    site: NodeIds
    """[D] which random expression of the grammar, index into `Forest.sites`."""
    value: Floats
    """[D] the number drawn; for a choice, the index of the branch taken."""
    log_density: Floats
    """[D] natural logarithm of the density (of the probability, for a choice)."""


@dataclass(frozen=True, slots=True)
class Reports:
    """R values that ``report`` collected."""

    node: NDArray[np.int32]
    key: NDArray[np.int32]
    """[R] index into `keys`."""
    value: Floats
    """[R] the number (0 or 1 for a bool, NaN for a string)."""
    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True, order=True)
class MissingAsset:
    """A mesh that the asset folder lacks; a unit box stood in its place."""

    path: str
    """As the rules call it."""
    location: Location
    """The first place in the rule file that asked for it."""


def by_path(missing: Iterable[MissingAsset]) -> tuple[MissingAsset, ...]:
    """Each missing asset once, at its first place, by path."""
    first = {asset.path: asset for asset in sorted(missing, reverse=True)}
    return tuple(first[path] for path in sorted(first))


@dataclass(frozen=True, slots=True)
class Forest:
    """The derivation trees of a batch of models of one grammar.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> extrude(rand(3, 9)) Tower"), 4, seed=1)
    >>> forest.num_models, forest.symbols
    (4, ('Lot', 'Tower'))
    """

    lots: Lots
    """[num_models] what the models were made of; row i of it is model i of the batch."""
    symbols: tuple[str, ...]
    rules: tuple[RuleName, ...]
    sites: tuple[Site, ...]
    """The random expressions of the grammar, in the order of the text."""
    nodes: Nodes
    leaves: Leaves
    draws: Draws
    reports: Reports
    frames: Floats
    """[K, 3, 3] proper rotations; columns are a scope's axes in the world."""
    meshes: Meshes
    materials: Materials
    texture_maps: Floats
    """[K, 2, 4] how the colour map lies: u and v of a point, counted as positions are, are rows times (x, y, z, 1), v
    upwards."""
    prints: tuple[str, ...] = ()
    """The texts that ``print`` showed while these models were derived, at most 10,000; no part of a stored forest."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """By path; no part of a stored forest."""

    @property
    def num_models(self) -> int:
        """How many models there are."""
        return len(self.lots)

    @property
    def origins(self) -> Floats:
        """[num_models, 3] where positions count from, in world metres; 0 but for models on far footprints."""
        return self.lots.origins

    def log_probability(self) -> Floats:
        """[num_models] natural logarithm of the density of each model's draws."""
        model = self.nodes.model[self.draws.node]
        return np.bincount(model, weights=self.draws.log_density, minlength=self.num_models).astype(np.float64)

    def shapes_per_model(self) -> NDArray[np.int64]:
        """[num_models] nodes of each model."""
        return np.bincount(self.nodes.model, minlength=self.num_models)
