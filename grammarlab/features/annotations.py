"""Annotations of acceptance rules, found without what the rules need."""

from __future__ import annotations

from grammarlab.language.syntax.syntax_tree import Annotation, RuleFile

ANNOTATION = "Acceptance"


def annotations_of(tree: RuleFile) -> list[Annotation]:
    """Acceptance annotations of a rule file; at most one is allowed."""
    found = (annotation for definition in tree.definitions for annotation in definition.annotations)
    return [annotation for annotation in found if annotation.name.lower() == ANNOTATION.lower()]
