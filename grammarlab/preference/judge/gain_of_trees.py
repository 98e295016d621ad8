"""What trees explain beyond any distribution of scores, as the judge sees it."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.preference.growth.person_search import most_likely
from grammarlab.preference.growth.split_columns import SplitColumns
from grammarlab.preference.growth.tree_growth import Others, Tree, TreeGrowth
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.person import Person


def gain(columns: SplitColumns, trees: Others, scores: Floats, person: Person, nothing: float) -> float:
    """What the best of some trees explains beyond any distribution of scores, less its description, in nats.

    Trees are pruned to what the judge believes (`grammarlab.preference.judge.leaf_evidence`); minus infinity if nothing
    is left of them. With even odds, scores that nothing explains have any distribution
    (`grammarlab.preference.judge.unexplained_scores`), or values have one and the person errs. The first alone would
    be a straw man for scores of which noise makes many 0.

    Args:
        columns: what the scores may be split by.
        trees: the trees, and the rows of the scored designs.
        scores: [n] 0-100.
        person: errors to begin with.
        nothing: evidence that one distribution of values explains the scores, in nats
            (`grammarlab.preference.unexplained`).
    """
    evidence = LeafEvidence.of(scores, person)
    best = _pruned(columns, trees, evidence)
    likely = most_likely(evidence, [list(best.cells())], [0.0])
    total = best.log_posterior - person.price
    if likely != person:
        other = _pruned(columns, trees, evidence.for_person(likely))
        if other.log_posterior - likely.price > total:
            best, total = other, other.log_posterior - likely.price
    if best.split is None:
        return -np.inf
    of_scores = evidence.of_any(np.arange(len(scores)))
    return float(total - (np.logaddexp(of_scores, nothing) - np.log(2.0)))


def _pruned(columns: SplitColumns, trees: Others, evidence: LeafEvidence) -> Tree:
    return TreeGrowth(columns, evidence).replanted(trees)[0]
