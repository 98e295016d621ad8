"""Operations on selected components: reversing, grouping, and keeping the axes of their meshes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.geometry.meshes.edges import edges as edge_table
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.vectors import apply, apply_transposed
from grammarlab.geometry.parts.components import ComponentMeshes, fitted


def unaligned(components: ComponentMeshes) -> ComponentMeshes:
    """The same components in the axes of their meshes, with the scopes fitted to them: CGA's ``noAlign``."""
    owner = components.shapes.mesh_of_point()
    turned = apply(components.rotation.take(owner, axis=0), components.shapes.points)
    points = turned + components.origin.take(owner, axis=0)
    shapes, low, size = fitted(components.shapes.with_points(points))
    rotation = np.broadcast_to(np.eye(3), components.rotation.shape)
    return replace(components, shapes=shapes, rotation=rotation, origin=low, pivot=low, size=size)


def joined(components: ComponentMeshes, sizes: Indices) -> ComponentMeshes:
    """Components merged by sets, each set in the frame of its first component.

    Args:
        components: K components, those of a set one after the other and of one mesh.
        sizes: [S] components in each set, at least 1.
    """
    parts = unaligned(components)
    first = np.cumsum(sizes) - sizes
    leader = np.repeat(first, sizes)[parts.shapes.mesh_of_point()]
    absolute = parts.shapes.points + parts.origin.take(parts.shapes.mesh_of_point(), axis=0)
    pivot, rotation = components.pivot, components.rotation
    local = apply_transposed(rotation.take(leader, axis=0), absolute - pivot.take(leader, axis=0))
    shapes = components.shapes
    counts = np.diff(shapes.face_offsets)
    faces = np.add.reduceat(np.diff(shapes.mesh_faces), first)
    merged = Meshes.from_polygons(local[shapes.corner_points()], counts, faces)
    fitting, low, size = fitted(merged)
    chosen = components.take(first)
    return replace(chosen, shapes=fitting, origin=chosen.pivot + apply(chosen.rotation, low), size=size)


def connected_faces(meshes: Meshes, chosen: Indices) -> tuple[Indices, Indices]:
    """Faces grouped into connected sets by shared edges.

    Args:
        meshes: the meshes of the faces.
        chosen: [S] faces, ascending.

    Returns:
        The faces, set after set, sets in the order of their first faces; and the number of faces in each set.
    """
    from scipy.sparse import coo_array  # noqa: PLC0415
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    table = edge_table(meshes)
    rank = np.full(meshes.num_faces, -1, np.int64)
    rank[chosen] = np.arange(len(chosen))
    pairs = table.faces[(table.faces >= 0).all(axis=1)]
    first, second = rank[pairs[:, 0]], rank[pairs[:, 1]]
    both = (first >= 0) & (second >= 0)
    graph = coo_array((np.ones(both.sum()), (first[both], second[both])), shape=(len(chosen), len(chosen)))
    label = connected_components(graph, directed=False)[1].astype(np.int64)
    leader = np.full(len(chosen), len(chosen), np.int64)
    np.minimum.at(leader, label, np.arange(len(chosen)))
    order = np.argsort(leader[label], kind="stable")
    return chosen[order], np.unique(leader[label], return_counts=True)[1]


def upwards(components: ComponentMeshes) -> ComponentMeshes:
    """Edges with descending ones reversed, as CGA orients ridges, hips and valleys."""
    descends = components.rotation[:, 1, 0] < 0.0
    turned = components.rotation * np.where(descends[:, None, None], [-1.0, -1.0, 1.0], 1.0)
    far = components.pivot + components.rotation[:, :, 0] * components.size[:, :1]
    start = np.where(descends[:, None], far, components.pivot)
    return replace(components, rotation=turned, origin=start, pivot=start)
