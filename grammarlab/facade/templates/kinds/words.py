"""Results of matching, in words."""

from __future__ import annotations

from typing import Any

import numpy as np

from grammarlab.facade.templates.kinds.match import SURE, UNKNOWN, Match

_LIKELY = 0.05
"""Least probability of another kind that is mentioned."""
_SHOWN = 3


def sharing(match: Match, name: str, kind: int) -> list[int]:
    """Kinds of the same template that share one parameter value with a kind, including the kind itself."""
    place = match.template_of(kind).parameters.index(name)
    own = match.values[kind][place]
    same = match.kind_template == match.kind_template[kind]
    return [each for each in np.flatnonzero(same).tolist() if match.values[each][place] == own]


def sentences(match: Match) -> list[str]:
    """A sentence for each set of kinds that share a parameter: "20 windows, 0.95 m wide, in two heights: ..."."""
    found: list[str] = []
    done: set[tuple[int, ...]] = set()
    for kind in range(len(match.values)):
        template = match.template_of(kind)
        shared = {name: tuple(sharing(match, name, kind)) for name in template.parameters}
        largest = max(shared.values(), key=len)
        if len(largest) == 1:
            found.append(f"{_counted(match, [kind])}: {_sizes(match, kind, template.parameters)}")
            continue
        for name, kinds in shared.items():
            if len(kinds) > 1 and kinds not in done:
                done.add(kinds)
                others = [each for each in template.parameters if each != name]
                parts = [f"{_sizes(match, each, others)} ({len(match.members(each))})" for each in kinds]
                own = _sizes(match, kind, (name,))
                found.append(f"{_counted(match, list(kinds))}, {own}, of {len(kinds)} kinds: {'; '.join(parts)}")
    return found


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


def doubt(match: Match, element: int) -> str:
    """Reason why an element is unknown or uncertain; empty for others."""
    if match.kind[element] == UNKNOWN:
        return match.reasons.get(element, "no template fits it")
    chance = match.posterior[element]
    if chance[match.kind[element]] >= SURE:
        return ""
    others = [each for each in np.argsort(-chance).tolist() if chance[each] > _LIKELY][:_SHOWN]
    last = len(chance) - 1
    names = [
        f"{'none of the kinds' if each == last else match.name_of(each)} with {chance[each]:.2f}" for each in others
    ]
    hidden = match.hidden[element]
    why = f"about {hidden:.0%} of its outline is probably hidden" if hidden > 0.02 else "its points are noisy or few"
    return f"{why}: it may be {', '.join(names)}"


def groups(match: Match) -> list[dict[str, Any]]:
    """Each kind for `--json`: its elements, its parameters, and the kinds that share them."""
    made = []
    for kind in range(len(match.values)):
        template = match.template_of(kind)
        shared = {
            name: [match.name_of(each) for each in sharing(match, name, kind) if each != kind]
            for name in template.parameters
        }
        names = template.parameters
        made.append(
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
    return made
