"""Results of matching: kinds of elements that share parameters, with uncertainties, and in words."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.matching.elements import Elements
from grammarlab.matching.template import Template

UNKNOWN = -1
"""Kind of an element that no template fits."""
SURE = 0.9
"""Least probability of a result that counts as sure."""
_MIN_PROBABILITY = 0.05
"""Least probability of another kind that is mentioned."""
_MAX_KINDS = 3
"""Largest number of other kinds that are mentioned."""


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


class Clock:
    """Measures consecutive stages."""

    def __init__(self) -> None:
        self._last = time.perf_counter()
        self.seconds: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        """Ends a stage, which began with the end of the previous one."""
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._last
        self._last = now


def drawn_parameters(match: Match, element: int) -> tuple[Template, Floats] | None:
    """The template of an element and its parameters; None for unknown elements."""
    kind = int(match.kind[element])
    return None if kind == UNKNOWN else (match.template_of(kind), match.parameters[element])


def sentences(match: Match) -> list[str]:
    """A sentence for each set of kinds that share a parameter: "20 windows, 0.95 m wide, in two heights: ..."."""
    texts: list[str] = []
    done: set[tuple[int, ...]] = set()
    for kind in range(len(match.values)):
        template = match.template_of(kind)
        shared = {name: tuple(_sharing(match, name, kind)) for name in template.parameters}
        largest = max(shared.values(), key=len)
        if len(largest) == 1:
            texts.append(f"{_counted(match, [kind])}: {_sizes(match, kind, template.parameters)}")
            continue
        for name, kinds in shared.items():
            if len(kinds) > 1 and kinds not in done:
                done.add(kinds)
                others = [parameter for parameter in template.parameters if parameter != name]
                parts = [f"{_sizes(match, member, others)} ({len(match.members(member))})" for member in kinds]
                size = _sizes(match, kind, (name,))
                texts.append(f"{_counted(match, list(kinds))}, {size}, of {len(kinds)} kinds: {'; '.join(parts)}")
    return texts


def doubt(match: Match, element: int) -> str:
    """Reason why an element is unknown or uncertain; empty for others."""
    if match.kind[element] == UNKNOWN:
        return match.reasons.get(element, "no template fits it")
    chance = match.posterior[element]
    if chance[match.kind[element]] >= SURE:
        return ""
    others = [index for index in np.argsort(-chance).tolist() if chance[index] > _MIN_PROBABILITY][:_MAX_KINDS]
    last = len(chance) - 1
    names = [
        f"{'none of the kinds' if index == last else match.name_of(index)} with {chance[index]:.2f}" for index in others
    ]
    hidden = match.hidden[element]
    why = f"about {hidden:.0%} of its outline is probably hidden" if hidden > 0.02 else "its points are noisy or few"
    return f"{why}: it may be {', '.join(names)}"


def groups(match: Match) -> list[dict[str, Any]]:
    """Each kind for `--json`: its elements, its parameters, and the kinds that share them."""
    rows = []
    for kind in range(len(match.values)):
        template = match.template_of(kind)
        shared = {
            name: [match.name_of(other) for other in _sharing(match, name, kind) if other != kind]
            for name in template.parameters
        }
        names = template.parameters
        rows.append(
            {
                "kind": match.name_of(kind),
                "template": template.name,
                "counts": dict(template.counts),
                "elements": match.members(kind).tolist(),
                "parameters": dict(zip(names, match.values[kind].tolist(), strict=True)),
                "standard_deviations": dict(zip(names, match.spread[kind].tolist(), strict=True)),
                "shared_parameters": [name for name in names if shared[name]],
                "shared_with": {name: others for name, others in shared.items() if others},
            }
        )
    return rows


def _sharing(match: Match, name: str, kind: int) -> list[int]:
    """Kinds of the same template that share one parameter value with a kind, including the kind itself."""
    index = match.template_of(kind).parameters.index(name)
    value = match.values[kind][index]
    same = match.kind_template == match.kind_template[kind]
    return [other for other in np.flatnonzero(same).tolist() if match.values[other][index] == value]


def _counted(match: Match, kinds: list[int]) -> str:
    number = sum(len(match.members(kind)) for kind in kinds)
    return f"{number} {match.template_of(kinds[0]).name}{'' if number == 1 else 's'}"


def _sizes(match: Match, kind: int, names: tuple[str, ...] | list[str]) -> str:
    template = match.template_of(kind)
    parts = []
    for name in names:
        value = match.values[kind][template.parameters.index(name)]
        word = {"width": f"{value:.2f} m wide", "height": f"{value:.2f} m high"}.get(name, f"{name} {value:.2f} m")
        parts.append(word)
    return ", ".join(parts)
