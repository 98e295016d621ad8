"""Results of matching: kinds of elements that share parameters, with uncertainties."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from grammarlab.facade.templates.elements import Elements, Floats, Ints
from grammarlab.facade.templates.template import Template

UNKNOWN = -1
SURE = 0.9
"""Least probability of a result that counts as sure."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Match:
    """Kinds of N elements."""

    elements: Elements
    templates: tuple[Template, ...]
    """[U] templates of the kinds."""
    kind: Ints
    """[N] index of a kind; -1 if no template fits."""
    kind_template: Ints
    """[K] index into `templates`."""
    values: tuple[Floats, ...]
    """[K] parameters [D] of each kind, metres; shared ones are equal to the last bit."""
    spread: tuple[Floats, ...]
    """[K] standard deviations [D] of these, metres."""
    posterior: Floats
    """[N, K + 1] probability of each kind, with that of no kind last."""
    parameters: tuple[Floats, ...]
    """[N] parameters [D] of each element, metres; empty for unknown elements."""
    deviations: tuple[Floats, ...]
    """[N] standard deviations [D] over all possible kinds of an element, metres."""
    corner: Floats
    """[N, 2] lower left corners on the facade, metres."""
    hidden: Floats
    """[N] hidden fraction of the outline."""
    reasons: Mapping[int, str]
    """Reason for each unknown element."""
    iterations: int
    seconds: Mapping[str, float] = field(default_factory=dict)
    """Duration of each stage."""

    @property
    def probability(self) -> Floats:
        """[N] probability of the assigned kind, or of no kind for unknown elements."""
        return self.posterior[np.arange(len(self.kind)), self.kind]

    def template_of(self, kind: int) -> Template:
        """The template of a kind."""
        return self.templates[int(self.kind_template[kind])]

    def name_of(self, kind: int) -> str:
        """`rectangle 2`: kinds of a template are numbered from 1; `unknown` for -1."""
        if kind == UNKNOWN:
            return "unknown"
        before = int((self.kind_template[:kind] == self.kind_template[kind]).sum())
        return f"{self.template_of(kind).name} {before + 1}"

    def members(self, kind: int) -> Ints:
        """Elements of a kind, ascending."""
        return np.flatnonzero(self.kind == kind)


def drawn_parameters(match: Match, element: int) -> tuple[Template, Floats] | None:
    """The template of an element and its parameters; None for unknown elements."""
    kind = int(match.kind[element])
    return None if kind == UNKNOWN else (match.template_of(kind), match.parameters[element])
