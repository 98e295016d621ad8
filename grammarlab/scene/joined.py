"""Models of several scenes in one scene, and some models of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import take_rows
from grammarlab.derivation.materials import Materials
from grammarlab.errors import UsageError
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instances import Scene, chosen
from grammarlab.scene.shape_labels import joined_labels


def of_models(scene: Scene, models: NDArray[np.integer]) -> Scene:
    """The models at these rows, in this order, with the tables of the scene.

    Args:
        scene: the scene.
        models: [k] numbers of models; repeats are allowed.
    """
    ends = np.searchsorted(scene.model, np.arange(scene.num_models + 1))
    rows, offsets = take_rows(ends, models)
    return replace(
        chosen(scene, rows),
        num_models=len(models),
        model=np.repeat(np.arange(len(models), dtype=np.int32), np.diff(offsets)),
        origins=scene.origins[models],
        labels=None if scene.labels is None else scene.labels.take(rows).of_models(models),
    )


def joined(scenes: Sequence[Scene]) -> Scene:
    """The models of all scenes, in order.

    Args:
        scenes: at least one scene; none has normals of its own (`Scene.surface`).

    Raises:
        UsageError: If there is no scene, or one has normals of its own.
    """
    if not scenes or any(scene.surface is not None for scene in scenes):
        raise UsageError("expected one scene or more of meshes whose normals follow from their faces")
    if len(scenes) == 1:
        return scenes[0]
    model, mesh, material, frame, texture_map = (
        np.concatenate([[0], np.cumsum(sizes)])
        for sizes in zip(
            *((s.num_models, len(s.meshes), len(s.materials), len(s.frames), len(s.texture_maps)) for s in scenes),
            strict=True,
        )
    )
    parts = range(len(scenes))
    return Scene(
        num_models=int(model[-1]),
        meshes=Meshes.concatenate([scene.meshes for scene in scenes]),
        materials=joined_materials([scene.materials for scene in scenes]),
        model=_shifted([scene.model for scene in scenes], model),
        mesh=_shifted([scene.mesh for scene in scenes], mesh),
        material=_shifted([scene.material for scene in scenes], material),
        position=np.concatenate([scene.position for scene in scenes]),
        size=np.concatenate([scene.size for scene in scenes]),
        frame=_shifted([scene.frame for scene in scenes], frame),
        frames=np.concatenate([scene.frames for scene in scenes]),
        texture_map=np.concatenate(
            [np.where(scenes[part].texture_map < 0, -1, scenes[part].texture_map + texture_map[part]) for part in parts]
        ).astype(np.int32),
        texture_maps=np.concatenate([scene.texture_maps for scene in scenes]),
        origins=np.concatenate([scene.origins for scene in scenes]),
        labels=joined_labels([scene.labels for scene in scenes]),
    )


def united(scene: Scene, other: Scene) -> tuple[Scene, NDArray[np.intp]]:
    """Models of two scenes with the instances of both.

    Args:
        scene: B models.
        other: more instances of the same B models, from the same origins.

    Returns:
        The B models, and [I] the row of each of its instances among those of the first scene, then of the other.

    Raises:
        UsageError: If the scenes have different numbers of models, or one has normals of its own.
    """
    if scene.num_models != other.num_models:
        raise UsageError(f"expected two scenes of the same models, found {scene.num_models} and {other.num_models}")
    both = joined([scene, other])
    model = both.model % scene.num_models
    order = np.argsort(model, kind="stable")
    return replace(chosen(both, order), num_models=scene.num_models, model=model[order], origins=scene.origins), order


def _shifted(columns: Sequence[NDArray[np.int32]], starts: NDArray[np.int64]) -> NDArray[np.int32]:
    return np.concatenate([column + start for column, start in zip(columns, starts[:-1], strict=True)]).astype(np.int32)


def joined_materials(tables: Sequence[Materials]) -> Materials:
    """The materials of all tables, in order."""
    starts = np.cumsum([0, *(len(table) for table in tables)]).tolist()
    return Materials(
        np.concatenate([table.channels for table in tables]),
        tuple(texture for table in tables for texture in table.textures),
        {name: picture for table in tables for name, picture in table.pictures.items()},
        frozenset().union(*(table.cut_out for table in tables)),
        frozenset(row + start for table, start in zip(tables, starts, strict=False) for row in table.thin),
    )
