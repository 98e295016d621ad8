"""Asset files seen from a rule: listing them, and the parts of their names."""

from __future__ import annotations

from fnmatch import fnmatchcase
from functools import partial
from itertools import islice
from pathlib import Path, PurePosixPath

import numpy as np

from grammarlab.derivation.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.text import text_function
from grammarlab.derivation.shapes import Value, kind_of
from grammarlab.errors import AssetError, DerivationError
from grammarlab.geometry.asset_paths import meanings
from grammarlab.language.keywords import KEYWORDS

_MOST_FILES = 20_000


def matching_files(assets: Path | None, pattern: str) -> list[str]:
    """Asset paths that match a pattern with ``*`` and ``?``, relative to the asset folder and sorted.

    Nothing outside the asset folder is ever listed, and no more than 20,000 files are looked at.
    """
    if assets is None or not assets.is_dir():
        return []
    root = assets.resolve()
    names = [
        path.relative_to(root).as_posix()
        for path in islice(root.rglob("*"), _MOST_FILES)
        if path.is_file() and path.resolve().is_relative_to(root)
    ]
    found = (sorted(name for name in names if fnmatchcase(name, meaning)) for meaning in meanings(pattern))
    return next(filter(None, found), [])


def root_of(call: FunctionCall) -> Path | None:
    """The asset folder of a derivation, if it has one."""
    return None if call.workspace.assets is None else call.workspace.assets.root


def _search(call: FunctionCall) -> Value:
    found = partial(matching_files, root_of(call))
    return text_function(lambda pattern: "".join(f"{name};" for name in found(pattern))).evaluate(call)


def _exists(call: FunctionCall) -> Value:
    found = partial(matching_files, root_of(call))
    return text_function(lambda name: name in found(name)).evaluate(call)


def _asset_info(call: FunctionCall) -> Value:
    """``assetInfo(path, sx)``: the size of a mesh in its file, or with ``tx`` where its low corner lies."""
    path, measure = call.arguments[0], str(call.arguments[1])
    strings, folder, axis = call.workspace.strings, call.workspace.assets, "xyz".index(measure[1])

    def measured(name: str) -> float:
        if name.startswith("builtin:"):
            return 1.0 if measure[0] == "s" else 0.0
        if folder is None:
            raise DerivationError(f'the asset "{name}" needs an asset folder', call.location)
        try:
            asset = folder.load(name)
        except AssetError as error:
            raise DerivationError(str(error), call.location) from error
        return float((asset.size if measure[0] == "s" else asset.low)[axis])

    if isinstance(path, str):
        return measured(path)
    if kind_of(path) != "string":
        raise DerivationError(f"assetInfo expected a string, found a {kind_of(path)}", call.location)
    return strings.numbers(np.asarray(path), measured)


BUILTINS: dict[str, Builtin] = {
    "assetInfo": Builtin(_asset_info, (2, 2), keywords=KEYWORDS["asset_measure"]),
    "fileBasename": text_function(lambda path: PurePosixPath(path).stem),
    "fileDirectory": text_function(
        lambda path: f"{parent}/" if (parent := str(PurePosixPath(path).parent)) != "." else ""
    ),
    "fileExists": Builtin(_exists, (1, 1)),
    "fileExtension": text_function(lambda path: PurePosixPath(path).suffix.removeprefix(".")),
    "fileName": text_function(lambda path: PurePosixPath(path).name),
    "fileSearch": Builtin(_search, (1, 1)),
}
