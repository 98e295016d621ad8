"""Manifest of a run: request, versions, place on the earth and results, enough to make the same files again."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, get_args

from grammarlab.about import __version__
from grammarlab.asset_roots import AssetRoot, asset_root, library_of, own_folder
from grammarlab.derivation.forest import MissingAsset
from grammarlab.errors import AssetError
from grammarlab.export.save import HAVE_NODES
from grammarlab.files import read_bounded, write_text
from grammarlab.geometry.footprints.crs import label
from grammarlab.geometry.footprints.footprint import Georeference, Remark, RemarkKind
from grammarlab.rendering.choice import RendererChoice
from grammarlab.runs.sample.records import ModelRecord, has_own_origins
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.shipped import examples_folder
from grammarlab.runs.work.json_members import member, numbers, of_kind, texts

MANIFEST = "manifest.json"
FORMAT = 2
"""Version of the file. In version 1 a batch held the models of one footprint, never of several."""
MAX_FILE_BYTES = 1 << 30
"""Largest size of a manifest in bytes."""
_FIRST_FORMAT, BATCHES_OVER_FOOTPRINTS = 1, 2
"""The first version, and the first one in which a batch may have models of several footprints."""
_LIBRARIES = ("numpy", "scipy", "shapely", "trimesh", "mapbox_earcut", "pillow", "pyarrow", "lark")
_EMBREE = "embreex"
"""Library of ray tracing, not on every machine; without it, rays are traced by grammarlab itself."""
_GL_LIBRARIES = ("pyrender-maintained", "PyOpenGL")
_SHIPPED, _SHIPPED_SPECIES = "shipped", "shipped species"
_PLACES: Mapping[str, str] = {
    "glb": "a node 'origin'",
    "usd": "its prim 'World'",
    "usdz": "its prim 'World'",
    "obj": "a comment",
    "ply": "a comment",
    "stl": "its first 80 bytes",
    "3mf": "its description",
}
"""Where files name their own origin, by format."""


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


def place_in_words(request: SampleRequest) -> str:
    """One sentence about the origin of a run; empty if it is that of an unknown world."""
    if request.georeference is None and request.origin is None:
        return ""
    values = place_of(request)
    system = label(values["crs"] or "unknown CRS")
    if "longitude" in values:
        where = f"longitude {values['longitude']:.7f}, latitude {values['latitude']:.7f}"
        return f"origin: {where} ({system}); x is east of it and z south, in metres{_counting(request)}"
    if request.origin is None or has_own_origins(request):
        return f"coordinates: x is the easting and -z the northing ({system}){_counting(request)}"
    where = f"easting {values['easting']:.10g}, northing {values['northing']:.10g}"
    return f"origin: {where} ({system}){_counting(request)}"


def _counting(request: SampleRequest) -> str:
    """What the coordinates in files count from, to be added to a sentence; empty if it is the origin of the world."""
    if request.single_file and not request.is_in_place:
        return "; the file has its models on a grid instead"
    if request.origin is None and (request.single_file or request.pivot in ("world", "local")):
        return ""
    if not has_own_origins(request):
        return "; all files count from it"
    if request.file_format in HAVE_NODES:
        return f"; each file has its place in {_PLACES[request.file_format]}"
    return f"; each file counts from an origin of its own, which is in {_PLACES[request.file_format]}"


def place_of(request: SampleRequest) -> dict[str, Any]:
    """Where the origin of a run is: in world metres, and in its coordinate reference system.

    Returns:
        ``crs``, a name or None; ``origin``, x, y and z in world metres; and of that origin ``longitude`` and
        ``latitude`` in degrees, if the footprints were in degrees, otherwise ``easting`` and ``northing`` in metres.
    """
    x, y, z = request.origin or (0.0, 0.0, 0.0)
    georeference = request.georeference
    values: dict[str, Any] = {"crs": georeference.crs if georeference else None, "origin": [x, y, z]}
    if georeference is not None and georeference.longitude is not None:
        return values | {"longitude": georeference.longitude, "latitude": georeference.latitude}
    return values | {"easting": x, "northing": -z + 0.0}


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
    library = library_of(request.assets)
    values = {
        "format": FORMAT,
        "complete": files is not None,
        "grammar": {"name": request.name, "sha256": request.text_hash, "text": request.text},
        "request": request.as_json(),
        "place": place_of(request),
        "remarks": [asdict(remark) for remark in request.remarks],
        "assets": _describe_assets(own_folder(request.assets), folder),
        **({} if library is None else {"library": _relative(library, folder)}),
        "asset_files": dict(asset_files),
        "missing_assets": [asdict(asset) for asset in missing_assets],
        "versions": current_versions() | _drawing_versions(choice),
        "models": [asdict(model) for model in models],
        "files": dict(sorted((files or {}).items())),
    }
    path = folder / MANIFEST
    write_text(path, json.dumps(values, indent=1, ensure_ascii=False) + "\n")
    return path


@cache
def current_versions() -> dict[str, str]:
    """Versions of all software that may change a bit of the output."""
    libraries = {name: version(name) for name in _LIBRARIES}
    return {
        "grammarlab": __version__,
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        **libraries,
        **_embree_version(),
    }


def read_manifest(path: Path | str, assets: AssetRoot | None = None) -> Manifest:
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
    content = read_bounded(path, MAX_FILE_BYTES)
    try:
        return _parsed(json.loads(content), path.parent, assets)
    except (ValueError, RecursionError) as error:
        raise AssetError(f"{path}: the manifest is damaged: {error!r:.200}.") from error
    except AssetError as error:
        raise AssetError(f"{path}: {error}") from error


def _describe_assets(assets: Path, folder: Path) -> str:
    """A word for the assets of shipped examples, or the path of the folder, relative to the run's if possible."""
    shipped = examples_folder().resolve()
    if assets.resolve() == shipped / "species" / "assets":
        return _SHIPPED_SPECIES
    if assets.resolve().is_relative_to(shipped):
        return _SHIPPED
    return _relative(assets, folder)


