"""Functions of asset files: lists, parts of names, and sizes."""

from __future__ import annotations

from collections.abc import Callable
from fnmatch import fnmatchcase
from functools import partial
from itertools import islice, takewhile
from pathlib import Path, PurePosixPath

import numpy as np

from grammarlab.asset_roots import AssetRoot, own_folder, places
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.text_functions import text_function
from grammarlab.derivation.state.shapes import Value, kind_of
from grammarlab.errors import AssetError, DerivationError, MissingAssetError
from grammarlab.language.syntax.keywords import KEYWORDS

_MOST_FILES = 20_000
"""Largest number of files that one search examines."""


def matching_files(
    assets: AssetRoot | None, pattern: str, list_names: Callable[[Path, str], list[str]] | None = None
) -> list[str]:
    """Asset paths that match a pattern with ``*`` and ``?``, relative to the asset folder and sorted.

    Only files inside the asset folder and its library are listed, and at most 20,000 files are examined in each folder.
    Paths of files in the library begin with their project, after a slash if the pattern has one.

    Args:
        assets: the asset folder.
        pattern: the pattern.
        list_names: `names_below`, or what remembers its lists for several patterns.
    """
    list_names = list_names or names_below
    if assets is None or not assets.is_dir():
        return []
    own = own_folder(assets)
    names = list_names(own, "")
    for folder, meaning in places(pattern, assets):
        listed = names if folder == own else list_names(folder, _fixed_folder(meaning))
        if matches := sorted(name for name in listed if fnmatchcase(name, meaning)):
            slash = "/" if folder != own and pattern.startswith("/") else ""
            return [slash + name for name in matches]
    return []


def _fixed_folder(pattern: str) -> str:
    """The folders at the beginning of a pattern that have no ``*``, ``?`` or ``[``."""
    folders = pattern.split("/")[:-1]
    return "/".join(takewhile(lambda folder: not set(folder) & set("*?["), folders))


def names_below(folder: Path, start: str) -> list[str]:
    """Paths of files relative to a folder, from one of its folders on."""
    root = folder.resolve()
    first = root / start
    try:
        inside = ".." not in first.parts and first.resolve().is_relative_to(root)
    except (OSError, ValueError, RuntimeError):  # a name that is too long, a zero byte, circular links
        inside = False
    if not inside:
        return []
    return [
        path.relative_to(root).as_posix()
        for path in islice(first.rglob("*"), _MOST_FILES)
        if path.is_file() and path.resolve().is_relative_to(root)
    ]


def root_of(call: FunctionCall) -> AssetRoot | None:
    """The asset folder of a derivation, if it has one."""
    return None if call.workspace.assets is None else call.workspace.assets.root


def _search(call: FunctionCall) -> Value:
    match_names = partial(matching_files, root_of(call))
    return text_function(lambda pattern: "".join(f"{name};" for name in match_names(pattern))).evaluate(call)


def _exists(call: FunctionCall) -> Value:
    match_names = partial(matching_files, root_of(call))
    return text_function(lambda name: name in match_names(name)).evaluate(call)


def mesh_extent(path: str, call: FunctionCall) -> tuple[float, ...]:
    """Size of a mesh in its file; that of a unit box if the folder lacks it, since ``i`` uses a unit box instead."""
    asset = None if path.startswith("builtin:") else call.workspace.asset(path, call.location)
    return (1.0, 1.0, 1.0) if asset is None else tuple(asset.size.tolist())


def image_extent(path: str, call: FunctionCall) -> tuple[float, ...]:
    """Width and height of an image in pixels; 1 and 1 if the folder lacks it.

    Raises:
        DerivationError: If it is not an image, or lies outside the asset folder.
    """
    root = root_of(call)
    if root is None or path.startswith("builtin:"):
        return 1.0, 1.0
    from grammarlab.assets.texture_files import image_size  # noqa: PLC0415  # few grammars have images

    try:
        width, height = image_size(path, root)
    except MissingAssetError:
        return 1.0, 1.0
    except AssetError as error:
        raise DerivationError(str(error), call.location) from error
    return float(width), float(height)


def _asset_info(call: FunctionCall) -> Value:
    """``assetInfo(path, sx)``: the size of a mesh in its file, or with ``tx`` the position of its low corner."""
    measure = str(call.arguments[1])
    axis = "xyz".index(measure[1])

    def measured(path: str) -> float:
        if measure[0] == "s":
            return mesh_extent(path, call)[axis]
        asset = None if path.startswith("builtin:") else call.workspace.asset(path, call.location)
        return 0.0 if asset is None else float(asset.low[axis])

    return _measured(call, measured)


def _image_info(call: FunctionCall) -> Value:
    """``imageInfo(path, sx)``: the width of an image in pixels, or with ``sy`` its height."""
    axis = "xy".index(str(call.arguments[1])[1])
    return _measured(call, lambda path: image_extent(path, call)[axis])


def _measured(call: FunctionCall, measure: Callable[[str], float]) -> Value:
    """A number for each file, computed once for each different path."""
    path = call.arguments[0]
    if isinstance(path, str):
        return measure(path)
    if kind_of(path) != "string":
        raise DerivationError(f"{call.name} expected a string, found a {kind_of(path)}", call.location)
    return call.workspace.strings.numbers(np.asarray(path), measure)


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
    "imageInfo": Builtin(_image_info, (2, 2), keywords=KEYWORDS["image_measure"]),
}
