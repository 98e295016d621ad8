"""Asset files of a run, and detection of changes in them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from urllib.parse import unquote

from grammarlab.assets.meshes import find_asset
from grammarlab.derivation.functions.files import matching_files
from grammarlab.errors import AssetError
from grammarlab.files import file_hash
from grammarlab.runs.requests.domains import opened
from grammarlab.runs.requests.request import SampleRequest


def hash_assets(request: SampleRequest) -> dict[str, str]:
    """SHA-256 of the asset files named in a request, by path relative to its asset folder.

    These are the files whose names, or patterns with ``*`` and ``?``, are strings in the rules, items of lists with
    semicolons, or values of attributes; and the buffers of glTF files among them. Names that rules build from parts
    are not known before the derivation, so those files are not included.

    Raises:
        LanguageError: If the rules have errors.
    """
    files = named_files(_texts(request), request.assets)
    return {name: file_hash(files[name]) for name in sorted(files)}


def named_files(texts: Iterable[str], assets: Path) -> dict[str, Path]:
    """Files of an asset folder named in texts, by path relative to it.

    Args:
        texts: names, patterns with ``*`` and ``?``, or lists of both with semicolons; other texts are ignored.
        assets: the folder.
    """
    root = assets.resolve()
    return {
        file.relative_to(root).as_posix(): file
        for text in texts
        for name in text.split(";")
        for file in _files(name, assets)
    }


def first_difference(before: Mapping[str, str], now: Mapping[str, str]) -> str:
    """Description of a difference between the asset files of two runs; empty if there is none."""
    for name in sorted({*before, *now}):
        if before.get(name) != now.get(name):
            what = "is missing" if name not in now else "is new" if name not in before else "has changed"
            return f"the asset {name!r} {what}"
    return ""


def _texts(request: SampleRequest) -> Iterator[str]:
    """Every string that may name an asset file."""
    yield from opened(request.suffix, request.text, request.name, request.assets).asset_names()
    for values in (request.attributes, *(footprint.properties for footprint in request.footprints)):
        yield from (value for value in values.values() if isinstance(value, str))


def _files(name: str, assets: Path) -> Iterator[Path]:
    """Files of the asset folder that match a name or pattern, with the buffers of glTF files."""
    for each in matching_files(assets, name) if "*" in name or "?" in name else [name]:
        file = _asset(each, assets)
        if file is None:
            continue
        yield file
        if file.suffix.lower() == ".gltf":
            folder = file.parent.relative_to(assets.resolve())
            yield from filter(None, (_asset(str(folder / uri), assets) for uri in _buffers(file)))


def _asset(name: str, assets: Path) -> Path | None:
    try:
        return find_asset(name, assets)
    except AssetError:
        return None


def _buffers(file: Path) -> list[str]:
    """Names of the buffers in a glTF file; none for a broken file, which no model can use."""
    try:
        return [unquote(buffer["uri"]) for buffer in json.loads(file.read_bytes())["buffers"]]
    except (ValueError, LookupError, TypeError, RecursionError):
        return []
