"""Images of the materials of meshes: found beside the file of the mesh, never outside its folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

INSIDE = "#image"
"""Begins the number of an image inside a glTF file, after the path of the file: ``trees/oak.glb#image3``."""


def image_beside(name: str, folder: Path, root: Path) -> str:
    r"""Path of an image relative to the asset folder, from its name in a file of materials.

    The image lies in the folder of the file or below it; upper and lower case may differ. Names that lead elsewhere,
    such as ``C:\textures\brick.jpg``, mean the file of this name in the folder itself.

    Args:
        name: name in the file.
        folder: folder of the file, relative to the root.
        root: the asset folder.

    Returns:
        The path of the image; if there is none, the path where it was expected.
    """
    words = [word for word in name.replace("\\", "/").split("/") if word not in ("", ".")]
    if not words:
        return ""
    leads_away = name.startswith(("/", "\\")) or ".." in words or ":" in words[0]
    for candidate in ([] if leads_away else [words]) + [words[-1:]]:
        path = _found(root / folder, candidate)
        if path is not None:
            return (folder / path).as_posix()
    return (folder / words[-1]).as_posix()


def _found(folder: Path, words: Sequence[str]) -> Path | None:
    """Path of a file relative to a folder that it does not leave; None if there is none."""
    try:
        path = folder
        for word in words:
            path = path / word if (path / word).exists() else _same_letters(path, word)
        inside = path.is_file() and path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        return None
    return path.relative_to(folder) if inside else None


def _same_letters(folder: Path, word: str) -> Path:
    """The entry of a folder with these letters in upper or lower case; the first by name, or one that is missing."""
    letters = word.casefold()
    return min((entry for entry in folder.iterdir() if entry.name.casefold() == letters), default=folder / word)
