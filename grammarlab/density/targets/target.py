"""Target density: a grammar times a preference that reads features."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.density.exact.compile import Preference, compile_density
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.exact.readings import Read, read
from grammarlab.density.exact.splitting import MAX_WAYS, Base
from grammarlab.density.exact.subtree_counts import Reading
from grammarlab.density.grammar_skeleton import MAX_EXAMINED_MODELS
from grammarlab.density.rounding import EXACT
from grammarlab.density.targets.ranges import with_ranges
from grammarlab.derivation.derive import NODES_PER_CHUNK, derive
from grammarlab.derivation.forest import Forest
from grammarlab.features.model_score import Score
from grammarlab.features.patterns.conditions import patterns_of
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Feature, Pattern
from grammarlab.language.grammar import Grammar


@dataclass(frozen=True)
class Target:
    """A density p(m) u(m) / Z, or u(m) / Z over the trees of a grammar."""

    grammar: Grammar
    reads: tuple[Read, ...]
    """Features that the preference reads."""
    preference: Preference
    """Function from their values [n, reads] to a score [n], finite and at least 0."""
    base: Base = "grammar"
    """The density that the preference multiplies."""
    bound: float | None = None
    """Upper bound of the preference; None if unknown."""
    assets: AssetRoot | None = None
    """Folder of meshes and images."""

    @classmethod
    def of_score(
        cls, grammar: Grammar, score: Score, base: Base = "grammar", assets: AssetRoot | None = None
    ) -> Target:
        """A score as the preference."""
        reads, rest = read(score.expression)

        def preference(values: Floats) -> Floats:
            return np.clip(rest(values), 0.0, 100.0)

        return cls(grammar, reads, preference, base, max(score.levels) if score.levels else None, assets)

    @cached_property
    def features(self) -> tuple[Feature, ...]:
        """All features to count, each once."""
        return tuple(dict.fromkeys(feature for item in self.reads for feature in _features(item)))

    @property
    def patterns(self) -> tuple[Pattern, ...]:
        """The patterns among the features."""
        return tuple(pattern for feature in self.features for pattern in patterns_of(feature))

    def read(self, values: Floats) -> Floats:
        """Values [n, reads] that the preference reads, from the values [n, features] of the features."""
        column_of = {feature: i for i, feature in enumerate(self.features)}
        columns = [_value(item, values, column_of) for item in self.reads]
        return np.stack(columns, axis=1) if columns else np.zeros((len(values), 0))

    def scores(self, values: Floats) -> Floats:
        """The preference [n] of the values [n, features] of the features."""
        return np.asarray(self.preference(self.read(values)), dtype=np.float64)

    def of_models(self, forest: Forest) -> Floats:
        """The preference [models] of models of the grammar."""
        return self.scores(count(forest, self.features))

    @cached_property
    def folder(self) -> AssetFolder | None:
        """The assets; each is read once for all derivations."""
        return None if self.assets is None else AssetFolder(self.assets)

    @cached_property
    def first_look(self) -> Forest:
        """A few models of the grammar, without leaves, to estimate counts of successors and the size of models."""
        return derive(self.grammar, MAX_EXAMINED_MODELS, 0, assets=self.folder, leaves=False)

    @property
    def chunk(self) -> int:
        """Number of models to derive at once."""
        per_model = len(self.first_look.nodes) / self.first_look.num_models
        return int(max(256, NODES_PER_CHUNK / per_model))

    @cached_property
    def even(self) -> LearnedGrammar | None:
        """With base uniform, the grammar under which all trees are equally likely."""
        if self.base == "grammar":
            return None
        reads, _ = with_ranges(self.grammar, self.reads, _ones, 1)
        return replace(self, reads=reads, preference=_ones).compiled(self.first_look)

    def compiled(
        self,
        forest: Forest | None = None,
        header: Sequence[str] = (),
        max_ways: int = MAX_WAYS,
        step: float = EXACT,
        min_share: float = 0.0,
    ) -> LearnedGrammar:
        """The exact grammar of the density.

        Args:
            forest: derivations of the grammar that show how often successors inside blocks occur.
            header: lines of a comment at the top of the new file.
            max_ways: largest number of alternatives of the split symbols.
            step: probabilities are rounded to multiples of this.
            min_share: less probable branches may be left out (`grammarlab.density.exact.trimming`).

        Raises:
            InexactError: If there is none, or it would be too large; it states the reason.
            GrammarlabError: If the preference is 0 for every model, or no derivation ends.
        """
        options: dict[str, Any] = {"forest": forest, "header": header, "max_ways": max_ways, "step": step}
        options["min_share"] = min_share
        return compile_density(self.grammar, self.reads, self.preference, base=self.base, assets=self.assets, **options)


def _features(item: Read) -> tuple[Feature, ...]:
    return tuple(pattern for pattern, _ in item.terms) if isinstance(item, Reading) else (item,)


def _value(item: Read, values: Floats, column_of: Mapping[Feature, int]) -> Floats:
    if not isinstance(item, Reading):
        return values[:, column_of[item]]
    total = sum((weight * values[:, column_of[pattern]] for pattern, weight in item.terms), np.zeros(len(values)))
    return np.minimum(total, item.cap)


def _ones(values: Floats) -> Floats:
    return np.ones(len(values))
