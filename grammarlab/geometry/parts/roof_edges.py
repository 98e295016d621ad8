"""Classification of roof edges: eaves, hips, valleys and ridges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.geometry.meshes.edges import Edges
from grammarlab.geometry.meshes.measure import face_normals
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.vectors import cross, dot, norm

NO_ROOF_EDGE, EAVE, HIP, VALLEY, RIDGE = range(5)
"""Kinds of roof edges; `NO_ROOF_EDGE` for the sloped borders of an open roof."""

LEVEL = 1e-6
"""Slope below which an edge is horizontal; also the share of a mesh's size below which heights are equal."""


def roof_edges(meshes: Meshes, table: Edges) -> NDArray[np.int8]:
    """[E] the kind of every edge, with y as the direction of up.

    An eave is a horizontal edge at the bottom, on the border or along a face that points down (the ceiling of a closed
    roof). A valley is an inside edge whose faces form a concavity, a hip another inside edge that touches an eave, a
    ridge any other inside edge.
    """
    normals = face_normals(meshes)
    start, end = meshes.points[table.start], meshes.points[table.end]
    along = end - start
    low, high = meshes.bounds()
    slack = LEVEL * (high - low).max(axis=1, initial=0.0)[table.mesh]
    at_bottom = np.maximum(start[:, 1], end[:, 1]) <= low[table.mesh, 1] + slack
    is_level = np.abs(along[:, 1]) <= LEVEL * norm(along)
    inside = ~table.is_boundary
    first = normals[table.faces[:, 0]]
    second = normals[table.faces[:, 1]]
    looks_down = np.minimum(first[:, 1], np.where(inside, second[:, 1], 0.0)) < -LEVEL
    eave = is_level & at_bottom & (table.is_boundary | looks_down)

    touches_eave = np.zeros(len(meshes.points), bool)
    touches_eave[table.start[eave]] = True
    touches_eave[table.end[eave]] = True
    concave = dot(cross(first, second), along) < -LEVEL * norm(along)
    near_eave = touches_eave[table.start] | touches_eave[table.end]
    kind = np.where(concave, VALLEY, np.where(near_eave, HIP, RIDGE))
    return np.where(eave, EAVE, np.where(inside, kind, NO_ROOF_EDGE)).astype(np.int8)
