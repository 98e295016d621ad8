"""From a file of elements to a folder with their kinds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.extras import require
from grammarlab.facade.file import save_facade
from grammarlab.files import atomic_file, write_text
from grammarlab.matching.corrections import Corrections
from grammarlab.matching.elements import Elements
from grammarlab.matching.match import Match, doubt, groups, sentences
from grammarlab.matching.match_grammar import completed, picture, write_terminals
from grammarlab.matching.template import Template
from grammarlab.runs.facade.gallery import show_facade
from grammarlab.runs.work.run_folder import only_run_in, replace_written

FILES = ("match.json", "match.png", "completed.facade.json", "completed.glb", "kinds.cga")

Method = Literal["default", "paper", "independent", "kmeans"]
METHODS: tuple[str, ...] = get_args(Method)


def match_elements(
    elements: Elements, templates: tuple[Template, ...], method: str, seed: int, corrections: Corrections = ()
) -> Match:
    """The kinds of elements.

    Raises:
        UsageError: If the method is unknown, or another method than the default gets corrections.
    """
    if method not in METHODS:
        raise UsageError(f"`method=`: expected one of {', '.join(METHODS)}, found {method!r}.")
    if corrections and method != "default":
        raise UsageError(f"`corrections=`: only the default method supports them, not {method}.")
    require("jax")
    # These imports load jax, which takes seconds.
    from grammarlab.matching.coupled import couple  # noqa: PLC0415
    from grammarlab.matching.paper_loop import match_as_paper  # noqa: PLC0415
    from grammarlab.matching.plain import match_alone  # noqa: PLC0415

    if method == "paper":
        return match_as_paper(elements, templates)
    if method == "default":
        return couple(elements, templates, seed, corrections)
    truth = elements.truth
    num_kinds = 0 if truth is None else len(np.unique(truth.kind))
    return match_alone(elements, templates, None if method == "independent" else num_kinds)


def as_dict(match: Match, method: str, seed: int) -> dict[str, Any]:
    """Values for `--json`."""
    from grammarlab.matching.plain import compare  # noqa: PLC0415 loads libraries of statistics

    used = [match.templates[index].name for index in np.unique(match.kind_template).tolist()]
    truth = match.elements.truth
    return {
        "method": method,
        "seed": seed,
        "elements": [_element(match, index) for index in range(len(match.kind))],
        "groups": groups(match),
        "words": sentences(match),
        "templates": used,
        "iterations": match.iterations,
        "truth": None if truth is None else compare(match, truth),
        "notes": list(match.elements.notes),
        "seconds": dict(match.seconds),
    }


def _element(match: Match, element: int) -> dict[str, Any]:
    kind = int(match.kind[element])
    is_known = kind >= 0
    template = match.template_of(kind) if is_known else None
    names = template.parameters if template else ()
    return {
        "element": element,
        "kind": match.name_of(kind),
        "template": template.name if template else None,
        "counts": dict(template.counts) if template else {},
        "parameters": dict(zip(names, match.parameters[element].tolist(), strict=True)),
        "standard_deviations": dict(zip(names, match.deviations[element].tolist(), strict=True)),
        "probability": float(match.probability[element]),
        "position": match.corner[element].tolist() if is_known else None,
        "hidden": float(match.hidden[element]),
        "row": int(match.elements.row[element]) if match.elements.row[element] >= 0 else None,
        "column": int(match.elements.column[element]) if match.elements.column[element] >= 0 else None,
        "uncertain": doubt(match, element) or None,
    }


def save_match(match: Match, values: dict[str, Any], folder: Path) -> list[Path]:
    """Write all files of a match into a folder; those of the earlier run are replaced, or removed if unchanged.

    Returns:
        The written files: the match, a picture, the completed facade with its mesh, and the grammar of its kinds.

    Raises:
        UsageError: If another run is writing into the folder.
    """
    with only_run_in(folder):
        written = _write(match, values, folder)
        replace_written(folder, "match", written)
    return written


def _write(match: Match, values: dict[str, Any], folder: Path) -> list[Path]:
    written = [folder / FILES[0], folder / FILES[1]]
    with atomic_file(written[1]) as part:
        picture(match).save(part)
    facade = completed(match)
    if facade is not None:
        written += [save_facade(facade.facade, folder / FILES[2]), show_facade(facade.facade, folder / FILES[3])]
    grammar = write_terminals(match)
    if grammar is not None:
        write_text(folder / FILES[4], grammar)
        written.append(folder / FILES[4])
    values["files"] = [str(path) for path in written]
    write_text(written[0], json.dumps(values, indent=2, allow_nan=False) + "\n")
    return written
