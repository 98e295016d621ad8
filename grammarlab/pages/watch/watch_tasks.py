"""Tasks of the worker that makes models of a watched rule file, and their results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from grammarlab.pages.watch.controls import Control


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is to be seen of a rule file."""

    seed: int = 0
    model: int = 0
    attributes: tuple[tuple[str, str], ...] = ()
    """Names and values that differ from the file, as texts of `read_attributes`."""


@dataclass(frozen=True, slots=True)
class MakeModel:
    """Task: derive a model: `MadeModel`."""

    wanted: Wanted


@dataclass(frozen=True, slots=True)
class DrawPicture:
    """Task: draw a model, as the bytes of a JPEG."""

    wanted: Wanted
    size: int
    """Pixels along each side."""


Severity = Literal["error", "warning", "note"]
"""Kinds of what is said beside a model."""


@dataclass(frozen=True, slots=True)
class Mistake:
    """An error or a warning about the rule file, or what its rules print."""

    severity: Severity
    message: str
    hint: str = ""
    line: int = 0
    """From 1; 0 if it is unknown."""
    column: int = 0
    code: tuple[str, str] = ("", "")
    """What is before and behind the place in the line of the file; empty if the line is unknown."""


@dataclass(frozen=True, slots=True)
class MadeModel:
    """A model, or why there is none."""

    glb: bytes = b""
    """Empty if there are errors."""
    shapes: int = 0
    """Number of nodes of the derivation tree, as in the records of a run."""
    controls: tuple[Control, ...] | None = None
    """None if the rules cannot be read."""
    mistakes: tuple[Mistake, ...] = ()
    tree: tuple[list[Any], ...] = ()
    """Rows of the derivation tree; see `grammarlab.pages.watch.part_tree`."""
