"""Facades as files of other kinds, beside the one that is edited."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.facade.file import save_facade
from grammarlab.facade.sizes.wishes import Wish
from grammarlab.facade.tree import Facade
from grammarlab.runs.facade.grammar import grammar_of, save_grammar
from grammarlab.runs.facade.show import show_facade

FORMATS = ("json", "svg", "png", "glb", "obj", "cga")
SUFFIX = ".facade.json"


def export(facade: Facade, path: Path, locks: Sequence[Wish] = ()) -> Path:
    """Write a facade as what the ending of the path says.

    Raises:
        FacadeError: when it cannot be written as that.
    """
    if path.suffix == ".json":
        return save_facade(facade, path, locks)
    if path.suffix == ".cga":
        save_grammar(grammar_of(facade), facade, path)
        return path
    return show_facade(facade, path)


def stem_of(path: Path) -> str:
    """The name of a file of a facade or a design without what says that it is one.

    >>> stem_of(Path("house.facade.json")), stem_of(Path("house.json")), stem_of(Path("house.toml"))
    ('house', 'house', 'house')
    """
    return path.name.removesuffix(".toml").removesuffix(".json").removesuffix(".facade")


def unused_path(path: Path, suffix: str) -> Path:
    """A path that ends so, in the same folder, with a number if there is a file of that name."""
    stem, number = stem_of(path), 1
    while (found := path.with_name(f"{stem}{f'-{number}' if number > 1 else ''}{suffix}")).exists():
        number += 1
    return found


def checked_target(path: Path, ending: str = ".json") -> Path:
    """A path that a facade, or what else ends so, can be saved to.

    Raises:
        UsageError: when its folder is missing, or it does not end so.
    """
    if path.suffix.lower() != ending:
        raise UsageError(f"{path}: expected the name of a file that ends in {ending}.")
    if not path.parent.is_dir():
        raise UsageError(f"{path}: there is no folder {str(path.parent)!r}; make it first.")
    return path
