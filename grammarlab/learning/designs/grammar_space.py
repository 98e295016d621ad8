"""The models of a stochastic grammar as a space of designs; its proposal is the grammar with equal percentages."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from grammarlab.arrays import BATCH, Floats, Ints
from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.density.targets.rejection import PILOT_MODELS
from grammarlab.derivation.derive import derive, derive_chunks, models_in_reach
from grammarlab.derivation.expressions import number_grammar
from grammarlab.derivation.forest import Forest, origin_of, way_to
from grammarlab.derivation.lots import DEFAULT_FOOTPRINT, Footprint, Lots
from grammarlab.derivation.program import Program
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.derivation.state.width_attribute import STREET_WIDTH
from grammarlab.errors import GrammarlabError, UsageError, shown
from grammarlab.features.acceptance import Acceptance
from grammarlab.features.accepted_grammar import AcceptedGrammar
from grammarlab.features.columns.feature_table import FeatureTable
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Feature
from grammarlab.features.patterns.pattern_checks import check
from grammarlab.features.patterns.tree_index import without_geometry
from grammarlab.files import existing
from grammarlab.geometry.footprints.footprint_text import read_footprint_map
from grammarlab.language.attribute_values import fit_properties
from grammarlab.language.dimensions import UNKNOWN, units_of_calls
from grammarlab.language.display_names import DisplayNames
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Numbering
from grammarlab.learning.designs.addresses import Address, hashes_of
from grammarlab.learning.designs.contrasts import choice_of, contrasted
from grammarlab.learning.designs.design_space import AbstractDesignSpace, AbstractParts, Realized
from grammarlab.learning.designs.flattening import Flattened, flattened
from grammarlab.learning.settings import LEAST_POOL, MAX_PATH_LENGTH, POOL_SIZE, FeatureOptions
from grammarlab.scene.instances import realize
from grammarlab.scene.triangles import leaf_of_triangle

if TYPE_CHECKING:
    # Imported where they are used: a page shows its first pictures without what learns.
    from grammarlab.features.columns.vocabulary import Vocabulary
    from grammarlab.tastes.basic_quantities import Readers
    from grammarlab.tastes.language import Candidates
    from grammarlab.tastes.visible_orders import Orders


@dataclass(frozen=True)
class GrammarParts(AbstractParts):
    """The leaves of one model that have triangles, in the order of the derivation."""

    forest: Forest
    """The model alone."""
    numbering: Numbering
    """Numbers of the rules of the grammar that derived the model."""

    @property
    def of_triangles(self) -> Ints:
        return self._leaves_and_parts[1]

    def way_to(self, part: int) -> tuple[tuple[str, str], ...]:
        node = int(self.forest.leaves.node[self._leaves_and_parts[0][part]])
        return tuple(self._step(above) for above in way_to(self.forest, node))

    @cached_property
    def _leaves_and_parts(self) -> tuple[Ints, Ints]:
        """Rows of the leaves [P], and the part of each triangle [T]."""
        leaf = leaf_of_triangle(self.forest)
        rows, index = np.unique(leaf, return_inverse=True)
        order = np.argsort(self.forest.leaves.node[rows], kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        return rows[order], rank[index.ravel()]

    def _step(self, node: int) -> tuple[str, str]:
        origin = origin_of(self.forest, self.numbering, node)
        return origin.symbol, str(origin.rule_at or origin.made_at or "")


@dataclass(frozen=True)
class GrammarSpace(AbstractDesignSpace[Forest]):
    """The models that a grammar derives."""

    grammar: Grammar
    assets: AssetRoot | None = None
    """Folder of meshes and images."""

    @property
    def hashes(self) -> tuple[str, str]:
        return hashes_of(self.grammar.hash)

    @property
    def longest_path(self) -> int:
        return MAX_PATH_LENGTH

    @cached_property
    def _accepted(self) -> AcceptedGrammar:
        return AcceptedGrammar(self.grammar, self.assets)

    @property
    def program(self) -> Program:
        """The compiled grammar."""
        return self._accepted.program

    @property
    def acceptance(self) -> Acceptance | None:
        """The acceptance rule of the file; None if it keeps all models; see `AcceptedGrammar.acceptance`."""
        return self._accepted.acceptance

    @property
    def pool_size(self) -> int:
        return self._pool_size

    @cached_property
    def _pool_size(self) -> int:
        try:
            return int(np.clip(models_in_reach(self.program, self.folder), LEAST_POOL, POOL_SIZE))
        except GrammarlabError:  # raised again, with its place, where the pool is made
            return POOL_SIZE

    @property
    def display_names(self) -> DisplayNames:
        return self._display_names

    @cached_property
    def _display_names(self) -> DisplayNames:
        return DisplayNames.of(self.grammar.tree)

    def unit_of(self, draw: str) -> str:
        return self._units.get(draw, UNKNOWN)

    @cached_property
    def _units(self) -> dict[str, str]:
        units = units_of_calls(self.grammar.tree)
        numbers = [random_place.node.number for random_place in number_grammar(self.grammar).random_places]
        return {site.name: units.get(number, UNKNOWN) for site, number in zip(self.program.sites, numbers, strict=True)}

    @cached_property
    def proposal(self) -> Flattened:
        """The grammar with equal percentages."""
        return flattened(self.grammar)

    def make(self, addresses: Sequence[Address]) -> Forest:
        return without_geometry(self.derive(addresses, leaves=False))

    def sample(self, flat: bool, num: int, seed: int, first: int = 0) -> Iterator[Forest]:
        program = self.proposal.program if flat else self.program
        if self.acceptance is None:
            for forest in derive_chunks(program, num, seed, first_model=first, assets=self.folder, leaves=False):
                yield without_geometry(forest)
            return
        for start in range(first, first + num, BATCH):
            lots = Lots.of(min(BATCH, first + num - start), seed, first_model=start)
            yield without_geometry(self._accepted.derive(lots, program, leaves=False).forest)

    def log_ratio(self, designs: Forest) -> Floats:
        return self.proposal.log_ratio(designs) + self._log_ratio_of_rates

    @cached_property
    def _log_ratio_of_rates(self) -> float:
        """Log of the ratio of the acceptance rates of the proposal and of the grammar."""
        if self.acceptance is None:
            return 0.0
        proposal_rate, grammar_rate = (
            np.mean(self.acceptance.probabilities(derive(program, PILOT_MODELS, 0, assets=self.folder, leaves=False)))
            for program in (self.proposal.program, self.program)
        )
        return float(np.log(proposal_rate) - np.log(grammar_rate)) if min(proposal_rate, grammar_rate) > 0.0 else 0.0

    def take(self, designs: Forest, indices: Ints) -> Forest:
        return select_models(designs, indices)

    def vocabulary(self, designs: Sequence[Forest], features: FeatureOptions) -> Vocabulary:
        return self.tabulated(designs, features)[0]

    def tabulated(self, designs: Sequence[Forest], features: FeatureOptions) -> tuple[Vocabulary, FeatureTable]:
        from grammarlab.features.columns.vocabulary import Options, Vocabulary  # noqa: PLC0415

        families = features.families
        options = Options(
            length=features.path_length,
            symbols="symbols" in families,
            draws="draws" in families,
            far_pairs="skips" in families,
            adjacent_pairs="siblings" in families,
            repeats="count" if "counts" in families else "present",
        )
        return Vocabulary.find_with_table(designs, options)

    def candidates(self, designs: Sequence[Forest]) -> Candidates:
        from grammarlab.tastes.basic_quantities import Elements  # noqa: PLC0415
        from grammarlab.tastes.language import candidates  # noqa: PLC0415

        return candidates(Elements.of(designs, self._readers, self._orders))

    @cached_property
    def _readers(self) -> Readers:
        """Branches that read attributes."""
        from grammarlab.tastes.attribute_readers import readers_of  # noqa: PLC0415

        return readers_of(self.grammar)

    @cached_property
    def _orders(self) -> Orders:
        """Orders of alternatives that a person sees."""
        from grammarlab.tastes.visible_orders import visible_orders  # noqa: PLC0415

        return visible_orders(self.grammar)

    def values(self, designs: Sequence[Forest], features: Sequence[Feature]) -> Floats:
        return np.concatenate([np.zeros((0, len(features))), *(count(forest, features) for forest in designs)])

    def check(self, features: Iterable[Feature]) -> None:
        check(features, self.program.symbols, self.program.rule_names, self.program.sites)

    def log_density(self, designs: Forest) -> Floats:
        return designs.log_probability()

    def realize(self, addresses: Sequence[Address]) -> Realized:
        forest = self.derive(addresses)
        return Realized(realize(forest), forest.missing_assets)

    def contrast(self, address: Address, feature: Feature) -> Realized | None:
        choice = choice_of(feature)
        programs = None if choice is None else contrasted(self.grammar, choice)
        if programs is None or address.flat:
            return None
        forests = [derive(program, self._lots([address]), assets=self.folder) for program in programs]
        without, having = (float(count(forest, [feature])[0, 0]) for forest in forests)
        if without == having:
            return None
        pair = join_forests(forests)
        return Realized(realize(pair), pair.missing_assets)

    def parts(self, address: Address) -> GrammarParts:
        return GrammarParts(self.derive([address]), number_grammar(self.grammar))

    def asset_names(self) -> Iterable[str]:
        return self._accepted.asset_names()

    @property
    def folder(self) -> AssetFolder | None:
        """The assets; each is read once for all derivations."""
        return self._accepted.folder

    def derive(self, addresses: Sequence[Address], *, leaves: bool = True) -> Forest:
        """Models by ascending address.

        Args:
            addresses: their addresses.
            leaves: whether to record leaves, see `grammarlab.derivation.derive.derive`.
        """
        plain, flat = ([address for address in addresses if address.flat == kind] for kind in (False, True))
        parts = [(self.program, plain)]
        if flat:
            parts.append((self.proposal.program, flat))
        accepted = [self._accepted.derive(self._lots(part), program, leaves=leaves) for program, part in parts]
        return join_forests([models.forest for models in accepted])

    def _lots(self, addresses: Sequence[Address]) -> Lots:
        """Lots in the order of the addresses."""
        alike: dict[tuple[str, ...], list[int]] = {}
        for row, address in enumerate(addresses):
            alike.setdefault(address[3:], []).append(row)
        parts = [self._alike([addresses[row] for row in rows]) for rows in alike.values()]
        order = np.argsort(np.array([row for rows in alike.values() for row in rows], dtype=np.int64))
        return Lots.concatenate([Lots.of(0, 0), *parts]).take(order)

    def _alike(self, addresses: Sequence[Address]) -> Lots:
        """Models that differ in seed and index only."""
        start_rule, attributes, footprint = addresses[0][3:]
        values = json.loads(attributes)
        widths = values.pop(STREET_WIDTH) if isinstance(values.get(STREET_WIDTH), str) else None
        unknown = [name for name in values if name not in self.grammar.attributes]
        if unknown:
            raise UsageError(f"labels give a value to {unknown[0]}, which is not an attribute of the grammar.")
        return Lots.at(
            [address.seed for address in addresses],
            [address.model for address in addresses],
            polygon_of_label(footprint) if footprint else DEFAULT_FOOTPRINT,
            fit_properties(values, self.grammar),
            start_rule or None,
            None if widths is None else widths_of_label(widths),
        )


def widths_of_label(text: str) -> list[float]:
    """Widths of the streets along the edges of the footprint of a label, from its attribute ``streetWidth``.

    Raises:
        UsageError: If they are no numbers.

    >>> widths_of_label("8;0;0;6")
    [8.0, 0.0, 0.0, 6.0]
    """
    try:
        return [float(part) for part in text.split(";")]
    except ValueError:
        message = f'streetWidth of a label: expected a width for each edge such as "8;0;0;6", found {shown(text)}.'
        raise UsageError(message) from None


def polygon_of_label(text: str) -> Footprint:
    """The footprint of a label.

    A label is data: it cannot name other files to read.

    Raises:
        UsageError: If it is no footprint, or a file.
    """
    if text.lower().endswith((".json", ".geojson")) or existing(text) is not None:
        raise UsageError(f"footprint {text!r} of a label is a file; expected 20x12 or WKT.")
    plan = read_footprint_map(text)
    if len(plan.footprints) != 1:
        raise UsageError(f"footprint {text[:60]!r} of a label has {len(plan.footprints)} polygons; expected one.")
    return plan.footprints[0].polygon
