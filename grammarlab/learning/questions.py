"""Designs to ask about next, given a state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from grammarlab.learning.answers import Answers
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import Designs
from grammarlab.learning.round import State, Study, table_rows
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.compared_pairs import propose_pairs
from grammarlab.preference.queries import Situation, Way, propose


def ask(
    study: Study[Designs],
    state: State,
    num: int,
    seed: int,
    *,
    factor: str = "",
    way: Way | None = None,
    without: Sequence[Address] = (),
) -> tuple[Address, ...]:
    """Designs to ask about.

    Args:
        study: the pool and the settings.
        state: the state; answers from which nothing has been learned yet count as asked.
        num: number of designs, >= 0; fewer if there are no more.
        seed: seed of random choices, 0 <= seed < 2**64.
        factor: factor of the answers and the preference; empty for the product of all liked factors.
        way: query strategy; by default that of the settings.
        without: designs that are not asked about, such as those that a person sees already.

    Returns:
        Different designs of the pool without an answer; with ``already ranked``, designs with one.
    """
    way = way or study.settings.query
    tables = study.tables(state.wide)
    every, answers = (part.scored for part in (_answers(state, factor) if factor else _product(state)))
    columns = state.columns
    table, num_pool = tables.table(columns), len(tables.pool_designs.pool)
    rows = table.rows[:num_pool]
    if way == "already ranked":
        outside = tuple(sorted({address for address in answers.designs if address not in tables.index}))
        rows = np.concatenate([rows, tables.rows_of(columns, outside)]) if outside else rows
        columns = replace(columns, elsewhere=outside)
    answer_rows = table_rows(tables, columns, answers)
    inside = (answer_rows >= 0) & (answer_rows < len(rows))
    asked = np.append(
        table_rows(tables, columns, every),
        np.array([tables.index.get(address, -1) for address in without], dtype=np.int64),
    )
    situation = Situation(
        pool=rows,
        from_grammar=np.arange(len(rows)) < tables.pool_designs.pool.sizes[0],
        scored=answer_rows[inside],
        scores=answers.scores[inside],
        preference=state.preferences.get(factor) if factor else state.product,
        weights=tables.pool_designs.weights,
        asked=asked[(asked >= 0) & (asked < len(rows))],
    )
    with threadpool_limits(1, "blas"):  # as in `step`
        chosen = propose(way, situation, num, seed)
    names = (*tables.addresses, *columns.elsewhere)
    return tuple(names[index] for index in chosen.tolist())


def ask_pairs(
    study: Study[Designs], state: State, num: int, seed: int, *, factor: str
) -> tuple[tuple[Address, Address], ...]:
    """Pairs of designs to compare for a factor, from `propose_pairs`.

    Args:
        study: the pool and the settings.
        state: the state.
        num: number of pairs, >= 0; fewer if there are no more.
        seed: seed of random choices, 0 <= seed < 2**64.
        factor: factor of the answers and the preference.

    Returns:
        Pairs that were not compared yet; no design is in two of them, and some may have answers.
    """
    tables, columns = study.tables(state.wide), state.columns
    answers = state.answers.get(factor, Answers(factor, (), np.zeros(0)))
    rows = tables.table(columns).rows
    pool, outside = tables.pool_designs.pool, len(rows) - len(tables.pool_designs.pool)
    mentioned = table_rows(tables, columns, replace(answers, designs=answers.mentioned))
    pairs = [
        (design, other) for design, other in zip(answers.designs, answers.others, strict=False) if other is not None
    ]
    compared = [table_rows(tables, columns, replace(answers, designs=pair)) for pair in pairs]
    situation = Situation(
        pool=rows,
        from_grammar=np.arange(len(rows)) < pool.sizes[0],
        scored=mentioned[mentioned >= 0],
        scores=np.zeros(0),
        preference=state.preferences.get(factor),
        weights=np.append(tables.pool_designs.weights, np.zeros(outside)),
    )
    with threadpool_limits(1, "blas"):
        chosen = propose_pairs(situation, np.array(compared, dtype=np.int64).reshape(-1, 2), num, seed)
    names = (*tables.addresses, *columns.elsewhere)
    return tuple((names[first], names[second]) for first, second in chosen.tolist())


def _answers(state: State, factor: str) -> tuple[Answers, Answers]:
    """All answers for a factor, and those that count; all new ones do."""
    every = state.answers.get(factor, Answers(factor, (), np.zeros(0)))
    entry = state.heard.get(factor)
    if entry is None or entry.division is None:
        return every, every
    return every, entry.answers + every.since(entry.num_answers)


def _product(state: State) -> tuple[Answers, Answers]:
    """The designs with answers for all liked factors, and the products of these answers; and those that count."""
    of_factors = [_answers(state, name) for name in state.liked if name in state.answers]
    every, counting = (
        ([part.scored for part in parts] for parts in zip(*of_factors, strict=True)) if of_factors else ([], [])
    )
    return _multiplied(every), _multiplied(counting)


def _multiplied(factors: Sequence[Answers]) -> Answers:
    liked = [answers.scored for answers in factors]
    scores = [dict(zip(answers.designs, answers.scores.tolist(), strict=True)) for answers in liked]
    shared = [design for design in (scores[0] if scores else {}) if all(design in score_of for score_of in scores)]
    values = np.array([[score_of[design] for design in shared] for score_of in scores]).reshape(
        len(scores), len(shared)
    )
    return Answers("", tuple(shared), MAX_SCORE * np.prod(values / MAX_SCORE, axis=0))
