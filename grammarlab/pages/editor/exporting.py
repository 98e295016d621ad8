"""Exports of facades to other formats, beside the edited file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grammarlab.facade.file import save_facade
from grammarlab.facade.sizes.size_wishes import Wish
from grammarlab.facade.tree import Facade
from grammarlab.runs.facade.gallery import show_facade
from grammarlab.runs.facade.grammar_file import grammar_of, save_grammar

SUFFIX = ".facade.json"
SUFFIXES = {"json": SUFFIX} | {form: f".{form}" for form in ("svg", "png", "glb", "obj", "cga")}
"""Suffixes of exported files by format."""


def export(facade: Facade, path: Path, locks: Sequence[Wish] = ()) -> Path:
    """Write a facade in the format of the path's suffix.

    Raises:
        FacadeError: If it cannot be written in that format.
    """
    if path.suffix == ".json":
        return save_facade(facade, path, locks)
    if path.suffix == ".cga":
        save_grammar(grammar_of(facade), facade, path)
        return path
    return show_facade(facade, path)
