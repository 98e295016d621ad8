"""Exports of facades to other formats, beside the edited file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.facade.file import save_facade
from grammarlab.facade.sizes.size_wishes import Wish
from grammarlab.facade.tree import Facade
from grammarlab.runs.facade.gallery import show_facade
from grammarlab.runs.facade.grammar_file import grammar_of, save_grammar

FORMATS = ("json", "svg", "png", "glb", "obj", "cga")
SUFFIX = ".facade.json"


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


def stem_of(path: Path) -> str:
    """The name of a file of a facade or a design without its suffixes.

    >>> stem_of(Path("house.facade.json")), stem_of(Path("house.json")), stem_of(Path("house.toml"))
    ('house', 'house', 'house')
    """
    return path.name.removesuffix(".toml").removesuffix(".json").removesuffix(".facade")


def unused_path(path: Path, suffix: str) -> Path:
    """An unused path with this suffix in the same folder, numbered if needed."""
    stem, number = stem_of(path), 1
    while (found := path.with_name(f"{stem}{f'-{number}' if number > 1 else ''}{suffix}")).exists():
        number += 1
    return found


def checked_target(path: Path, ending: str = ".json") -> Path:
    """A path to which a facade, or another file with this suffix, can be saved.

    Raises:
        UsageError: If its folder is missing, or it has another suffix.
    """
    if path.suffix.lower() != ending:
        raise UsageError(f"{path}: expected the name of a file that ends in {ending}.")
    if not path.parent.is_dir():
        raise UsageError(f"{path}: there is no folder {str(path.parent)!r}; create it first.")
    return path
