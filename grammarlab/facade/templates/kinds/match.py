"""What a match finds: kinds of elements that share parameters, and how sure it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from grammarlab.facade.templates.elements import Elements, Floats, Ints
from grammarlab.facade.templates.template import Template

UNKNOWN = -1
SURE = 0.9
"""Probability from which a statement counts as made."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Match:
    """Kinds of N elements."""

    elements: Elements
    templates: tuple[Template, ...]
    """[U] that kinds use."""
    kind: Ints
    """[N] index of a kind; -1 where no template fits."""
    kind_template: Ints
    """[K] index into `templates`."""
    values: tuple[Floats, ...]
    """[K] parameters [D] of each kind, metres; equal to the last bit where kinds share them."""
    spread: tuple[Floats, ...]
    """[K] standard deviations [D] of these, metres."""
    posterior: Floats
    """[N, K + 1] probability of each kind, and last that of none."""
    parameters: tuple[Floats, ...]
    """[N] parameters [D] of each element, metres; empty for unknown ones."""
    deviations: tuple[Floats, ...]
    """[N] standard deviations [D], which cover what other kinds it may be."""
    corner: Floats
    """[N, 2] lower left corners on the facade, metres."""
    hidden: Floats
    """[N] part of the outline that seems to be hidden."""
    reasons: Mapping[int, str]
    """Why elements are unknown."""
    iterations: int
    seconds: Mapping[str, float] = field(default_factory=dict)
    """Of each stage."""

    @property
    def probability(self) -> Floats:
        """[N] of the kind that is given; that nothing fits, for unknown ones."""
        return self.posterior[np.arange(len(self.kind)), self.kind]

    def template_of(self, kind: int) -> Template:
        """The template of a kind."""
        return self.templates[int(self.kind_template[kind])]

    def name_of(self, kind: int) -> str:
        """`rectangle 2`: kinds of a template count from 1; `unknown` for -1."""
        if kind == UNKNOWN:
            return "unknown"
        before = int((self.kind_template[:kind] == self.kind_template[kind]).sum())
        return f"{self.template_of(kind).name} {before + 1}"

    def members(self, kind: int) -> Ints:
        """Elements of a kind, ascending."""
        return np.flatnonzero(self.kind == kind)


def drawn_parameters(match: Match, element: int) -> tuple[Template, Floats] | None:
    """The template of an element and its parameters; None for unknown ones."""
    kind = int(match.kind[element])
    return None if kind == UNKNOWN else (match.template_of(kind), match.parameters[element])
