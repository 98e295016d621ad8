"""Rules of the zones of a city, and the buildings that they make on sites."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from hashlib import sha256
from itertools import groupby
from pathlib import Path

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.asset_roots import AssetRoot
from grammarlab.city.plan import StreetTrees, ZonePlan
from grammarlab.city.site_attributes import GROUND_LEVEL
from grammarlab.city.sites import Sites
from grammarlab.city.tree_file import parse_trees, read_trees
from grammarlab.city.tree_map_plan import SUFFIX as TREES
from grammarlab.city.tree_map_plan import is_tree_file
from grammarlab.derivation.forest import Forest, MissingAsset
from grammarlab.derivation.functions import CONTEXT_QUERIES
from grammarlab.errors import AssetError, DerivationError, UsageError, shown
from grammarlab.export.surface_labels import SurfaceLabels
from grammarlab.export.tiles.texture_colors import with_pictures
from grammarlab.features.accepted_grammar import AcceptedGrammar
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.language.syntax.syntax_tree import Call, Name, Node, RuleFile, walk
from grammarlab.runs.city.plinths import with_plinths
from grammarlab.runs.city.semantics import surface_labels
from grammarlab.runs.sample.checks import grammar_to_run
from grammarlab.runs.sample.domains import SPECIES
from grammarlab.runs.sample.shipped import SUFFIX, RuleSource, find_rules
from grammarlab.scene import Scene, realize
from grammarlab.scene.instances import require_finite
from grammarlab.scene.joined import joined


@dataclass(frozen=True, slots=True)
class ZoneRules:
    """Rules of one zone: what a worker needs to make its buildings."""

    zone: str
    """Name of the zone."""
    name: str
    """Name of the rules, such as ``building``."""
    text: str
    """The whole text, without imports."""
    assets: AssetRoot
    suffix: str = SUFFIX
    """Suffix of the kind of the text."""
    species: tuple[ZoneRules, ...] = ()
    """Species of learned trees, in the order of their intensities; none for other rules."""

    @classmethod
    def of(cls, zone: ZonePlan) -> ZoneRules:
        """The rules of a zone: a file or a shipped example.

        Raises:
            UsageError: If there are no such rules.
            LanguageError: If they have mistakes.
        """
        return cls._found(zone.name, zone.grammar)

    @classmethod
    def along_streets(cls, trees: StreetTrees) -> ZoneRules:
        """The species along streets, or the learned ones.

        Raises:
            UsageError: If there is no such species.
            AssetError: If there is no such file of learned trees.
            LanguageError: If the file of a species has mistakes.
        """
        rules = cls._found("", trees.species)
        if not rules.is_park:
            raise UsageError(f"street trees: expected a species, found the rules {trees.species!r}.")
        return rules

    @classmethod
    def _found(cls, zone: str, grammar: str) -> ZoneRules:
        return (
            cls._of_trees(zone, Path(grammar)) if is_tree_file(grammar) else cls._of_source(zone, find_rules(grammar))
        )

    @classmethod
    def _of_source(cls, zone: str, source: RuleSource) -> ZoneRules:
        return cls(zone, source.name, source.text(), source.assets, source.suffix)

    @classmethod
    def _of_trees(cls, zone: str, path: Path) -> ZoneRules:
        text = read_trees(path)
        names = parse_trees(text.encode()).species
        sources = [find_rules(str(path.parent / name) if Path(name).suffix else name) for name in names]
        for name, source in zip(names, sources, strict=True):
            if source.suffix != SPECIES:
                raise AssetError(f"{path}: species: expected species, found the rules {shown(name)}.")
        species = tuple(cls._of_source(zone, source) for source in sources)
        return cls(zone, path.name[: -len(TREES)], text, path.parent, TREES, species)

    @property
    def is_park(self) -> bool:
        """Whether the zone is a park: trees instead of buildings."""
        return self.suffix in (SPECIES, TREES)

    @property
    def hash(self) -> str:
        """SHA-256 of the text and of its species, 64 hexadecimal digits."""
        text = self.text + "".join(f"\0{rules.hash}" for rules in self.species)
        return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()

    @property
    def source(self) -> AcceptedGrammar:
        """The compiled rules, once per process.

        Raises:
            LanguageError: If they have mistakes.
        """
        return _compiled(self.text, self.name, self.assets)

    def rule_names(self) -> frozenset[str]:
        """Names of all rules; none for a park."""
        return frozenset() if self.is_park else frozenset(name for name, _ in self.source.grammar.rules)

    def check(self, attributes: Sequence[str]) -> None:
        """Check the rules, and that they have the attributes of the plan.

        Raises:
            GrammarlabError: If they do not.
        """
        if self.is_park:
            return
        known = self.source.grammar.attributes
        for name in attributes:
            if name not in known:
                names = ", ".join(sorted(known)) or "none"
                raise UsageError(f"zone {self.zone!r}: {self.name} has no attribute {name!r}; it has {names}.")

    def remarks(self) -> Iterator[Remark]:
        """A remark if the rules ask about other buildings: one of a city does not depend on those of its neighbours."""
        queries = () if self.is_park else queries_of_others(self.source.grammar.tree)
        for name, forms in groupby(sorted(set(queries)), lambda form: form.partition("(")[0]):
            reason = (
                f"{', '.join(forms)} sees no buildings of other parcels: a building depends on its own parcel alone. "
                f"Write {name}(intra) if that is meant. Walls along streets are those of street.front and street.side"
            )
            yield Remark(f"zone {self.zone!r}, {self.name}", "property", reason)


@dataclass(frozen=True, eq=False, kw_only=True)
class MadeBuildings:
    """B buildings of one zone."""

    row: Ints
    """[B] row of the site of each, ascending: the sites whose building could be derived."""
    scene: Scene | None
    """B models; None for no building."""
    labels: SurfaceLabels
    """Kinds of the surfaces of the instances of the scene."""
    reports: Sequence[Mapping[str, float]]
    """[B] sums of the values that the rules report, by key."""
    failures: Mapping[int, str]
    """Messages about the other sites, by row."""
    missing_assets: frozenset[MissingAsset] = frozenset()


def queries_of_others(tree: RuleFile) -> Iterator[str]:
    """Spatial queries of rules that ask about other models: those without a target, too, ask about all.

    >>> from grammarlab.language.grammar import Grammar
    >>> tree = Grammar.parse('Lot --> case touches || inside(inter, "x") || overlaps(intra) : NIL else : A').tree
    >>> sorted(queries_of_others(tree))
    ['inside(inter)', 'touches']
    """
    for node in walk(tree):
        name, arguments = (node.function, node.arguments) if isinstance(node, Call) else (_name_of(node), ())
        target = _name_of(arguments[0]) if arguments else ""
        if name in CONTEXT_QUERIES and target != "intra":
            yield f"{name}({target})" if target else name


def _name_of(node: Node) -> str:
    return node.identifier if isinstance(node, Name) else ""


def make_buildings(rules: ZoneRules, sites: Sites) -> MadeBuildings:
    """The buildings of sites of one zone; one that cannot be derived does not stop the others.

    Args:
        rules: rules of the zone, not those of a park.
        sites: the sites.
    """
    known = rules.source.grammar.attributes
    fitting = replace(
        sites,
        attributes={
            name: column for name, column in sites.attributes.items() if name in known and not known[name].constant
        },
    )
    try:
        return _made(rules, fitting, np.arange(len(sites)))
    except DerivationError:
        return _made_one_by_one(rules, fitting)


def _made_one_by_one(rules: ZoneRules, sites: Sites) -> MadeBuildings:
    parts, failures = list[MadeBuildings](), dict[int, str]()
    for row in range(len(sites)):
        try:
            parts.append(_made(rules, sites.take(np.array([row])), np.array([row])))
        except DerivationError as error:
            failures[row] = str(error)
    scenes = [part.scene for part in parts if part.scene is not None]
    return MadeBuildings(
        row=np.array([row for part in parts for row in part.row.tolist()], np.int64),
        scene=joined(scenes) if scenes else None,
        labels=SurfaceLabels.concatenate([part.labels for part in parts]),
        reports=[report for part in parts for report in part.reports],
        failures=failures,
        missing_assets=frozenset().union(*(part.missing_assets for part in parts)),
    )


def _made(rules: ZoneRules, sites: Sites, rows: Ints) -> MadeBuildings:
    forest = rules.source.derive(sites.lots()).forest
    scene, labels = with_pictures(realize(forest), rules.assets), surface_labels(forest)
    if GROUND_LEVEL not in rules.source.grammar.attributes:
        scene, labels = with_plinths(scene, labels, sites)
    require_finite(scene)
    return MadeBuildings(
        row=rows,
        scene=scene,
        labels=labels,
        reports=_sums(forest),
        failures={},
        missing_assets=frozenset(forest.missing_assets),
    )


def _sums(forest: Forest) -> list[dict[str, float]]:
    """[num_models] finite sums of reported values by key."""
    reports = forest.reports
    sums = np.zeros((forest.num_models, len(reports.keys)))
    has_key = np.zeros(sums.shape, np.bool_)
    rows = np.flatnonzero(forest.is_in_statistics())
    place = forest.nodes.model[reports.node[rows]], reports.key[rows]
    np.add.at(sums, place, reports.value[rows])
    has_key[place] = True
    has_key &= np.isfinite(sums)
    return [
        {key: value for key, value, has in zip(reports.keys, values, flags, strict=True) if has}
        for values, flags in zip(sums.tolist(), has_key.tolist(), strict=True)
    ]


@lru_cache(maxsize=256)
def _compiled(text: str, name: str, assets: AssetRoot) -> AcceptedGrammar:
    source = AcceptedGrammar(grammar_to_run(text, f"{name}{SUFFIX}"), assets)
    _ = source.program
    return source
