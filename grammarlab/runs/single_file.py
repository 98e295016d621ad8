"""All models of a run in one file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from grammarlab.derivation.materials import Materials
from grammarlab.derivation.selection import moved_maps
from grammarlab.export import SaveOptions, save
from grammarlab.export.save import Reuse
from grammarlab.geometry.mesh import Meshes
from grammarlab.runs.batches import Batch
from grammarlab.runs.derivations import load_forest
from grammarlab.runs.records import batch_folder
from grammarlab.runs.request import Instancing, SampleRequest
from grammarlab.scene import Scene, realize

_REUSE: dict[Instancing, Reuse] = {"none": "merged", "nodes": "nodes", "gpu": "instancing"}


def save_options(request: SampleRequest) -> SaveOptions:
    """How the files of a run are written."""
    return SaveOptions(reuse=_REUSE[request.instancing], assets=request.assets, columns=request.columns or None)


def single_file_name(request: SampleRequest) -> str:
    """Name of the one file with all models."""
    return f"{request.name}.{request.file_format}"


def write_single_file(request: SampleRequest, folder: Path, batches: tuple[Batch, ...]) -> Path:
    """Write all models of finished batches into one file.

    They stand on a grid; with one model on each of several footprints, they stand where the footprints are.
    """
    scene = load_scene(folder, batches)
    if len(request.footprints) > 1 and request.num_models == 1:
        scene = replace(scene, num_models=1, model=np.zeros_like(scene.model))
    return save(scene, folder / single_file_name(request), request.file_format, save_options(request))


def load_scene(folder: Path, batches: tuple[Batch, ...]) -> Scene:
    """The scene of all models of finished batches, from their derivations on disk."""
    return join_scenes([realize(load_forest(batch_folder(folder, batch))) for batch in batches])


def join_scenes(scenes: list[Scene]) -> Scene:
    """All models of several scenes, in order; at least one scene."""
    first_model, first_mesh, first_material, first_frame, first_map = 0, 0, 0, 0, 0
    shifted, maps = [], []
    for scene in scenes:
        firsts = (first_model, first_mesh, first_material, first_frame)
        columns = (scene.model, scene.mesh, scene.material, scene.frame)
        shifted.append([column + first for column, first in zip(columns, firsts, strict=True)])
        first_model += scene.num_models
        first_mesh += len(scene.meshes)
        first_material += len(scene.materials)
        first_frame += len(scene.frames)
        maps.append(moved_maps(scene.texture_map, first_map))
        first_map += len(scene.texture_maps)
    model, mesh, material, frame = (np.concatenate(column).astype(np.int32) for column in zip(*shifted, strict=True))
    return Scene(
        first_model,
        Meshes.concatenate([scene.meshes for scene in scenes]),
        Materials(
            np.concatenate([scene.materials.channels for scene in scenes]),
            tuple(texture for scene in scenes for texture in scene.materials.textures),
        ),
        model,
        mesh,
        material,
        np.concatenate([scene.position for scene in scenes]),
        np.concatenate([scene.size for scene in scenes]),
        frame,
        np.concatenate([scene.frames for scene in scenes]),
        np.concatenate(maps),
        np.concatenate([scene.texture_maps for scene in scenes]),
    )
