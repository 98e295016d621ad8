"""Random draws as columns: counts of drawn branches, and means of all other draws."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from grammarlab.arrays import Ints
from grammarlab.derivation.forest import Site
from grammarlab.features.columns.paths import Tally, compact, tally
from grammarlab.features.counting.counts import Floats, count
from grammarlab.features.counting.node_labels import KeyIndex
from grammarlab.features.counting.trees import Trees
from grammarlab.features.patterns.pattern import Draw

MOST_BRANCHES = 30
"""Largest number of branches of a choice with counts per branch; otherwise the branch number is a quantity."""


def count_branches(trees: Trees, index: KeyIndex, grow: bool) -> Tally:
    """Counts of the outcomes of choices of few branches, ``p`` and ``fileRandom``; one "branch" key each."""
    sites, draws = trees.forest.sites, trees.forest.draws
    names = list(dict.fromkeys(site.name for site in sites))
    discrete = np.array([not is_quantity(site) for site in sites], dtype=bool)
    rows = np.flatnonzero(discrete[draws.site])
    name_of_site = np.array([names.index(site.name) for site in sites], dtype=np.int64)
    outcome = draws.value[rows].astype(np.int64)
    size = int(outcome.max(initial=0)) + 1
    number, found = compact(name_of_site[draws.site[rows]] * size + outcome, len(names) * size)
    name, drawn = np.divmod(found, size)
    keys = (("branch", names[n], value) for n, value in zip(name.tolist(), drawn.tolist(), strict=True))
    columns = index.columns(keys, grow)
    return tally(trees, draws.node[rows].astype(np.int64), number, [columns], len(index))


def measure_draws(trees: Trees, index: KeyIndex, grow: bool) -> Tally:
    """The mean of the draws of each ``rand`` and of each choice of many branches; one "draw" key each."""
    names = tuple(dict.fromkeys(site.name for site in trees.forest.sites if is_quantity(site)))
    columns = index.columns((("draw", name) for name in names), grow)
    return columns_of(count(trees, [Draw(name) for name in names]), columns, len(index))


def is_quantity(site: Site) -> bool:
    """Whether its draws are numbers to compare: random numbers, and branch numbers of choices of many branches."""
    return site.kind == "uniform" or site.choices > MOST_BRANCHES


def columns_of(values: Floats, columns: Ints, width: int) -> Tally:
    """Values [models, C] at their columns [C] of a table, -1 for those to leave out; none is a count of nodes."""
    known = np.flatnonzero(columns >= 0)
    model, place = np.nonzero(values[:, known])
    cells = model, columns[known][place]
    counts = sparse.csr_array((values[:, known][model, place], cells), shape=(len(values), width))
    return Tally(counts, np.zeros(width, dtype=bool))
