"""Selection of models of a forest, and concatenation of forests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags
from grammarlab.derivation.forest import Draws, Forest, Leaves, Nodes, Reports, by_path, by_place
from grammarlab.derivation.lots import Lots, Values
from grammarlab.derivation.materials import Materials
from grammarlab.errors import UsageError
from grammarlab.geometry.meshes.mesh import Meshes

_R = TypeVar("_R", Nodes, Leaves, Draws, Reports)


def select_models(forest: Forest, models: NDArray[np.integer]) -> Forest:
    """Forest of selected models, renumbered from 0 in the same order; each keeps its lot.

    Args:
        forest: the models.
        models: [K] models to keep, ascending, without repeats.
    """
    new_model = np.full(forest.num_models, -1, dtype=np.int32)
    new_model[models] = np.arange(len(models), dtype=np.int32)
    is_selected = new_model[forest.nodes.model] >= 0
    new_node = (np.cumsum(is_selected) - 1).astype(np.int32)
    nodes = _rows(forest.nodes, is_selected)
    parent = np.where(nodes.parent >= 0, new_node[nodes.parent], -1).astype(np.int32)
    leaves, draws = (
        _rows(forest.leaves, is_selected[forest.leaves.node]),
        _rows(forest.draws, is_selected[forest.draws.node]),
    )
    reports = _rows(forest.reports, is_selected[forest.reports.node])
    return replace(
        forest,
        lots=forest.lots.take(models),
        nodes=replace(nodes, model=new_model[nodes.model], parent=parent),
        leaves=replace(leaves, node=new_node[leaves.node]),
        draws=replace(draws, node=new_node[draws.node]),
        reports=replace(reports, node=new_node[reports.node]),
        attributes={name: values[models] for name, values in forest.attributes.items()},
    )


def join_forests(forests: Sequence[Forest]) -> Forest:
    """Models of several forests of one grammar as one forest, in this order.

    Raises:
        UsageError: If there are no forests, or forests of different grammars.
    """
    if not forests:
        raise UsageError("expected at least one forest to join")
    first = forests[0]
    if len(forests) == 1:
        return first
    for other in forests[1:]:
        if (other.symbols, other.rules, other.sites) != (first.symbols, first.rules, first.sites):
            raise UsageError("expected forests of one grammar: their symbols, rules or random expressions differ")
    models = _starts([forest.num_models for forest in forests])
    nodes = _starts([len(forest.nodes) for forest in forests])
    frames = _starts([len(forest.frames) for forest in forests])
    meshes = _starts([len(forest.meshes) for forest in forests])
    materials = _starts([len(forest.materials) for forest in forests])
    maps = _starts([len(forest.texture_maps) for forest in forests])
    keys = list(dict.fromkeys(key for forest in forests for key in forest.reports.keys))
    return replace(
        first,
        lots=Lots.concatenate([forest.lots for forest in forests]),
        nodes=_joined([_moved_nodes(f.nodes, *starts) for f, *starts in zip(forests, models, nodes, strict=True)]),
        leaves=_joined(
            [
                replace(
                    f.leaves,
                    node=f.leaves.node + node,
                    frame=f.leaves.frame + frame,
                    mesh=f.leaves.mesh + mesh,
                    material=f.leaves.material + material,
                    texture_map=_moved_maps(f.leaves.texture_map, first_map),
                )
                for f, node, frame, mesh, material, first_map in zip(
                    forests, nodes, frames, meshes, materials, maps, strict=True
                )
            ]
        ),
        draws=_joined([replace(f.draws, node=f.draws.node + node) for f, node in zip(forests, nodes, strict=True)]),
        reports=_joined([_moved_reports(f.reports, node, keys) for f, node in zip(forests, nodes, strict=True)]),
        frames=np.concatenate([forest.frames for forest in forests]),
        meshes=Meshes.concatenate([forest.meshes for forest in forests]),
        materials=Materials(
            np.concatenate([forest.materials.channels for forest in forests]),
            tuple(texture for forest in forests for texture in forest.materials.textures),
            cut_out=frozenset().union(*(forest.materials.cut_out for forest in forests)),
        ),
        texture_maps=np.concatenate([forest.texture_maps for forest in forests]),
        prints=tuple(text for forest in forests for text in forest.prints),
        missing_assets=by_path(asset for forest in forests for asset in forest.missing_assets),
        attributes=_joined_attributes([forest.attributes for forest in forests if forest.num_models]),
        warnings=by_place(finding for forest in forests for finding in forest.warnings),
    )


def _joined_attributes(columns: Sequence[Mapping[str, Values]]) -> dict[str, Values]:
    """The attributes that all forests have, with the values of all models."""
    names = [name for name in (columns[0] if columns else ()) if all(name in each for each in columns)]
    return {name: np.concatenate([each[name] for each in columns]) for name in names}


def _moved_maps(texture_map: NDArray[np.int32], first: np.integer | int) -> NDArray[np.int32]:
    """A column of `Leaves.texture_map` after its maps moved to a later place in a table of maps."""
    return np.where(texture_map >= 0, texture_map + np.int32(first), texture_map)


def _rows(columns: _R, is_selected: Flags) -> _R:
    """The kept rows of a table."""
    selected = {
        name: value[is_selected]
        for name in columns.__slots__
        if isinstance(value := getattr(columns, name), np.ndarray)
    }
    return replace(columns, **selected)


def _joined(tables: Sequence[_R]) -> _R:
    """The rows of several tables."""
    first = tables[0]
    columns = {
        name: np.concatenate([getattr(table, name) for table in tables])
        for name in first.__slots__
        if isinstance(getattr(first, name), np.ndarray)
    }
    return replace(first, **columns)


def _moved_nodes(nodes: Nodes, model: np.int32, node: np.int32) -> Nodes:
    parent = np.where(nodes.parent >= 0, nodes.parent + node, -1).astype(np.int32)
    return replace(nodes, model=nodes.model + model, parent=parent)


def _moved_reports(reports: Reports, node: np.int32, keys: Sequence[str]) -> Reports:
    number = np.array([*(keys.index(key) for key in reports.keys), -1], dtype=np.int32)
    return replace(reports, node=reports.node + node, key=number[reports.key], keys=tuple(keys))


def _starts(counts: Sequence[int]) -> NDArray[np.int32]:
    return np.cumsum([0, *counts[:-1]], dtype=np.int32)
