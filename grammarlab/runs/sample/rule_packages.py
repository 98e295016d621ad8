"""Rule packages (``.rpk``) of CityEngine, unpacked to a folder of temporary files."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import file_hash
from grammarlab.runs.sample.seven_zip import ArchiveFile, files_of

_COMPILED, _RULES = ".cgb", ".cga"
_WORKSPACE = ".ws"
"""Folder of a package with files of other projects, such as ``ESRI.lib``."""


class OpenPackage(NamedTuple):
    """A rule package whose files are in a folder."""

    rules: Path
    """The rule file that the package is made of."""
    library: Path | None
    """Folder of the other projects in it."""


def open_package(path: Path) -> OpenPackage:
    """A package in a folder of the user's temporary files; the same content is unpacked once.

    Raises:
        UsageError: If it cannot be read, or has no sources.
    """
    folder = _private_folder() / file_hash(path)[:32]
    try:
        names = _names(folder) if folder.is_dir() else _unpacked(path, folder)
        rules = folder / _main(names)
    except AssetError as error:
        raise UsageError(f"{path}: {error}.") from error
    except OSError as error:
        raise UsageError(f"{path} cannot be unpacked to {folder}: {error.strerror or error}.") from error
    library = folder / _WORKSPACE
    return OpenPackage(rules, library if library.is_dir() else None)


def _unpacked(path: Path, folder: Path) -> list[PurePosixPath]:
    """Names of the files of a package, which are in the folder afterwards, all or none."""
    files = {file.name: file for file in files_of(path)}
    _main(list(files))  # a package without sources is not unpacked
    part = Path(tempfile.mkdtemp(dir=folder.parent))
    try:
        for file in files.values():
            _write(part, file)
        if not folder.exists():
            part.replace(folder)
    except OSError:
        if not folder.is_dir():  # another process was not faster
            raise
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return list(files)


def _write(folder: Path, file: ArchiveFile) -> None:
    target = folder / _place(file.name)
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("xb") as stream:
        stream.write(file.content)


def _place(name: PurePosixPath) -> PurePosixPath:
    """Where a file is unpacked: assets of other projects below those of the package, where rules find them."""
    return PurePosixPath("assets", *name.parts[1:]) if name.parts[0] == _WORKSPACE and not _is(name, _RULES) else name


def _names(folder: Path) -> list[PurePosixPath]:
    return [PurePosixPath(file.relative_to(folder).as_posix()) for file in folder.rglob("*") if file.is_file()]


def _main(names: list[PurePosixPath]) -> PurePosixPath:
    """The source of the compiled rule file; those with ``$`` are compiled imports.

    Raises:
        AssetError: If there is none.
    """
    sources = {name.with_suffix("").parts[1:]: name for name in names if _is(name, _RULES) and name.parts[0] == "rules"}
    compiled = [name for name in names if _is(name, _COMPILED) and "$" not in name.name]
    for name in sorted(compiled):
        source = sources.get(name.with_suffix("").parts[1:])
        if source is not None:
            return source
    if len(sources) == 1:
        return next(iter(sources.values()))
    if sources:
        raise AssetError(
            f"the package does not say which of its {len(sources)} rule files is the first; unpack it, and name one"
        )
    raise AssetError(
        "the package has compiled rules only; its author can share it again with the rule files in it, or you can ask "
        "for them"
    )


def _is(name: PurePosixPath, suffix: str) -> bool:
    return name.suffix.lower() == suffix


def _private_folder() -> Path:
    """A folder that only this user can write to."""
    owner = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir()) / f"grammarlab-packages-{owner}"
    folder.mkdir(mode=0o700, exist_ok=True)
    status = folder.lstat()
    is_own = not hasattr(os, "getuid") or (status.st_uid == owner and not status.st_mode & 0o077)
    if not stat.S_ISDIR(status.st_mode) or not is_own:
        raise UsageError(f"{folder} belongs to another user or is open to others; remove it to open rule packages.")
    return folder