def _relative(path: Path, folder: Path) -> str:
    """A path relative to a folder, if possible."""
    try:
        return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive
        return path.resolve().as_posix()


def _embree_version() -> dict[str, str]:
    try:
        return {_EMBREE: version(_EMBREE)}
    except PackageNotFoundError:
        return {}


def _drawing_versions(choice: RendererChoice) -> dict[str, str]:
    """Further inputs of a picture drawn by OpenGL."""
    return {name: version(name) for name in _GL_LIBRARIES} | {"opengl": choice.driver} if choice.name == "gl" else {}


def _parsed(values: Any, folder: Path, assets: AssetRoot | None) -> Manifest:
    """The manifest in a folder, from its JSON values.

    Raises:
        AssetError: If they are not those of a manifest; it does not name the file.
    """
    try:
        version = member(values, "format", int)
        text, digest = (member(values.get("grammar"), name, str, "grammar") for name in ("text", "sha256"))
        described = member(values, "request", dict)
        asset_folder = member(values, "assets", str)
        library = member(values, "library", str) if "library" in values else None
        complete = member(values, "complete", bool)
        versions, files, asset_files = (texts(values, name) for name in ("versions", "files", "asset_files"))
        models = tuple(of_kind(model, dict, "models") for model in member(values, "models", list))
    except AssetError as error:
        raise AssetError(f"the manifest is damaged: {error}") from error
    if version not in range(_FIRST_FORMAT, FORMAT + 1):
        raise AssetError(f"expected a manifest of format {FORMAT}, found format {version!r:.20}.")
    assets = assets or _find_assets(asset_folder, folder)
    if library is not None:
        assets = _with_library(assets, library, folder)
    request = SampleRequest.from_json(described, text, assets)
    if request.text_hash != digest:
        raise AssetError("the text of the models does not match its hash; one of them was changed.")
    return Manifest(
        request=replace(request, georeference=_georeference(values), remarks=_remarks(values)),
        format=version,
        complete=complete,
        versions=versions,
        models=models,
        files=files,
        asset_files=asset_files,
    )


def _with_library(assets: AssetRoot, library: str, folder: Path) -> AssetRoot:
    """The assets of a run that had a library, unless they have one themselves."""
    if "\0" in library:
        raise AssetError("the manifest is damaged: library: expected a path.")
    return asset_root(assets, folder / library) if isinstance(assets, Path) else assets


def _find_assets(description: str, folder: Path) -> Path:
    if "\0" in description:
        raise AssetError("the manifest is damaged: assets: expected a path.")
    shipped = {_SHIPPED: examples_folder() / "assets", _SHIPPED_SPECIES: examples_folder() / "species" / "assets"}
    return shipped.get(description, folder / description)


def _georeference(values: Mapping[str, Any]) -> Georeference | None:
    """Place on the earth of the footprints of a manifest; earlier versions had none."""
    entry = values.get("place")
    if entry is None or of_kind(entry, dict, "place").get("crs") is None:
        return None
    crs = member(entry, "crs", str, "place")
    if "longitude" not in entry:
        return Georeference(crs)
    longitude, latitude = numbers([entry["longitude"], entry.get("latitude")], 2, "place.longitude and latitude")
    return Georeference(crs, longitude, latitude)


def _remarks(values: Mapping[str, Any]) -> tuple[Remark, ...]:
    """Remarks of a manifest about its footprints; earlier versions had none."""
    where = "remarks"
    return tuple(
        Remark(member(entry, "source", str, where), _remark_kind(entry), member(entry, "reason", str, where))
        for entry in of_kind(values.get(where, []), list, where)
    )


def _remark_kind(entry: Any) -> RemarkKind:
    kind = member(entry, "kind", str, "remarks")
    for possible in get_args(RemarkKind):
        if kind == possible:
            return possible
    raise AssetError(f"remarks.kind: expected one of {', '.join(get_args(RemarkKind))}, found {kind[:40]!r}.")
