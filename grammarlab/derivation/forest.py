"""The derivation trees of a whole batch of models, as flat columns.

Nodes have one row per shape that a rule was applied to, and one per leaf. Node ids are row numbers, and a parent comes
before its children. Draws have one row per stochastic choice and random number, with its place and its
log-density. `origin_of` returns the place in the rule text that made a node.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.lots import Lots, Values
from grammarlab.derivation.materials import Materials
from grammarlab.errors import Finding, Location
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.language.numbering import Numbering

NodeIds: TypeAlias = NDArray[np.int16 | np.int32]
"""Integers as wide as the grammar needs: int16 for at most 32,767 symbols, rules, random expressions and successors."""

SiteKind: TypeAlias = Literal["choice", "uniform", "bernoulli", "file", "item"]


@dataclass(frozen=True, slots=True)
class RuleName:
    """One way to rewrite a symbol: a leaf of the case and stochastic tree of a rule."""

    symbol: str
    parameters: int
    """Number of parameters of the rule (overloads differ in it)."""
    branch: tuple[int, ...]
    """Index of the branch at each level of the tree, from the top; empty if the rule has no choice."""
    line: int
    """Line of the branch in the rule file, from 1."""


@dataclass(frozen=True, slots=True)
class Site:
    """One random expression of a grammar."""

    name: str
    """Name in expressions: ``height`` if the draw is the value of that attribute, so that ``$height`` is its value;
    otherwise the rule, function or attribute that contains it, numbered in the order of the text
    if it has several: ``Wall``, ``Wall#2``. An attribute drawn from one of several ranges
    (``25%: rand(1, 2) else: rand(2, 5)``) has one name for all of them; every other name belongs to one site."""
    kind: SiteKind
    """``N%`` lists, ``rand``, ``p``, ``fileRandom``, and ``listRandom`` and others that draw an item of a list."""
    definition: str
    """The rule, function or attribute that contains it."""
    line: int
    """Line in the rule file, from 1."""
    choices: int
    """Number of branches of a choice; 0 for the other kinds."""


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
    """[N] index of the successor in the parent's rule, from 0 in the text of the branch."""
    repeat: NDArray[np.int32]
    """[N] index among the shapes that this successor made under one parent, from 0 in order of derivation."""

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
    """[D] the random expression, index into `Forest.sites`."""
    value: Floats
    """[D] the number drawn; for a choice, the index of the branch taken."""
    log_density: Floats
    """[D] natural logarithm of the density (of the probability, for a choice)."""


@dataclass(frozen=True, slots=True)
class Reports:
    """R values collected by ``report``."""

    node: NDArray[np.int32]
    key: NDArray[np.int32]
    """[R] index into `keys`."""
    value: Floats
    """[R] the number (0 or 1 for a bool, NaN for a string)."""
    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True, order=True)
class MissingAsset:
    """A mesh that the asset folder lacks, or that cannot be read; a unit box replaces it."""

    path: str
    """Path in the rules."""
    location: Location
    """First place in the rule file that uses it."""
    reason: str = ""
    """Why it cannot be read, with its path; empty if the folder lacks it."""


@dataclass(frozen=True, slots=True)
class Forest:
    """The derivation trees of a batch of models of one grammar.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> extrude(rand(3, 9)) Tower"), 4, seed=1)
    >>> forest.num_models, forest.symbols
    (4, ('Lot', 'Tower'))
    """

    lots: Lots
    """[num_models] addresses and options of the models; row i is model i of the batch."""
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
    """[K, 2, 4] maps to texture coordinates of the colour map: u and v (upwards) of a point are rows times
    (x, y, z, 1), with the origin of positions."""
    prints: tuple[str, ...] = ()
    """Texts printed by ``print`` during the derivation, at most 10,000; not stored with a forest."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Missing assets by path; not stored with a forest."""
    attributes: Mapping[str, Values] = field(default_factory=dict, compare=False)
    """[num_models] values by name of attributes and constants that are numbers, truth values or texts, before rules set
    others; not stored with a forest."""
    warnings: tuple[Finding, ...] = ()
    """What the derivation passed over, by place: each place in the rules once; not stored with a forest."""

    @property
    def num_models(self) -> int:
        """Number of models."""
        return len(self.lots)

    @property
    def origins(self) -> Floats:
        """[num_models, 3] origin of positions in world metres; 0 except for models on far footprints."""
        return self.lots.origins

    def log_probability(self) -> Floats:
        """[num_models] natural logarithm of the density of each model's draws."""
        model = self.nodes.model[self.draws.node]
        return np.bincount(model, weights=self.draws.log_density, minlength=self.num_models).astype(np.float64)

    def is_in_statistics(self) -> NDArray[np.bool_]:
        """[R] rows of `reports` that sums, means and extremes are made of: texts beside numbers of a key are left out.

        As in CityEngine, a key of a model that gets both numbers and texts keeps the numbers, and counts all.
        """
        model, is_number = self.nodes.model[self.reports.node].astype(np.int64), ~np.isnan(self.reports.value)
        group = model * max(len(self.reports.keys), 1) + self.reports.key
        return is_number | ~np.isin(group, group[is_number])

    def shapes_per_model(self) -> NDArray[np.int64]:
        """[num_models] nodes of each model."""
        return np.bincount(self.nodes.model, minlength=self.num_models)


@dataclass(frozen=True, slots=True)
class RuleOrigin:
    """Origin of a node in the rule text."""

    symbol: str
    made_at: Location | None
    """The successor that made it; None for the initial shape."""
    rule_at: Location | None
    """The branch of the rule that rewrote it; None for a leaf."""


def by_path(missing: Iterable[MissingAsset]) -> tuple[MissingAsset, ...]:
    """Each missing asset once, at its first place, by path."""
    first = {asset.path: asset for asset in sorted(missing, reverse=True)}
    return tuple(first[path] for path in sorted(first))


def by_place(warnings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Each warning once, in the order of places."""
    return tuple(sorted(dict.fromkeys(warnings), key=lambda finding: (finding.location, finding.message)))


def origin_of(forest: Forest, numbering: Numbering, node: int) -> RuleOrigin:
    """Origin of a node of a forest in the rule text.

    Args:
        forest: models of a grammar.
        numbering: numbering of the grammar.
        node: row of the node.
    """
    nodes = forest.nodes
    rule, parent = int(nodes.rule[node]), int(nodes.parent[node])
    made_at = None
    if parent >= 0:
        made_at = numbering.branches[nodes.rule[parent]].successors[nodes.child[node]].location
    return RuleOrigin(
        forest.symbols[nodes.symbol[node]], made_at, numbering.branches[rule].location if rule >= 0 else None
    )


def way_to(forest: Forest, node: int) -> list[int]:
    """Nodes on the path from the root to a node, both included."""
    way = [node]
    while (parent := int(forest.nodes.parent[way[-1]])) >= 0:
        way.append(parent)
    return way[::-1]
