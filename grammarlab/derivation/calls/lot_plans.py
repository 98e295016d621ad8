"""Plans of lots: the edges of initial shapes, and where they are along streets."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import offsets_from_counts, take_rows
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.state.mesh_table import scaled
from grammarlab.derivation.state.shapes import Value
from grammarlab.derivation.state.street_outlines import OUTLINE, PLAN, StreetOutlines
from grammarlab.derivation.state.texture_maps import NONE
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.geometry.edges_behind import EdgeSets
from grammarlab.geometry.lot_sides import NO_SIDE, edge_sides, front_normals
from grammarlab.geometry.meshes.ragged import next_in_row, sum_rows


def streets_of_lots(lots: Lots, workspace: Workspace) -> StreetOutlines | None:
    """Edges of lots in the axes of their initial shapes; None if nothing is known of the streets of any."""
    widths = lots.footprints.street_width
    if widths is None or len(lots) == 0:
        return None
    lot, model, model_lot = np.unique(lots.footprint, return_index=True, return_inverse=True)
    is_known = ~np.isnan(widths[lots.footprints.offsets[:-1][lot]])
    if not is_known.any():
        return None
    roots = workspace.roots
    meshes = scaled(workspace.meshes.take(roots.mesh[model]), roots.size[model])
    corners, offsets = meshes.points[meshes.corner_points()][:, [0, 2]], meshes.face_offsets
    width = widths[take_rows(lots.footprints.offsets, lot)[0]]
    sides = edge_sides(corners, offsets, width)
    edges = np.flatnonzero(sides != NO_SIDE)
    num_edges = sum_rows((sides != NO_SIDE).astype(np.int64), offsets)
    return StreetOutlines(
        EdgeSets(corners[edges], corners[next_in_row(offsets)[edges]], sides[edges], offsets_from_counts(num_edges)),
        front=front_normals(corners, offsets, width),
        extent=roots.size[model].max(axis=1),
        model_lot=model_lot.astype(np.int32),
        is_known=is_known,
    )


def initial_plans(workspace: Workspace) -> dict[str, Value]:
    """Entries of `Shapes.state` of the initial shapes: their maps to the plans of their lots, and their edges.

    The plan of a lot has x and z of the initial shape's scope, in metres from its origin.
    """
    streets, roots = workspace.streets, workspace.roots
    if streets is None:
        return {}
    axes = np.swapaxes(workspace.frames.rotations(roots.frame), 1, 2)[:, [0, 2]]
    start = -np.einsum("nai,ni->na", axes, roots.position)
    maps = np.concatenate([axes, start[:, :, None]], axis=2)
    ids = workspace.texture_maps.add(maps, np.ones(roots.num, dtype=bool))
    is_known = streets.known(roots)
    return {
        PLAN: np.where(is_known, ids, np.int32(NONE)),
        OUTLINE: np.where(is_known, streets.model_lot, np.int32(NONE)),
    }
