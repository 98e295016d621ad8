"""Named experiments: sets of curves in one picture, like the paper's figures.

A file of experiments is TOML::

    [[figures]]
    name = "4.9a"                  # of the files, and for --figures
    title = "Noise of the kernel, F1"
    paper = "Too much and too little noise both learn slowly."
    scenario = "F1"                # a scenario file in the parent folder, without its suffix
    max_labels = 448
    [[figures.curves]]
    label = "noise 0.01"
    method = "paper"               # a name of --methods; the next keys change it
    options = { noise = 0.01 }     # parameters of the fit

A curve may have a scenario of its own, and any of fit, query, batch, path_length, grows, factored and options of
`grammarlab.evaluation.methods.Method`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from grammarlab.errors import AssetError, TomlError, UsageError
from grammarlab.evaluation.methods import METHODS, Method, checked
from grammarlab.evaluation.scenario import SUFFIX
from grammarlab.files import read_bounded
from grammarlab.toml_text import toml_table, toml_text

MAX_BYTES = 1 << 18
"""Largest size of a file of experiments in bytes."""
MAX_LABELS = 100_000
"""Largest number of labels of a curve."""


@dataclass(frozen=True, slots=True)
class PlannedCurve:
    """One line of a picture, over several seeds."""

    label: str
    scenario: Path
    method: Method


@dataclass(frozen=True, slots=True)
class PlannedFigure:
    """One picture."""

    name: str
    """``4.7a``: letters, digits, dots, - and _."""
    title: str
    paper: str
    """Description of the paper's figure of that name."""
    max_labels: int
    curves: tuple[PlannedCurve, ...]
    """At least one, with different labels."""


def load_figures(folder: Path, names: str = "all") -> tuple[PlannedFigure, ...]:
    """The experiments of all files in a folder.

    Args:
        folder: folder with files of experiments; their scenarios are in the parent folder.
        names: ``all``, or names separated by commas.

    Raises:
        UsageError: If a file cannot be read or is not valid, or a name is unknown.
    """
    files = sorted(folder.glob(f"*{SUFFIX}"))
    if not files:
        raise UsageError(f"no experiments: expected {SUFFIX} files in {folder}.")
    by_name = {figure.name: figure for file in files for figure in _read(file)}
    requested = list(by_name) if names == "all" else [name.strip() for name in names.split(",") if name.strip()]
    for name in requested:
        if name not in by_name:
            raise UsageError(f"unknown figure {name!r}. Expected one of all, {', '.join(by_name)}.")
    return tuple(by_name[name] for name in requested)


def _read(path: Path) -> list[PlannedFigure]:
    try:
        table = toml_table(toml_text(read_bounded(path, MAX_BYTES)))
    except AssetError as error:
        raise UsageError(str(error)) from error
    except TomlError as error:
        raise UsageError(f"{path}: {error}.") from error
    tables = table.get("figures")
    if not isinstance(tables, list) or set(table) != {"figures"}:
        raise UsageError(f"{path}: expected only tables [[figures]].")
    return [_figure(values, path, f"{path}: figure {number}") for number, values in enumerate(tables, 1)]


def _figure(values: Any, path: Path, where: str) -> PlannedFigure:
    types: dict[str, type] = {
        "name": str,
        "title": str,
        "paper": str,
        "scenario": str,
        "max_labels": int,
        "curves": list,
    }
    _check(values, types, ("name", "title", "max_labels", "curves"), where)
    name = values["name"]
    if not name or not all(char.isalnum() or char in ".-_" for char in name) or name.startswith("."):
        raise UsageError(f"{where}: expected a name of letters, digits, dots, - and _, found {name[:40]!r}.")
    if not 1 <= values["max_labels"] <= MAX_LABELS:
        raise UsageError(f"{where}: expected max_labels from 1 to {MAX_LABELS}, found {values['max_labels']}.")
    scenario = values.get("scenario")
    curves = tuple(
        _curve(curve, scenario, path, f"{where} ({name}): curve {number}")
        for number, curve in enumerate(values["curves"], 1)
    )
    if not curves or len({curve.label for curve in curves}) < len(curves):
        raise UsageError(f"{where} ({name}): expected at least one curve, each with a unique label.")
    return PlannedFigure(name, values["title"], values.get("paper", ""), values["max_labels"], curves)


def _curve(values: Any, scenario: str | None, path: Path, where: str) -> PlannedCurve:
    parts = {field.name for field in fields(Method)} - {"name", "options", "families"}
    defaults = Method(name="default")
    types: dict[str, type] = {"label": str, "scenario": str, "method": str, "options": dict}
    types |= {part: type(getattr(defaults, part)) for part in parts}
    _check(values, types, ("label",), where)
    base = values.get("method", "default")
    if base not in METHODS:
        raise UsageError(f"{where}: unknown method {base!r}. Expected one of {', '.join(METHODS)}.")
    options = values.get("options", {})
    for name, value in options.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UsageError(f"{where}: expected a number for option {name}, found {value!r}.")
    changes = {part: values[part] for part in parts & set(values)}
    method = replace(
        METHODS[base],
        name=values["label"],
        options=tuple(sorted({**dict(METHODS[base].options), **options}.items())),
        **changes,
    )
    name = values.get("scenario", scenario)
    if name is None:
        raise UsageError(f"{where}: expected a scenario for the curve or for the figure.")
    return PlannedCurve(values["label"], path.parent.parent / f"{name}{SUFFIX}", checked(method, where))


def _check(values: Any, types: Mapping[str, type], required: tuple[str, ...], where: str) -> None:
    """Check that a table has all required keys, no unknown ones, and the right types."""
    if not isinstance(values, dict):
        raise UsageError(f"{where}: expected a table, found {values!r:.40}.")
    for name in required:
        if name not in values:
            raise UsageError(f"{where}: {name} is missing.")
    for name, value in values.items():
        if name not in types:
            raise UsageError(f"{where}: unknown key {name!r}. Expected one of {', '.join(sorted(types))}.")
        expected = types[name]
        if not isinstance(value, expected) or (isinstance(value, bool) and expected is not bool):
            raise UsageError(f"{where}: {name} has the wrong type: found {value!r:.40}.")
