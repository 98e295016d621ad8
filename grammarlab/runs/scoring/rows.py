"""The models of a session as rows of numbers: the pool, and models that were scored elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.evaluation.flattening import hash_of_flattened
from grammarlab.features.counting import count
from grammarlab.features.pattern import Feature
from grammarlab.features.vocabulary import Options, Vocabulary
from grammarlab.language.grammar import Grammar
from grammarlab.preference.labels import OVERALL, Label, Labels
from grammarlab.runs.learn.factors import selected
from grammarlab.runs.learn.labelled_models import LabelledModels, labelled_models
from grammarlab.runs.learn.pool import Pool
from grammarlab.runs.scoring.addresses import Address
from grammarlab.runs.scoring.knowledge import ModelPool

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Scored:
    """All models that have a score, those of the pool first."""

    models: LabelledModels
    """Each model once; `model` counts them in the order of `place`."""
    place: Mapping[str, int]
    """Number of each model by its address."""
    in_pool: Ints
    """[p] numbers in the pool of the first models."""
    elsewhere: tuple[Forest, ...]
    """The other models."""
    names_elsewhere: tuple[str, ...]
    """Their addresses."""


@dataclass(frozen=True)
class Rows:
    """Features of all models."""

    pool: Floats
    """[m, F] scaled."""
    scored: Floats
    """[n, F] likewise."""
    elsewhere: Floats
    """[e, F] those of `scored` that are not of the pool."""
    names_elsewhere: tuple[str, ...]
    """[e] addresses."""
    names: tuple[str, ...]
    """[F] all different."""
    groups: Ints
    """[F]"""
    group_names: tuple[str, ...]

    @property
    def all(self) -> Floats:
        """[m + e, F] of the pool, then from elsewhere."""
        return np.concatenate([self.pool, self.elsewhere])


class Models:
    """The models that a session knows."""

    def __init__(
        self,
        grammar: Grammar,
        assets: Path,
        names: ModelPool,
        narrow: Models | None,
        on_progress: Callable[[int, int], None],
    ) -> None:
        """Derives the models of the pool.

        Args:
            grammar: the grammar.
            assets: folder of meshes and images.
            names: of the models of the pool.
            narrow: those of the pool before it was widened, where they have been derived.
            on_progress: told again and again how many models there are, of how many.
        """
        self._grammar, self._assets, self.names = grammar, assets, names
        known = None if narrow is None else narrow.pool
        self.pool = Pool.of(
            grammar, assets, names.seed, names.size, wide=names.wide, known=known, on_progress=on_progress
        )
        """The models to choose from."""
        self._base = lru_cache(maxsize=3)(self._find)
        self._derived = lru_cache(maxsize=2)(self._derive)

    def scored(self, names: Sequence[str]) -> Scored:
        """Models by address; those that are not of the pool are derived.

        Args:
            names: different addresses.
        """
        index = self.names.index
        inside = sorted((name for name in names if name in index), key=lambda name: index[name])
        outside = tuple(name for name in names if name not in index)
        in_pool = np.array([index[name] for name in inside], dtype=np.int64)
        place = {name: number for number, name in enumerate(inside)}
        elsewhere: tuple[Forest, ...] = ()
        if outside:
            found = self._derived(outside)
            elsewhere = found.forests
            place |= {name: len(inside) + int(k) for name, k in zip(outside, found.model, strict=True)}
        forests = (*selected(self.pool.forests, in_pool), *elsewhere)
        models = LabelledModels(forests, np.array(list(place.values())))
        return Scored(models, place, in_pool, elsewhere, tuple(sorted(outside, key=lambda name: place[name])))

    def rows(self, options: Options, scored: Scored | None = None) -> Rows:
        """Features of the pool and of the models that have a score.

        Args:
            options: which features; those beyond the usual ones (`Options.extra`) get a group each.
            scored: models that have a score.
        """
        base, vocabulary = self._base(replace(options, extra=()))
        pool, elsewhere = base.pool, () if scored is None else scored.elsewhere
        others = vocabulary.apply(elsewhere).rows() if elsewhere else np.zeros((0, pool.shape[1]))
        if options.extra:
            pool = np.column_stack([pool, _counted(self.pool.forests, options.extra)])
            others = np.column_stack([others, _counted(elsewhere, options.extra)])
        first, extra = len(base.group_names), tuple(str(feature) for feature in options.extra)
        return Rows(
            pool,
            others if scored is None else np.concatenate([pool[scored.in_pool], others]),
            others,
            () if scored is None else scored.names_elsewhere,
            (*base.names, *extra),
            np.append(base.groups, np.arange(first, first + len(extra))),
            (*base.group_names, *extra),
        )

    def _find(self, options: Options) -> tuple[Rows, Vocabulary]:
        vocabulary = Vocabulary.find(self.pool.forests, options)
        table = vocabulary.apply(self.pool.forests)
        pool = table.rows()
        return Rows(pool, pool[:0], pool[:0], (), table.names, table.groups, table.group_names), vocabulary

    def _derive(self, names: tuple[str, ...]) -> LabelledModels:
        hashes = self._grammar.hash, hash_of_flattened(self._grammar.hash)
        addresses = [Address.parse(name) for name in names]
        labels = [Label(address.seed, address.model, OVERALL, 0.0, hashes[address.flat]) for address in addresses]
        return labelled_models(Labels(tuple(labels)), self._grammar, self._assets)


def _counted(forests: Sequence[Forest], features: Sequence[Feature]) -> Floats:
    """How often each feature occurs in each model [models, features]."""
    parts = [count(forest, features) for forest in forests]
    return np.concatenate([np.zeros((0, len(features))), *parts])
