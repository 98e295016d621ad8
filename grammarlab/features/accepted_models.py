"""Accepted models, and the annotations of acceptance rules, without what the rules need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Ints
from grammarlab.derivation.forest import Forest
from grammarlab.language.syntax.syntax_tree import Annotation, RuleFile

ANNOTATION = "Acceptance"


@dataclass(frozen=True)
class Accepted:
    """Accepted models."""

    forest: Forest
    tries: Ints
    """[num_models] number of candidates of each model."""
    is_accepted: Flags
    """[num_models] False if no candidate was accepted; the model is then the nearest candidate."""

    @classmethod
    def all_of(cls, forest: Forest) -> Accepted:
        """All models of a grammar without an acceptance rule."""
        return cls(forest, np.ones(forest.num_models, np.int64), np.ones(forest.num_models, bool))


def annotations_of(tree: RuleFile) -> list[Annotation]:
    """Acceptance annotations of a rule file; at most one is allowed."""
    annotations = (annotation for definition in tree.definitions for annotation in definition.annotations)
    return [annotation for annotation in annotations if annotation.name.lower() == ANNOTATION.lower()]
