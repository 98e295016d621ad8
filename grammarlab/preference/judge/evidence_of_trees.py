"""Evidence of trees as the judge sees it, who lets the scores of a leaf have any distribution."""

from __future__ import annotations

from grammarlab.arrays import Floats
from grammarlab.preference.growth.person_search import most_likely
from grammarlab.preference.growth.split_columns import SplitColumns
from grammarlab.preference.growth.tree_growth import Others, Tree, TreeGrowth
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.person import Person


def log_evidence(columns: SplitColumns, trees: Others, scores: Floats, person: Person) -> float:
    """Evidence of trees, less their description, in nats; minus infinity if no division is worth its price.

    The best of some trees is pruned to what the judge believes (`grammarlab.preference.judge.leaf_evidence`), and
    counts with other divisions of its nodes.

    Args:
        columns: what the scores may be split by.
        trees: the trees, and the rows of the scored designs.
        scores: [n] 0-100.
        person: errors to begin with.
    """
    evidence = LeafEvidence.of(scores, person)
    best, total = _pruned(columns, trees, evidence)
    likely = most_likely(evidence, [list(best.cells())], [0.0])
    return total if likely == person else max(total, _pruned(columns, trees, evidence.for_person(likely))[1])


def _pruned(columns: SplitColumns, trees: Others, evidence: LeafEvidence) -> tuple[Tree, float]:
    """The best tree, and the evidence of it and of other divisions, less the price of the person, in nats."""
    growth = TreeGrowth(columns, evidence)
    best = growth.replanted(trees)[0]
    return best, growth.divided(best) - evidence.person.price
