"""The trees of a species as a space of designs; its proposal draws all kinds of trees equally often."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property, lru_cache
from hashlib import sha256

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import UsageError
from grammarlab.features.columns.plain_columns import feature_values
from grammarlab.features.patterns.conditions import sites_of
from grammarlab.features.patterns.pattern import Feature
from grammarlab.learning.designs.addresses import Address, hashes_of
from grammarlab.learning.designs.design_space import AbstractDesignSpace, Realized
from grammarlab.learning.designs.tree_columns import TreeBatch, TreeColumns, columns_of, relevant_names, unit_of
from grammarlab.learning.settings import LEAST_POOL, POOL_SIZE, FeatureOptions
from grammarlab.randomness import Keys, root_keys
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.language import Candidates, candidates
from grammarlab.trees.accepted_trees import accepted_rows, log_density, measured
from grammarlab.trees.growth import expected_nodes, grow
from grammarlab.trees.measures import MEASURES
from grammarlab.trees.parameters import COLUMNS
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.species import Species, constrained, drawn

_DETAIL = "detail"
"""Attribute that changes the meshes of a tree only."""
_BATCH_TREES = 500
"""Number of trees per batch, and for estimating acceptance rates."""
_POOL_NODES = 5e8
"""Expected number of nodes of all trees of a usual pool, a budget of about a minute."""
_SIZE_TREES = 64
"""Number of trees from which the size of a usual pool follows."""
_CACHED_BATCHES = 64
"""Number of batches that are kept, at .5 MB each."""


@dataclass(frozen=True, eq=False)
class SpeciesSpace(AbstractDesignSpace[TreeBatch]):
    """The trees that a species draws and keeps."""

    species: Species
    text: str
    """The file of the species."""
    assets: AssetRoot | None = None
    """Folder of pictures."""

    @property
    def hashes(self) -> tuple[str, str]:
        return hashes_of(sha256(self.text.encode()).hexdigest())

    @property
    def longest_path(self) -> int:
        return 1

    @property
    def pool_size(self) -> int:
        rows, _ = drawn(self.species, root_keys(0, np.arange(_SIZE_TREES)))
        return int(np.clip(_POOL_NODES / expected_nodes(rows).mean(), LEAST_POOL, POOL_SIZE))

    @cached_property
    def proposal(self) -> Species:
        """The species with equally frequent kinds."""
        kinds = self.species.kinds
        return replace(self.species, kinds=tuple(replace(kind, weight=1.0 / len(kinds)) for kind in kinds))

    def unit_of(self, draw: str) -> str:
        return unit_of(draw)

    def make(self, addresses: Sequence[Address]) -> TreeBatch:
        rows, keys = self.drawn(addresses)
        return TreeBatch(rows, keys, measured(rows, keys))

    def drawn(self, addresses: Sequence[Address]) -> tuple[Floats, Keys]:
        """Parameters [n, P] of the trees at addresses, and the keys [n] below which they grow.

        Raises:
            UsageError: If an address has a start rule, a footprint, or attributes that are not parameters.
        """
        rows, keys = np.zeros((len(addresses), len(self.species.typical))), np.zeros(len(addresses), dtype=np.uint64)
        alike: dict[tuple[bool, str], list[int]] = {}
        for number, address in enumerate(addresses):
            if address.start_rule or address.footprint:
                raise UsageError("labels name a start rule or a footprint, and trees have neither.")
            alike.setdefault((address.flat, address.attributes), []).append(number)
        for (flat, attributes), numbers in alike.items():
            species = self.proposal if flat else self.species
            values = {name: value for name, value in json.loads(attributes).items() if name != _DETAIL}
            accepted = accepted_rows(
                constrained(species, values),
                root_keys(
                    np.array([addresses[number].seed for number in numbers], dtype=np.uint64),
                    np.array([addresses[number].model for number in numbers], dtype=np.uint64),
                ),
            )
            rows[numbers], keys[numbers] = accepted.rows, accepted.keys
        return rows, keys

    def sample(self, flat: bool, num: int, seed: int, first: int = 0) -> Iterator[TreeBatch]:
        for start in range(first, first + num, _BATCH_TREES):
            yield self._batch(flat, seed, start, min(start + _BATCH_TREES, first + num))

    @cached_property
    def _batch(self) -> Callable[[bool, int, int, int], TreeBatch]:
        """The trees of a range of numbers; recent ones are kept, since several studies ask about one pool."""

        def make(flat: bool, seed: int, first: int, end: int) -> TreeBatch:
            return self.make([Address(flat, seed, number) for number in range(first, end)])

        return lru_cache(maxsize=_CACHED_BATCHES)(make)

    def log_ratio(self, designs: TreeBatch) -> Floats:
        if len(self.species.kinds) == 1:
            return np.zeros(len(designs))
        ratio = log_density(self.species, designs.rows) - log_density(self.proposal, designs.rows)
        return ratio + self._log_ratio_of_rates

    @cached_property
    def _log_ratio_of_rates(self) -> float:
        """Log of the ratio of the acceptance rates of the proposal and of the species."""
        if not self.species.acceptance:
            return 0.0
        keys = root_keys(0, np.arange(_BATCH_TREES))
        proposal_tries, own_tries = (accepted_rows(species, keys).tries for species in (self.proposal, self.species))
        return float(np.log(own_tries.sum()) - np.log(proposal_tries.sum()))

    def take(self, designs: TreeBatch, indices: Ints) -> TreeBatch:
        return designs.take(indices)

    def vocabulary(self, designs: Sequence[TreeBatch], features: FeatureOptions) -> TreeColumns:
        return TreeColumns.of(self.names if "draws" in features.families else (), designs)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters that differ between trees, and of the measures."""
        return relevant_names(self.species)

    def candidates(self, designs: Sequence[TreeBatch]) -> Candidates:
        return candidates(Elements.of_columns(columns_of(designs, self.names), sum(map(len, designs))))

    def values(self, designs: Sequence[TreeBatch], features: Sequence[Feature]) -> Floats:
        columns = columns_of(designs, [site for feature in features for site in sites_of(feature)])
        num = sum(map(len, designs))
        return np.column_stack([np.zeros((num, 0)), *(feature_values(columns, feature) for feature in features)])

    def check(self, features: Iterable[Feature]) -> None:
        known = (*COLUMNS, *MEASURES)
        for feature in features:
            sites = sites_of(feature)
            if not sites:
                raise UsageError(f"trees have no {feature}; expected parameters and measures, such as $height")
            for site in sites:
                if site not in known:
                    near = get_close_matches(site, known, n=3, cutoff=0.6)
                    hint = f"; did you mean {' or '.join(near)}?" if near else ""
                    raise UsageError(f"trees have no parameter or measure {site!r}{hint}")

    def log_density(self, designs: TreeBatch) -> Floats:
        return log_density(self.species, designs.rows)

    def realize(self, addresses: Sequence[Address]) -> Realized:
        rows, keys = self.drawn(addresses)
        return Realized(realize_trees(grow(rows, keys), self.species.look, "medium", self.assets))

    def asset_names(self) -> Iterable[str]:
        look = self.species.look
        return [name for name in (look.bark, look.leaf, look.blossom) if name]
