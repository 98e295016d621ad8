"""Scenes to files: all models in one, or each in its own."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.export.files import write_whole
from grammarlab.export.glb import merged_glb
from grammarlab.export.glb_reuse import reused_glb
from grammarlab.export.obj import obj_files
from grammarlab.export.ply import ply_bytes
from grammarlab.scene import Scene, TriangleBatch, triangles
from grammarlab.scene.checks import require_proper
from grammarlab.scene.instances import only
from grammarlab.scene.layout import grid

Format = Literal["glb", "obj", "ply"]
Reuse = Literal["merged", "nodes", "instancing"]
FORMATS: tuple[str, ...] = get_args(Format)
REUSES: tuple[str, ...] = get_args(Reuse)


@dataclass(frozen=True, slots=True)
class SaveOptions:
    """How files are written."""

    reuse: Reuse = "merged"
    """For GLB: one primitive a material (``merged``, the fastest to draw), one node a shape that refers to shared
    meshes (``nodes``, the easiest to edit), or ``instancing`` with EXT_mesh_gpu_instancing (the smallest; readers
    that do not know the extension refuse the file)."""
    assets: Path | None = None
    """Folder that textures are relative to; None leaves textures out."""
    columns: int | None = None
    """Models side by side when several share a file; about a square when None."""

    def __post_init__(self) -> None:
        if self.reuse not in REUSES:
            raise UsageError(f"unknown way of reuse {self.reuse!r}; choose one of {', '.join(REUSES)}")
        if self.columns is not None and self.columns < 1:
            raise UsageError(f"columns is {self.columns}; expected at least 1")


def save(
    scene: Scene, path: str | os.PathLike[str], file_format: Format | None = None, options: SaveOptions | None = None
) -> Path:
    """Write all models of a scene into one file; several models stand on a grid.

    Args:
        scene: at least one model.
        path: the file; an OBJ puts its MTL and images beside it.
        file_format: ``glb``, ``obj`` or ``ply``; by the ending of `path` when left out.
        options: see `SaveOptions`.

    Returns:
        The path of the file, which exists only when it is complete.

    Raises:
        UsageError: an unknown format, or a place that cannot be written to.
        DerivationError: a scene with coordinates that are not finite.
        AssetError: a texture outside the asset folder, or broken.
    """
    target = Path(path)
    options = options or SaveOptions()
    chosen = _checked_format(file_format or target.suffix.lstrip(".").lower())
    batch = triangles(scene)
    require_proper(scene)
    names = [target.stem] if scene.num_models == 1 else [f"model_{i}" for i in range(scene.num_models)]
    _write(target, chosen, scene, batch, names, grid(batch, options.columns), options)
    return target


def save_each(
    scene: Scene,
    folder: str | os.PathLike[str],
    file_format: Format = "glb",
    options: SaveOptions | None = None,
    name: Callable[[int], str] = "model_{:05d}".format,
    first_model: int = 0,
    on_saved: Callable[[int], None] | None = None,
) -> tuple[Path, ...]:
    """Write each model of a scene into its own file.

    Args:
        scene: any number of models.
        folder: made when it does not exist.
        file_format: ``glb``, ``obj`` or ``ply``.
        options: see `SaveOptions`.
        name: file name without ending from the number of a model.
        first_model: number of the first model.
        on_saved: called with the number of each model when its file is complete.

    Returns:
        The files in order. When interrupted, all files that exist are complete.

    Raises:
        As `save`.
    """
    options = options or SaveOptions()
    chosen = _checked_format(file_format)
    batch = triangles(scene)
    require_proper(scene)
    in_place = np.zeros((1, 3))
    paths = []
    for index in range(scene.num_models):
        stem = name(first_model + index)
        target = Path(folder) / f"{stem}.{chosen}"
        model_scene = scene if options.reuse == "merged" else only(scene, index)
        _write(target, chosen, model_scene, batch.model(index), [stem], in_place, options)
        paths.append(target)
        if on_saved is not None:
            on_saved(first_model + index)
    return tuple(paths)


def _checked_format(file_format: str) -> str:
    if file_format not in FORMATS:
        raise UsageError(f"unknown file format {file_format!r}; choose one of {', '.join(FORMATS)}")
    return file_format


def _write(
    target: Path,
    file_format: str,
    scene: Scene,
    batch: TriangleBatch,
    names: list[str],
    offsets: NDArray[np.float64],
    options: SaveOptions,
) -> None:
    if file_format == "ply":
        write_whole(target, ply_bytes(batch, offsets))
    elif file_format == "obj":
        files = obj_files(batch, names, offsets, target.stem, options.assets)
        # The geometry comes last and refers to the others: while it is missing, nothing points to a missing file.
        for file_name, content in files.items():
            write_whole(target if file_name == f"{target.stem}.obj" else target.with_name(file_name), content)
    elif options.reuse == "merged":
        write_whole(target, merged_glb(batch, names, offsets, options.assets))
    else:
        write_whole(target, reused_glb(scene, names, offsets, options.assets, options.reuse == "instancing"))
