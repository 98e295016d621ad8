"""One round of learning: answers in, a preference out.

The state after a round is a function of the pool and of the scores in their order only, so that equal scores of a
simulated person, a person at the page, a label file and a Python function give equal states. Its quantities:

- answer: a score (0-100) of a design for a factor. With several factors, the preference is their product.
- pool: the designs to ask about (`grammarlab.learning.designs.pool`). Designs from elsewhere may have a
  score.
- liked factor: one with a score above 0. Others are left out of the product, since their preference is unknown.
- heard: the answers that count, if their order shows a change of taste or two people (`grammarlab.learning.heard`).
- columns: features of designs. Composed ones that scores need are added
  (`grammarlab.learning.composed_columns`), and paths grow longer (`grammarlab.learning.path_growth`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Generic

import numpy as np
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.density.targets.rejection import PILOT_MODELS
from grammarlab.features.patterns.pattern import Feature
from grammarlab.learning.answers import Answers
from grammarlab.learning.composed_columns import composed_columns
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace, Designs
from grammarlab.learning.designs.design_tables import Columns, DesignTable, DesignTables
from grammarlab.learning.designs.pool import Pool, PoolDesigns
from grammarlab.learning.fitting import fit
from grammarlab.learning.heard import Heard, heard
from grammarlab.learning.path_growth import path_length
from grammarlab.learning.settings import Settings
from grammarlab.preference.base import AbstractPreference
from grammarlab.preference.factors import ProductPreference
from grammarlab.preference.judge.labelled_columns import selected
from grammarlab.preference.liked import blunders_of, liked_are_rare, noise_of

Report = Callable[[str, int, int], None]
"""Function called with the name of a task, the number of finished parts, and the number of all parts."""


def silent(_stage: str, _done: int, _total: int) -> None:
    """Ignore progress."""


@dataclass(frozen=True)
class State:
    """State between two rounds."""

    answers: Mapping[str, Answers]
    """All answers by factor, in order of the first one."""
    preferences: Mapping[str, AbstractPreference]
    """Preferences of the factors with answers at the last step."""
    columns: Columns
    """Columns of `preferences`."""
    liked: tuple[str, ...] = ()
    """Factors with a score above 0 at the last step."""
    wide: bool = False
    """Whether the pool has been widened for rare designs."""
    heard: Mapping[str, Heard] = field(default_factory=dict[str, Heard])
    """What `preferences` were learned from."""

    @property
    def num_answers(self) -> int:
        """Number of scores so far, all factors together."""
        return sum(len(answers.designs) for answers in self.answers.values())

    @property
    def product(self) -> ProductPreference | None:
        """The preference: the product of the liked factors; None if there is none."""
        liked = {name: self.preferences[name] for name in self.liked}
        return ProductPreference(liked) if liked else None


class Study(Generic[Designs]):
    """A space of designs with the pool and the settings; caches designs and tables."""

    def __init__(
        self,
        space: AbstractDesignSpace[Designs],
        pool: Pool,
        settings: Settings | None = None,
        others: tuple[Designs, ...] = (),
    ) -> None:
        """A study without made designs.

        Args:
            space: the design space.
            pool: the designs to ask about.
            settings: options of learning; by default those for a person.
            others: further designs with rows in tables; there are no questions about them.
        """
        self.space, self.pool, self.settings, self._others = space, pool, settings or Settings(), others
        self._tables: dict[bool, DesignTables[Designs]] = {}

    def tables(self, wide: bool = False, report: Report = silent) -> DesignTables[Designs]:
        """The designs of the pool, or of the wide pool, and their tables."""
        wide = wide or self.pool.wide
        if wide not in self._tables:
            pool = replace(self.pool, wide=wide)
            narrow = self._tables[False].pool_designs if False in self._tables else None
            on_progress = partial(report, f"making {len(pool):,} models")
            pool_designs = PoolDesigns.of(self.space, pool, narrow, on_progress)
            self._tables[wide] = DesignTables(self.space, pool_designs, self.settings.features, self._others)
        return self._tables[wide]

    def table(self, state: State) -> DesignTable:
        """Rows for the preferences of a state."""
        return self.tables(state.wide).table(state.columns)


def init(study: Study[Designs]) -> State:
    """State before the first answer."""
    return State({}, {}, Columns(study.settings.features.path_length), wide=study.pool.wide)


def answered(state: State, answers: Sequence[Answers]) -> State:
    """The state with more answers, from which nothing has been learned yet."""
    by_factor = dict(state.answers)
    for new in answers:
        by_factor[new.factor] = by_factor[new.factor] + new if new.factor in by_factor else new
    return replace(state, answers=by_factor)


def step(
    study: Study[Designs],
    state: State,
    answers: Sequence[Answers],
    report: Report = silent,
    *,
    widens: bool = True,
) -> State:
    """Learn from more answers: find columns, then fit each factor.

    Args:
        study: the pool and the settings.
        state: state after the previous round.
        answers: the new answers, each of one factor.
        report: called with the progress.
        widens: whether the pool may be widened now, if the settings allow it.

    Returns:
        The new state; it is the same for answers at once or in many steps, as long as liked designs are not rare.
    """
    # Small matrices take longer with several threads, which wait for one another where others work, too.
    with threadpool_limits(1, "blas"):
        return _stepped(study, state, answered(state, answers), report, widens)


def _stepped(study: Study[Designs], state: State, updated: State, report: Report, widens: bool) -> State:
    """`step` with all answers in `updated`."""
    widens = widens and study.settings.widens
    # Scores that are rare without noise are rare with it, and need no second test.
    wide = updated.wide or (
        widens and any(liked_are_rare(factor_answers.scored.scores) for factor_answers in _nonempty_answers(updated))
    )
    learned = _learned(study, state, replace(updated, wide=wide), report)
    if not learned.wide and widens and needs_wide(learned):
        learned = _learned(study, state, replace(updated, wide=True), report, learned)
    return learned


def _nonempty_answers(state: State) -> list[Answers]:
    """Answers of factors with at least one."""
    return [factor_answers for factor_answers in state.answers.values() if len(factor_answers.designs)]


def needs_wide(state: State) -> bool:
    """Whether liked designs are rare, given the estimated errors of the persons."""
    erring = [(entry.answers, state.preferences[name]) for name, entry in state.heard.items()]
    return any(
        liked_are_rare(factor_answers.scored.scores, noise_of(preference), blunders_of(preference))
        for factor_answers, preference in erring
    )


def _learned(study: Study[Designs], state: State, updated: State, report: Report, found: State | None = None) -> State:
    """Learn on one pool.

    Args:
        study: the pool and the settings.
        state: state after the previous round.
        updated: state with all answers.
        report: called with the progress.
        found: what was learned from the same answers on another pool, with what was heard and composed; None if nothing
            was yet.
    """
    factors_answers = _nonempty_answers(updated)
    tables = study.tables(updated.wide, report)
    total = len(factors_answers) + 2
    report("looking at scored models", 0, total)
    columns, every = _heard_with_columns(tables, factors_answers, study.settings, found)
    report("counting features", 1, total)
    table = tables.table(columns)
    reusable = state.preferences if (columns, tables.pool_designs.pool.wide) == (state.columns, state.wide) else {}
    preferences: dict[str, AbstractPreference] = {}
    for number, factor_answers in enumerate(factors_answers):
        report(f"learning {factor_answers.factor}", 2 + number, total)
        before = reusable.get(factor_answers.factor)
        if before is None or state.answers[factor_answers.factor] is not factor_answers:
            counting = every[factor_answers.factor].answers
            others = table_rows(tables, columns, replace(counting, designs=_compared(counting)))
            warm = before if study.settings.warm else None
            rows, designs = table_rows(tables, columns, counting), _some(table, tables.pool_designs.weights)
            before = _fit(table, rows, counting, others, study.settings, warm, designs)
        preferences[factor_answers.factor] = before
    liked = tuple(name for name, entry in every.items() if entry.answers.is_liked)
    return State(updated.answers, preferences, columns, liked, tables.pool_designs.pool.wide, every)


def _heard_with_columns(
    tables: DesignTables[Designs], answers: Sequence[Answers], settings: Settings, found: State | None
) -> tuple[Columns, Mapping[str, Heard]]:
    """The columns, and the answers that count: columns that explain all scores as well as two voices show only one."""
    if found is not None:
        counting = [entry.answers for entry in found.heard.values()]
        return _columns(tables, answers, counting, settings, found.columns), found.heard
    columns = _columns(tables, answers, answers, settings, None)
    every = {part.factor: _heard(tables, part, columns, settings) for part in answers}
    if any(entry.division for entry in every.values()):
        columns = _columns(tables, answers, [entry.answers for entry in every.values()], settings, None)
    return columns, every


def _heard(tables: DesignTables[Designs], answers: Answers, columns: Columns, settings: Settings) -> Heard:
    """The answers of a factor that count; comparisons alone do, and for methods other than the default one, all do."""
    if not settings.grows or settings.fit != "blended" or not answers.scored.designs:
        return Heard(answers, len(answers.designs))
    rows, inverse = np.unique(table_rows(tables, columns, answers.scored), return_inverse=True)
    designs = tables.designs(rows, columns.elsewhere)
    known = tables.space.tabulated(designs, settings.features)[1].rows()
    values = np.column_stack([known, tables.space.values(designs, columns.extra)])[inverse.reshape(-1)]
    return heard(answers, values, np.array(columns.prices))


def _elsewhere(tables: DesignTables[Designs], answers: Sequence[Answers]) -> tuple[Address, ...]:
    """Designs with answers that are not in the pool."""
    different = {address for factor_answers in answers for address in factor_answers.mentioned}
    return tuple(sorted(address for address in different if address not in tables.index))


def _some(table: DesignTable, weights: Floats) -> tuple[Floats, Floats]:
    """Rows and density weights of some designs of the pool, evenly spaced."""
    possible = np.flatnonzero(weights > 0.0)
    num = min(PILOT_MODELS, len(possible))
    indices = possible[np.arange(num) * len(possible) // max(num, 1)]
    return table.rows[indices], weights[indices]


def table_rows(tables: DesignTables[Designs], columns: Columns, answers: Answers) -> Ints:
    """[n] rows of the table for answers; each is of the pool or of `Columns.elsewhere`."""
    outside = {address: len(tables.pool_designs.pool) + index for index, address in enumerate(columns.elsewhere)}
    rows = (tables.index.get(address, outside.get(address, -1)) for address in answers.designs)
    return np.array(list(rows), dtype=np.int64)


def _columns(
    tables: DesignTables[Designs],
    answers: Sequence[Answers],
    counting: Sequence[Answers],
    settings: Settings,
    found: Columns | None,
) -> Columns:
    """The columns needed for the designs of all answers and for the scores of those that count."""
    elsewhere = _elsewhere(tables, answers)
    columns = Columns(settings.features.path_length, elsewhere=elsewhere)
    about_one = [factor_answers.scored for factor_answers in counting]
    scored = [_per_design(table_rows(tables, columns, single), single.scores) for single in about_one if single.designs]
    every = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(rows for rows, _ in scored)]))
    designs = tables.designs(every, elsewhere)
    extra: dict[Feature, float] = {} if found is None else dict(zip(found.extra, found.prices, strict=True))
    composes = found is None and settings.grows and settings.fit == "blended"
    for rows, scores in scored if composes else ():
        indices = selected(scores)
        extra = (
            composed_columns(tables.space, tables.designs(rows[indices], elsewhere), scores[indices], settings.features)
            | extra
        )
    columns = replace(columns, extra=tuple(extra), prices=tuple(extra.values()))
    if settings.grows:
        numbered = [(np.searchsorted(every, rows), scores) for rows, scores in scored]
        length = path_length(tables.space, designs, numbered, settings.features, columns.extra)
        columns = replace(columns, path_length=length)
    return columns


def _per_design(rows: Ints, scores: Floats) -> tuple[Ints, Floats]:
    """The different rows, ascending, and the mean of the scores of each."""
    different, inverse = np.unique(rows, return_inverse=True)
    return different, np.bincount(inverse, scores) / np.maximum(np.bincount(inverse), 1)


def _compared(answers: Answers) -> tuple[Address, ...]:
    """[n] the other designs of comparisons; for other answers their own designs."""
    others = answers.others or (None,) * len(answers.designs)
    return tuple(design if other is None else other for design, other in zip(answers.designs, others, strict=True))


def _fit(
    table: DesignTable,
    rows: Ints,
    answers: Answers,
    others: Ints,
    settings: Settings,
    warm: AbstractPreference | None,
    designs: tuple[Floats, Floats],
) -> AbstractPreference:
    kinds = answers.kinds or ("score",) * len(rows)
    # In a fixed order, independent of the order of answers, since sums of floats depend on it.
    order = np.lexsort((np.array(kinds), others, answers.scores, rows))
    labelled, scores = table.rows[rows[order]], answers.scores[order]
    if settings.options:
        # Only this baseline has parameters, and only experiments set them.
        from grammarlab.baselines import gaussian_process  # noqa: PLC0415 - loads JAX

        options: dict[str, Any] = dict(settings.options)
        return gaussian_process.fit(labelled, scores, groups=table.groups, warm=warm, **options)
    return fit(
        labelled,
        scores,
        groups=table.groups,
        continuous=table.continuous,
        method=settings.fit,
        priors=table.priors,
        seed=settings.seed,
        warm=warm,
        kinds=[kinds[index] for index in order.tolist()] if answers.kinds else (),
        others=table.rows[others[order]] if answers.kinds else None,
        designs=designs,
    )
