"""Where asset files lie: in the asset folder of a project, perhaps with a library of further projects.

CityEngine resolves ``assets/trees/oak.obj`` from the root of a project, and ``/City/assets/trees/oak.obj`` from the
root of a workspace of projects. Here a project has one asset folder, so `meanings` removes the folders above it;
further projects lie side by side in a library.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import NamedTuple, TypeAlias

_PROJECT_FOLDERS = frozenset({"assets", "data", "images", "maps", "models"})
_MAX_FOLDERS = 12
"""Largest number of leading folders that are removed from a path."""
_MAX_PROJECTS = 64
"""Largest number of further projects in which relative names are searched."""
_ASSETS = "assets"


@dataclass(frozen=True, slots=True)
class ProjectAssets:
    """The asset folder of a project, with a folder of further projects."""

    folder: Path
    """Asset folder of the project; its files are found first."""
    library: Path
    """Folder of further projects, such as ``ESRI.lib``."""

    def is_dir(self) -> bool:
        """Whether the asset folder is a folder."""
        return self.folder.is_dir()

    def resolve(self) -> ProjectAssets:
        """Both folders as absolute paths without links."""
        return ProjectAssets(self.folder.resolve(), self.library.resolve())

    def __str__(self) -> str:
        return f"{self.folder} or the projects in {self.library}"


AssetRoot: TypeAlias = Path | ProjectAssets
"""An asset folder, or one with further projects."""


def asset_root(folder: Path, library: Path | None) -> AssetRoot:
    """An asset folder with a folder of further projects, if there is one."""
    return folder if library is None else ProjectAssets(folder, library)


def own_folder(root: AssetRoot) -> Path:
    """The asset folder of the project itself."""
    return root.folder if isinstance(root, ProjectAssets) else root


def library_of(root: AssetRoot) -> Path | None:
    """The folder of further projects, if there is one."""
    return root.library if isinstance(root, ProjectAssets) else None


class Place(NamedTuple):
    """A place where a file may be."""

    folder: Path
    """The folder that it may not leave."""
    name: str
    """Path relative to it, with slashes; hostile names may lead out."""


def places(path: str, root: AssetRoot) -> Iterator[Place]:
    """Places of a file, most likely first.

    A path that begins with a project is searched in the project's own tree and then in the library, as paths of
    imports are; then without its leading folders. A relative path is at last searched in the asset folder of each
    project of the library, by name.

    Args:
        path: path or pattern in a rule.
        root: the asset folder.
    """
    folder, library = own_folder(root), library_of(root)
    names = meanings(path)
    yield Place(folder, names[0])
    if library is not None and "/" in names[0] and _is_folder(library / names[0].split("/")[0]):
        yield Place(library, names[0])
    yield from (Place(folder, name) for name in names[1:])
    if library is not None and not path.startswith("/") and ".." not in names[0].split("/"):
        for project in _projects(library):
            yield from (Place(library, f"{project}/{_ASSETS}/{name}") for name in names)


def place_of(file: Path, root: AssetRoot) -> Place:
    """Place of a file that was found.

    Args:
        file: its path without links.
        root: the asset folder; the file is in it or in its library.
    """
    folder, library = own_folder(root).resolve(), library_of(root)
    if library is not None and not file.is_relative_to(folder):
        folder = library.resolve()
    return Place(folder, file.relative_to(folder).as_posix())


def meanings(path: str) -> list[str]:
    """Candidates, relative to the asset folder, for a path in a rule, most likely first.

    >>> meanings("trees/oak.obj"), meanings("assets/trees/oak.obj"), meanings("/City/assets/oak.obj")
    (['trees/oak.obj'], ['assets/trees/oak.obj', 'trees/oak.obj'], ['City/assets/oak.obj', 'assets/oak.obj', 'oak.obj'])
    """
    parts = path.lstrip("/").split("/")
    if ".." in parts:
        return ["/".join(parts)]
    above = len(parts) - 1 if path.startswith("/") else int(len(parts) > 1 and parts[0] in _PROJECT_FOLDERS)
    return ["/".join(parts[first:]) for first in range(min(above, _MAX_FOLDERS) + 1)]


def _projects(library: Path) -> list[str]:
    """The first projects of a library with assets, by name; links that lead out of it are left out.

    By name, since the order of a folder differs between machines, and models may not.
    """
    try:
        inside = library.resolve()
        projects = (
            project.name
            for project in sorted(library.iterdir())
            if _is_folder(project / _ASSETS) and (project / _ASSETS).resolve().is_relative_to(inside)
        )
        return list(islice(projects, _MAX_PROJECTS))
    except (OSError, RuntimeError):
        return []


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):  # a name that is too long, a zero byte
        return False
