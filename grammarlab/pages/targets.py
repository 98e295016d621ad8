"""Names of the files that a page saves to."""

from __future__ import annotations

from pathlib import Path

from grammarlab.errors import UsageError


def stem_of(path: Path) -> str:
    """The name of a file of a facade or a design without its suffixes.

    >>> stem_of(Path("house.facade.json")), stem_of(Path("house.json")), stem_of(Path("house.toml"))
    ('house', 'house', 'house')
    """
    return path.name.removesuffix(".toml").removesuffix(".json").removesuffix(".facade")


def unused_path(path: Path, suffix: str) -> Path:
    """An unused path with this suffix in the same folder, numbered if needed."""
    stem, number = stem_of(path), 1
    while (candidate := path.with_name(f"{stem}{f'-{number}' if number > 1 else ''}{suffix}")).exists():
        number += 1
    return candidate


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


def opened_target(file: Path, output: Path | None, ending: str, suffix: str) -> tuple[Path, bool]:
    """The file to save to, and whether it is the opened file.

    Args:
        file: the opened file.
        output: the requested file; None for a new one in the current folder.
        ending: required last suffix of a requested file.
        suffix: all suffixes of a new file.

    Raises:
        UsageError: If the requested file cannot be saved to.
    """
    target = checked_target(output, ending) if output else unused_path(Path(f"{stem_of(file)}.edited{ending}"), suffix)
    return target, target.exists() and target.samefile(file)
