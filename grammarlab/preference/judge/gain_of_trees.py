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
    """What trees explain beyond any distribution of scores, less their description, in nats.

    The best of some trees is pruned to what the judge believes (`grammarlab.preference.judge.leaf_evidence`), and
    counts with other divisions of its nodes; minus infinity if no division is worth its price. With even odds, scores
    that nothing explains have any distribution (`grammarlab.preference.judge.unexplained_scores`), or values have one
    and the person errs. The first alone would be a straw man for scores of which noise makes many 0.

    Args:
        columns: what the scores may be split by.
        trees: the trees, and the rows of the scored designs.
        scores: [n] 0-100.
        person: errors to begin with.
        nothing: evidence that one distribution of values explains the scores, in nats
            (`grammarlab.preference.unexplained`).
    """
    evidence = LeafEvidence.of(scores, person)
    best, total = _pruned(columns, trees, evidence)
    likely = most_likely(evidence, [list(best.cells())], [0.0])
    if likely != person:
        total = max(total, _pruned(columns, trees, evidence.for_person(likely))[1])
    of_scores = evidence.of_any(np.arange(len(scores)))
    return float(total - (np.logaddexp(of_scores, nothing) - np.log(2.0)))


def _pruned(columns: SplitColumns, trees: Others, evidence: LeafEvidence) -> tuple[Tree, float]:
    """The best tree, and the evidence of it and of other divisions, less the price of the person, in nats."""
    growth = TreeGrowth(columns, evidence)
    best = growth.replanted(trees)[0]
    return best, growth.divided(best) - evidence.person.price
