"""Manifest of a run: request, versions and results, enough to make the same files again."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from grammarlab.about import __version__
from grammarlab.derivation.forest import MissingAsset
from grammarlab.errors import AssetError
from grammarlab.files import write_text
from grammarlab.geometry.outlines.footprints import Georeference, Remark
from grammarlab.rendering.choice import RendererChoice
from grammarlab.runs.requests.examples import examples_folder
from grammarlab.runs.requests.request import SampleRequest
from grammarlab.runs.sampling.place import place_of
from grammarlab.runs.sampling.records import ModelRecord

MANIFEST = "manifest.json"
FORMAT = 2
"""Version of the file. In version 1 a batch held the models of one footprint, never of several."""
_FIRST_FORMAT, BATCHES_OVER_FOOTPRINTS = 1, 2
MAX_FILE_BYTES = 1 << 30
_LIBRARIES = ("numpy", "scipy", "shapely", "trimesh", "embreex", "mapbox_earcut", "pillow", "pyarrow", "lark")
_GL_LIBRARIES = ("pyrender-maintained", "PyOpenGL")
_SHIPPED = "shipped"


@dataclass(frozen=True, slots=True)
class Manifest:
    """A finished or unfinished run."""

    request: SampleRequest
    format: int
    """Version of the file."""
    complete: bool
    """False during the run, and after an interruption."""
    versions: Mapping[str, str]
    models: tuple[Mapping[str, Any], ...]
    files: Mapping[str, str]
    """SHA-256 of each file by its path relative to the manifest; empty until the run is complete."""
    asset_files: Mapping[str, str]
    """SHA-256 of the asset files named in the request (`hash_assets`), by path relative to the asset folder."""


def write_manifest(
    folder: Path,
    request: SampleRequest,
    choice: RendererChoice,
    asset_files: Mapping[str, str],
    models: Sequence[ModelRecord] = (),
    files: Mapping[str, str] | None = None,
    missing_assets: Sequence[MissingAsset] = (),
) -> Path:
    """Write the manifest of a run; it is complete if `files` is given.

    Args:
        folder: the run's folder.
        request: the request.
        choice: renderer of the sheet.
        asset_files: hashes of the asset files named in the request.
        models: the finished models, by index.
        files: hashes of all files; None during the run.
        missing_assets: meshes that the asset folder lacks.
    """
    values = {
        "format": FORMAT,
        "complete": files is not None,
        "grammar": {"name": request.name, "sha256": request.text_hash, "text": request.text},
        "request": request.as_json(),
        "place": place_of(request),
        "remarks": [asdict(remark) for remark in request.remarks],
        "assets": _describe_assets(request.assets, folder),
        "asset_files": dict(asset_files),
        "missing_assets": [asdict(asset) for asset in missing_assets],
        "versions": current_versions() | _drawing_versions(choice),
        "models": [asdict(model) for model in models],
        "files": dict(sorted((files or {}).items())),
    }
    path = folder / MANIFEST
    write_text(path, json.dumps(values, indent=1, ensure_ascii=False) + "\n")
    return path


def read_manifest(path: Path | str, assets: Path | None = None) -> Manifest:
    """Manifest from a file, or from the folder of a run.

    Args:
        path: the file or the folder.
        assets: a folder of assets to use instead of the one the manifest names.

    Raises:
        AssetError: If there is none, or it is damaged.
    """
    path = Path(path)
    path = path / MANIFEST if path.is_dir() else path
    if not path.is_file():
        raise AssetError(f"{path}: no such manifest. `grammarlab sample` writes one into its output folder.")
    if path.stat().st_size > MAX_FILE_BYTES:
        raise AssetError(f"{path}: larger than {MAX_FILE_BYTES} bytes, so it is not a manifest.")
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        version = values["format"]
        if version not in range(_FIRST_FORMAT, FORMAT + 1):
            raise AssetError(f"{path}: expected a manifest of format {FORMAT}, found format {version}.")
        text = values["grammar"]["text"]
        request = SampleRequest.from_json(
            values["request"], text, assets or _find_assets(values["assets"], path.parent)
        )
        request = _with_map(request, values)
        if request.text_hash != values["grammar"]["sha256"]:
            raise AssetError(f"{path}: the grammar text does not match its hash; one of them was changed.")
        return Manifest(
            request=request,
            format=version,
            complete=values["complete"] is True,
            versions=dict(values["versions"]),
            models=tuple(values["models"]),
            files=dict(values["files"]),
            asset_files=dict(values["asset_files"]),
        )
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise AssetError(f"{path}: the manifest is damaged ({error!r}).") from error


def _with_map(request: SampleRequest, values: Mapping[str, Any]) -> SampleRequest:
    """A request with the place and the remarks of a manifest; earlier versions had neither."""
    place = values.get("place") or {}
    return replace(
        request,
        georeference=None if place.get("crs") is None else Georeference.from_json(place),
        remarks=tuple(Remark.from_json(remark) for remark in values.get("remarks", ())),
    )


@cache
def current_versions() -> dict[str, str]:
    """Versions of all software that may change a bit of the output."""
    libraries = {name: version(name) for name in _LIBRARIES}
    return {
        "grammarlab": __version__,
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        **libraries,
    }


def _drawing_versions(choice: RendererChoice) -> dict[str, str]:
    """Further inputs of a picture drawn by OpenGL."""
    return {name: version(name) for name in _GL_LIBRARIES} | {"opengl": choice.driver} if choice.name == "gl" else {}


def _describe_assets(assets: Path, folder: Path) -> str:
    """``shipped``, or the path of the asset folder, relative to the run's folder if possible."""
    if assets.resolve().is_relative_to(examples_folder().resolve()):
        return _SHIPPED
    try:
        return Path(os.path.relpath(assets.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive
        return assets.resolve().as_posix()


def _find_assets(description: str, folder: Path) -> Path:
    return examples_folder() / "assets" if description == _SHIPPED else folder / description
