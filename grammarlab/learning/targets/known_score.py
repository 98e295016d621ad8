"""From a score that is known exactly to a species that keeps its trees in proportion to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.features.expression import plain_text
from grammarlab.features.model_score import Score
from grammarlab.learning.designs.species_space import SpeciesSpace
from grammarlab.learning.designs.tree_columns import TreeBatch
from grammarlab.learning.targets.species_target import LearnedSpecies
from grammarlab.preference.base import MAX_SCORE
from grammarlab.trees.species_file import write

METHODS = ("acceptance",)
"""Methods: an acceptance rule, which says any score of parameters and measures exactly."""


def species_of_score(
    space: SpeciesSpace, score: Score, examples: Sequence[TreeBatch], lines: Sequence[str] = ()
) -> LearnedSpecies:
    """The species with an acceptance rule that is the score as a share of 100.

    Args:
        space: the species.
        score: a score of its trees.
        examples: trees of the species, at least one with a score above 0, to estimate the acceptance rate.
        lines: comment lines at the top of the new file.

    Raises:
        UsageError: If the scores are 0 for all examples, or the rule is too long.
    """
    scores = np.concatenate([score.evaluate(space.values([trees], score.features)) for trees in examples])
    rate = float(scores.mean()) / MAX_SCORE
    if rate <= 0.0:
        raise UsageError(f"none of {len(scores):,} trees has a score above 0, so no species can be made of it.")
    rule = f"{plain_text(score.expression)} / {MAX_SCORE:g}"
    if space.species.acceptance:
        rule = f"min(max({space.species.acceptance}, 0), 1) * min(max({rule}, 0), 1)"
    header = "".join(f"# {line}\n" for line in (*lines, f"Method {METHODS[0]}, base grammar"))
    text = f"{header}\n{write(replace(space.species, acceptance=rule))}"
    finding = f"the file keeps {rate:.2g} of its trees by an acceptance rule"
    return LearnedSpecies(
        text=text,
        method=METHODS[0],
        base="grammar",
        before=space.species,
        accept_rate=rate,
        findings=(finding,),
        assets=space.assets,
    )
