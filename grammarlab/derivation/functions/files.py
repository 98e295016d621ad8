"""Asset files seen from a rule: listing them, and the parts of their names."""

from __future__ import annotations

from fnmatch import fnmatchcase
from functools import partial
from itertools import islice
from pathlib import Path, PurePosixPath

from grammarlab.derivation.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.text import text_function
from grammarlab.derivation.shapes import Value

_MOST_FILES = 20_000


def matching_files(assets: Path | None, pattern: str) -> list[str]:
    """Asset paths that match a pattern with ``*`` and ``?``, relative to the asset folder and sorted.

    Nothing outside the asset folder is ever listed, and no more than 20,000 files are looked at.
    """
    if assets is None or not assets.is_dir():
        return []
    root = assets.resolve()
    found = []
    for path in islice(root.rglob("*"), _MOST_FILES):
        if path.is_file() and path.resolve().is_relative_to(root):
            name = path.relative_to(root).as_posix()
            if fnmatchcase(name, pattern.lstrip("/")):
                found.append(name)
    return sorted(found)


def root_of(call: FunctionCall) -> Path | None:
    """The asset folder of a derivation, if it has one."""
    return None if call.workspace.assets is None else call.workspace.assets.root


def _search(call: FunctionCall) -> Value:
    found = partial(matching_files, root_of(call))
    return text_function(lambda pattern: "".join(f"{name};" for name in found(pattern))).evaluate(call)


def _exists(call: FunctionCall) -> Value:
    found = partial(matching_files, root_of(call))
    return text_function(lambda name: name in found(name)).evaluate(call)


BUILTINS: dict[str, Builtin] = {
    "fileBasename": text_function(lambda path: PurePosixPath(path).stem),
    "fileDirectory": text_function(
        lambda path: f"{parent}/" if (parent := str(PurePosixPath(path).parent)) != "." else ""
    ),
    "fileExists": Builtin(_exists, (1, 1)),
    "fileExtension": text_function(lambda path: PurePosixPath(path).suffix.removeprefix(".")),
    "fileName": text_function(lambda path: PurePosixPath(path).name),
    "fileSearch": Builtin(_search, (1, 1)),
}
