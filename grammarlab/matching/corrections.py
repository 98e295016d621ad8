"""Corrections of a person, and their effect on the default method.

A file is JSON: {"format": "grammarlab corrections", "version": 1, "corrections": [...]}, with entries such as
{"elements": [2, 5], "template": "arch"}: these elements are of this template,
{"elements": [2, 5], "same": true}: these are of one kind,
{"elements": [4], "ignore": true}: these are left out,
{"elements": [2, 5], "share": "width"}: these have one width, or with "value": 0.95 this width.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.values import a_list, a_number, a_text, a_whole_number, an_object, parse_json, read_bounded
from grammarlab.files import rewrite_text
from grammarlab.matching.elements import MOST_ELEMENTS
from grammarlab.matching.evidence_maps import Maps
from grammarlab.matching.template import Template

FORMAT = "grammarlab corrections"
LEFT_OUT = "it is left out by a correction"
_VERSION = 1
_MAX_CORRECTIONS = 10_000
"""Largest number of corrections of a file."""
_MIN_FACTOR = 1e-6
"""Least factor on evidence that contradicts a correction."""
_EXCLUSION_COST = 1e6
"""Cost of templates that a correction excludes, nats."""
_SIZES = ("width", "height")

What = Literal["template", "same", "ignore", "share"]


@dataclass(frozen=True, slots=True)
class Correction:
    """A correction of some elements."""

    what: What
    elements: tuple[int, ...]
    """Indices, ascending."""
    name: str = ""
    """A template, or `width` or `height`."""
    value: float | None = None
    """Given size, metres; None for a shared but unknown size."""


Corrections = tuple[Correction, ...]


def as_dict(correction: Correction) -> dict[str, Any]:
    """A correction as an object of its file."""
    values: dict[str, Any] = {"elements": list(correction.elements)}
    values[correction.what] = correction.name or True
    return values if correction.value is None else {**values, "value": correction.value}


def save_corrections(corrections: Corrections, path: Path) -> Path:
    """Write a file atomically, through a link to it."""
    rows = ",\n".join(json.dumps(as_dict(correction), ensure_ascii=False) for correction in corrections)
    rewrite_text(path, f'{{"format": "{FORMAT}", "version": {_VERSION}, "corrections": [\n{rows}\n]}}\n')
    return path


def load_corrections(path: Path) -> Corrections:
    """The corrections of a file.

    Raises:
        FacadeError: If it is not such a file; with the position of the mistake.
    """
    try:
        return _corrections(parse_json(read_bounded(path)))
    except FacadeError as error:
        raise FacadeError(f"{path.name}: {error}") from error


def _corrections(document: Any) -> Corrections:
    if not isinstance(document, dict) or document.get("format") != FORMAT or document.get("version") != _VERSION:
        raise FacadeError(f'This is not a file of corrections: expected "format": "{FORMAT}", "version": {_VERSION}.')
    listed = a_list(document.get("corrections"), "corrections", _MAX_CORRECTIONS)
    return tuple(correction_of(entry, f"Correction {index}") for index, entry in enumerate(listed))


def correction_of(value: Any, where: str) -> Correction:
    """A correction from an object of a file or a page.

    Raises:
        FacadeError: If it is not a correction.
    """
    values = an_object(value, where)
    listed = a_list(values.get("elements"), f"{where}, elements", MOST_ELEMENTS)
    elements = tuple(sorted({a_whole_number(element, f"{where}, elements", 0, MOST_ELEMENTS) for element in listed}))
    present = [what for what in ("template", "same", "ignore", "share") if what in values]
    if len(present) != 1 or not elements:
        raise FacadeError(f"{where}: expected elements and one of template, same, ignore and share.")
    what: What = present[0]  # ty: ignore[invalid-assignment]  # pyright: ignore[reportAssignmentType] one of the words above
    if what in {"same", "ignore"}:
        if values[what] is not True:
            raise FacadeError(f"{where}, {what}: expected true; delete the correction to undo it.")
        return Correction(what, elements)
    name = a_text(values[what], f"{where}, {what}")
    if what == "template":
        return Correction(what, elements, name)
    if name not in _SIZES:
        raise FacadeError(f"{where}, share: expected width or height, found {name!r}.")
    size = a_number(values["value"], f"{where}, value") if values.get("value") is not None else None
    if size is not None and size <= 0.0:
        raise FacadeError(f"{where}, value: expected metres above 0, found {size:g}.")
    return Correction(what, elements, name, size)


def check_corrections(corrections: Corrections, number: int, templates: Sequence[Template]) -> None:
    """Check that corrections refer to these elements and templates.

    Raises:
        FacadeError: If there are unknown elements or templates, or corrections contradict each other.
    """
    names = {template.base for template in templates} | {template.name for template in templates}
    template_of_element: dict[int, str] = {}
    for correction in corrections:
        if correction.elements[-1] >= number:
            raise FacadeError(f"Corrections: unknown element {correction.elements[-1]}; expected 0 to {number - 1}.")
        if correction.what == "template":
            if correction.name not in names:
                raise FacadeError(
                    f"Corrections: the template {correction.name!r} is not among {', '.join(sorted(names)[:20])}; "
                    "add it to `templates=`."
                )
            for element in correction.elements:
                name = template_of_element.setdefault(element, correction.name)
                if name != correction.name:
                    raise FacadeError(f"Corrections: element {element} cannot be {name} and {correction.name}.")


def ignored_elements(corrections: Corrections) -> dict[int, str]:
    """Ignored elements, with the reason."""
    return {
        element: LEFT_OUT
        for correction in corrections
        if correction.what == "ignore"
        for element in correction.elements
    }


def fixed_sizes(corrections: Corrections, indices: Ints) -> list[tuple[int, float]]:
    """Axis and metres of the fixed sizes of any of the elements [N]."""
    sized = [
        correction
        for correction in corrections
        if correction.value is not None and np.isin(indices, correction.elements).any()
    ]
    return [(_SIZES.index(correction.name), correction.value) for correction in sized if correction.value is not None]


def with_templates(costs: Floats, indices: Ints, templates: Sequence[Template], corrections: Corrections) -> Floats:
    """Costs [N, T + 1] of elements with corrections of their templates, or of common kinds.

    Args:
        costs: nats of each template, and of none last.
        indices: [N] indices of the elements.
        templates: the T templates.
        corrections: all corrections.
    """
    costs = costs.copy()
    for correction in corrections:
        rows = np.flatnonzero(np.isin(indices, correction.elements))
        if correction.what == "template" and len(rows):
            is_excluded = np.array(
                [correction.name not in {template.base, template.name} for template in templates] + [True]
            )
            least = np.minimum(costs[rows][:, ~is_excluded], _EXCLUSION_COST / 2)
            costs[rows] += _EXCLUSION_COST * is_excluded
            costs[np.ix_(rows, np.flatnonzero(~is_excluded))] = least
    for correction in corrections:
        rows = np.flatnonzero(np.isin(indices, correction.elements))
        if correction.what == "same" and len(rows):
            costs[rows] = costs[rows].sum(axis=0)
    return costs


def with_sizes(maps: Maps, indices: Ints, corrections: Corrections) -> Maps:
    """Evidence [N, A, B] with the corrections of sizes of the elements [N] applied."""
    logs = np.log(maps.evidence)
    for correction in corrections:
        rows = np.flatnonzero(np.isin(indices, correction.elements))
        if not len(rows):
            continue
        if correction.what == "same":
            logs[rows] = logs[rows].sum(axis=0)
        elif correction.what == "share":
            logs[rows] = _shared_log_evidence(
                np.exp(logs[rows] - logs[rows].max(axis=(1, 2), keepdims=True)), maps, correction
            )
    evidence = np.exp(logs - logs.max(axis=(1, 2), keepdims=True))
    evidence /= evidence.mean(axis=(1, 2), keepdims=True)
    return replace(maps, evidence=(1.0 - _MIN_FACTOR) * evidence + _MIN_FACTOR)


def _shared_log_evidence(evidence: Floats, maps: Maps, correction: Correction) -> Floats:
    """Log-evidence [M, A, B] of elements that share a size: joint for this size, separate for the other one."""
    axis = _SIZES.index(correction.name)
    other = np.log(evidence.mean(axis=1 + axis))
    if correction.value is None:
        size = np.log(evidence.mean(axis=2 - axis)).sum(axis=0)
    else:
        sizes = (maps.widths, maps.heights)[axis]
        size = np.where(np.arange(len(sizes)) == np.abs(sizes - correction.value).argmin(), 0.0, np.log(_MIN_FACTOR))
    return other[:, None, :] + size[:, None] if axis == 0 else other[:, :, None] + size


def united(posterior: Floats, indices: Ints, corrections: Corrections) -> Floats:
    """Posterior [N, K + 1] that is equal for elements that are of one kind by a correction."""
    posterior = posterior.copy()
    for correction in corrections:
        rows = np.flatnonzero(np.isin(indices, correction.elements))
        if correction.what == "same" and len(rows):
            logs = np.log(np.maximum(posterior[rows], 1e-300)).mean(axis=0)
            joint = np.exp(logs - logs.max())
            posterior[rows] = joint / joint.sum()
    return posterior
