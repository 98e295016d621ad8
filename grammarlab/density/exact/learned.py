"""Learned grammar: its text, its density, and its trees as trees of the original."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.density.exact.attributes import AttributeParts, parts_taken
from grammarlab.density.exact.grammar_text import Mixed, Origin
from grammarlab.density.exact.splitting import Base
from grammarlab.density.exact.tree_density import StartRule, TreeRatio
from grammarlab.density.grammar_skeleton import TreeGrammar
from grammarlab.density.sampler import AbstractSampler
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Draws, Forest, RuleName, Site
from grammarlab.errors import GrammarlabError
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import SymbolKey
from grammarlab.language.syntax.syntax_tree import Rule


@dataclass(frozen=True)
class LearnedGrammar(AbstractSampler):
    """A grammar made from another one by splitting symbols and changing percentages."""

    text: str
    """An ordinary rule file that samples the density."""
    original: Grammar
    """The original grammar."""
    method: str
    base: Base
    """Density that the preference multiplies: the original one, or the same for every tree."""
    origins: Mapping[SymbolKey, Origin]
    """Origin of each rule that is new or changed."""
    start: SymbolKey
    components: tuple[Mixed, ...]
    attributes: tuple[AttributeParts, ...]
    """Attributes whose draws were cut into parts."""
    mean_preference: float
    """Mean of the preference over the models of the base density, up to the number of trees if the base is uniform: the
    divisor that normalises the density."""
    findings: tuple[str, ...] = ()
    """Remarks for the user about how it was made."""
    assets: AssetRoot | None = None
    """Folder of meshes and images."""

    @property
    def accept_rate(self) -> None:
        """None: all its models are kept."""
        return None

    @cached_property
    def grammar(self) -> Grammar:
        """Grammar of the text.

        Raises:
            GrammarlabError: If its rules are not those that are meant: a defect of grammarlab.
        """
        grammar = Grammar.parse(self.text, self.original.file)
        _check_rules(grammar, self.original, self.origins)
        return grammar

    @property
    def rules_before(self) -> int:
        """Branches of the rules of the original grammar."""
        return num_alternatives(self.original)

    @property
    def units(self) -> tuple[str, str]:
        """What its size counts: one, and several."""
        return "branch of rules", "branches of rules"

    @property
    def rules_after(self) -> int:
        """Branches of the rules."""
        return self._num_alternatives

    @cached_property
    def _num_alternatives(self) -> int:
        return num_alternatives(self.grammar)

    @property
    def rules_changed(self) -> int:
        """Branches of the new and changed rules, known before the text is parsed."""
        return sum(len(origin.branches) for origin in self.origins.values())

    def sample(self, num_models: int, seed: int) -> Forest:
        return self.as_original(derive(self.grammar, num_models, seed, assets=self.assets))

    def log_density(self, forest: Forest) -> Floats:
        with np.errstate(divide="ignore"):
            return forest.log_probability() + np.log(self.ratio(forest))

    def ratio(self, forest: Forest) -> Floats:
        """Density [models] of trees of the original grammar, divided by their original density.

        Computed from the text of both grammars, as a sum over the variants of each node.
        """
        trees = self._trees(forest)
        indices = [parts_taken(parts, self.original, forest) for parts in self.attributes]
        result = np.zeros(forest.num_models)
        for component, ratio in zip(self.components, trees, strict=True):
            drawn = np.full(forest.num_models, component.probability)
            for parts, probabilities, number in zip(self.attributes, component.attributes, indices, strict=True):
                drawn *= (probabilities / parts.probabilities)[number]
            result += drawn * ratio
        return result

    def as_original(self, forest: Forest) -> Forest:
        """Trees of this grammar as trees of the original: symbols and rules under the original's names.

        Geometry does not change. Draws are kept if they have the same meaning in both grammars: numbers, and choices in
        unchanged definitions. Their densities are those of this grammar.
        """
        program = compile_grammar(self.original)
        symbols = _numbered(program.symbols)
        rules: dict[object, int] = {
            (rule.symbol, rule.parameters, rule.branch): i for i, rule in enumerate(program.rule_names)
        }
        original_names = {origin_name: origin.key[0] for (origin_name, _), origin in self.origins.items()}
        symbol = np.array([symbols[original_names.get(name, name)] for name in forest.symbols], dtype=program.id_type)
        rule = np.array([*(rules.get(self._origin(name), -1) for name in forest.rules), -1], dtype=program.id_type)
        nodes = replace(forest.nodes, symbol=symbol[forest.nodes.symbol], rule=rule[forest.nodes.rule])
        sites = _numbered(site.name for site in program.sites)
        site_of = np.array(
            [sites[site.name] if self._is_kept(site, sites) else -1 for site in forest.sites], dtype=program.id_type
        )
        rows = np.flatnonzero(site_of[forest.draws.site] >= 0) if len(site_of) else np.zeros(0, dtype=np.int64)
        draws = forest.draws
        draws = Draws(draws.node[rows], site_of[draws.site[rows]], draws.value[rows], draws.log_density[rows])
        return replace(
            forest, symbols=program.symbols, rules=program.rule_names, sites=program.sites, nodes=nodes, draws=draws
        )

    def _is_kept(self, site: Site, site_names: Mapping[object, int]) -> bool:
        """Whether draws of a site have the same meaning in the original."""
        if any(parts.name == site.definition for parts in self.attributes):
            return site.kind == "uniform" and site.name in site_names
        return site.name in site_names and all(site.definition != name for name, _ in self.origins)

    def _origin(self, rule: RuleName) -> tuple[str, int, tuple[int, ...] | None]:
        origin = self.origins.get((rule.symbol, rule.parameters))
        if origin is None:
            return rule.symbol, rule.parameters, rule.branch
        return (*origin.key, origin.branches.get(rule.branch))

    @cached_property
    def _trees(self) -> TreeRatio:
        branching = len({component.start for component in self.components}) > 1
        starts = [StartRule(self.start, i if branching else None) for i in range(len(self.components))]
        learned = TreeGrammar.of(self.grammar, self.start[0])
        return TreeRatio(TreeGrammar.of(self.original), learned, self.origins, starts)


def _check_rules(grammar: Grammar, original: Grammar, origins: Mapping[SymbolKey, Origin]) -> None:
    """Check that a text has the rules that it is made of, each once: the layout of the original must not change them.

    Raises:
        GrammarlabError: If it does not.
    """
    tree, grammars = TreeGrammar.of(grammar), (grammar, original)
    wrong = [
        name
        for (name, parameters), origin in origins.items()
        if {a.branch for a in tree.alternatives((name, parameters))} - {None} != origin.branches.keys()
    ]
    wrong += [name for name, _ in grammar.rules.keys() - origins.keys() - original.rules.keys()]
    new, old = (
        Counter((d.name, len(d.parameters)) for d in g.tree.definitions if isinstance(d, Rule)) for g in grammars
    )
    wrong += [name for (name, parameters), count in new.items() if count > max(old[name, parameters], 1)]
    if wrong:
        raise GrammarlabError(
            f"the learned text does not have the rules that are meant: {', '.join(wrong[:3])}; this is a defect of "
            "grammarlab: report it with the rule file"
        )


def _numbered(items: Iterable[object]) -> dict[object, int]:
    return {item: i for i, item in enumerate(items)}


def num_alternatives(grammar: Grammar) -> int:
    """Number of branches of all rules of a grammar."""
    tree = TreeGrammar.of(grammar)
    return sum(alternative.branch is not None for key in tree.bodies for alternative in tree.alternatives(key))
