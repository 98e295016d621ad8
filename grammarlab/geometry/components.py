"""Faces, edges and vertices of meshes as separate shapes, each in its own frame: CGA's ``comp``.

Frames follow CGA. Face: x along its first edge, z the outward normal, origin at its first corner. Edge: x along it, in
the opposite direction of its first face, z the mean normal of its faces (for an eave the normal of its slope), origin
at its start. Vertex: z the mean normal of its faces, x across it and the x axis of the mesh. y is z cross x.

Edges and vertices per face, ``comp(fe)`` and ``comp(fv)``: x runs along the outline in the direction of the face (for a
corner: half way between its two edges), y is the face's normal, z points out of the face in its plane.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, index_in_row, offsets_from_counts, row_of_value, take_rows
from grammarlab.geometry.meshes.edges import Edges, faces_at_boundary, in_rings
from grammarlab.geometry.meshes.edges import edges as edge_table
from grammarlab.geometry.meshes.measure import corner_edges, face_normals
from grammarlab.geometry.meshes.mesh import BORDER, INSIDE, Indices, Meshes
from grammarlab.geometry.meshes.ragged import distinct_keys, next_in_row
from grammarlab.geometry.meshes.vectors import any_normal, apply, apply_transposed, cross, dot, has_length, norm, unit

NO_ROOF_EDGE, EAVE, HIP, VALLEY, RIDGE = range(5)
"""Kinds of roof edges; `NO_ROOF_EDGE` for the sloped borders of an open roof."""
_LEVEL_SLOPE = 1e-6
"""Slope below which an edge is horizontal; also the share of a mesh's size below which heights are equal."""
_FLAT_SHARE = 1e-9
"""Largest extent of a component that counts as flat along an axis, as a share of its size."""


@dataclass(frozen=True, slots=True)
class ComponentMeshes:
    """K components, ordered by mesh.

    >>> from grammarlab.geometry.meshes.primitives import box
    >>> parts = faces(box())
    >>> parts.size[0].tolist(), parts.rotation[1, :, 2].tolist()
    ([1.0, 1.0, 0.0], [0.0, 1.0, 0.0])
    """

    mesh: Indices
    """[K] the mesh that contains it."""
    index: Indices
    """[K] its number within that mesh, from 0."""
    shapes: Meshes
    """K meshes in their own frames, points within 0..size. An edge is a face of two corners, a vertex one of one."""
    rotation: Floats
    """[K, 3, 3] columns are the x, y and z axis of the frame in the axes of the mesh."""
    origin: Floats
    """[K, 3] origin of the frame in the mesh: a point of the mesh is ``origin + rotation @ point``."""
    pivot: Floats
    """[K, 3] the first corner, in the mesh; differs from `origin` if the bounding box begins elsewhere."""
    size: Floats
    """[K, 3] extent along the frame's axes, in metres."""
    direction: Floats
    """[K, 3] the (mean) normal in the axes of the mesh, which selectors such as ``front`` classify."""
    is_border: NDArray[np.bool_]
    """[K] whether it is at the border of the mesh, for the selectors ``border`` and ``inside``."""
    roof_edge: NDArray[np.int8]
    """[K] `EAVE`, `HIP`, `VALLEY` or `RIDGE`; `NO_ROOF_EDGE` for other edges, faces and vertices."""

    def __len__(self) -> int:
        return len(self.mesh)

    def take(self, rows: NDArray[np.integer]) -> ComponentMeshes:
        """The components at these rows."""
        return ComponentMeshes(
            mesh=self.mesh[rows],
            index=self.index[rows],
            shapes=self.shapes.take(rows),
            rotation=self.rotation[rows],
            origin=self.origin[rows],
            pivot=self.pivot[rows],
            size=self.size[rows],
            direction=self.direction[rows],
            is_border=self.is_border[rows],
            roof_edge=self.roof_edge[rows],
        )


def faces(meshes: Meshes) -> ComponentMeshes:
    """Every face on its own."""
    count = meshes.num_faces
    of_mesh = meshes.mesh_of_face()
    is_border = faces_at_boundary(meshes, edge_table(meshes))
    is_border = np.where(meshes.roles == BORDER, True, np.where(meshes.roles == INSIDE, False, is_border))
    alone = face_sets(meshes, np.arange(count), np.ones(count, np.int64))
    index = index_in_row(np.diff(meshes.mesh_faces))
    return replace(alone, mesh=of_mesh, index=index, is_border=is_border)


def face_sets(meshes: Meshes, chosen: Indices, sizes: Indices) -> ComponentMeshes:
    """Several faces as one shape, in the frame of the first face: the operator ``=`` of ``comp``.

    Args:
        meshes: the meshes of the faces.
        chosen: [S] faces, set after set; those of one set belong to one mesh.
        sizes: [K] faces in each set, at least 1.

    Returns:
        One component per set; `index` is the face that gives the frame. Faces still share their points.
    """
    first = chosen[np.cumsum(sizes) - sizes]
    normals = face_normals(meshes)
    pivot = meshes.points[meshes.corner_points()[meshes.face_offsets[:-1][first]]]
    rotation = _frames(normals[first], _first_edges(meshes)[first])
    shapes = extract_faces(meshes, chosen, sizes)
    point_set = shapes.mesh_of_point()
    local = apply_transposed(rotation.take(point_set, axis=0), shapes.points - pivot.take(point_set, axis=0))
    shapes, low, size = _fitted(shapes.with_points(local, turn=rotation.swapaxes(1, 2)))
    mesh = meshes.mesh_of_face()[first]
    return ComponentMeshes(
        mesh=mesh,
        index=first - meshes.mesh_faces[:-1][mesh],
        shapes=shapes,
        rotation=rotation,
        origin=pivot + apply(rotation, low),
        pivot=pivot,
        size=size,
        direction=normals[first],
        is_border=np.zeros(len(sizes), bool),
        roof_edge=np.full(len(sizes), NO_ROOF_EDGE, np.int8),
    )


def edges(meshes: Meshes) -> ComponentMeshes:
    """Every undirected edge once, in the order of a walk around all faces."""
    table = edge_table(meshes)
    normals = face_normals(meshes)
    first = normals[table.faces[:, 0]]
    second = np.where((table.faces[:, 1] >= 0)[:, None], normals[table.faces[:, 1]], 0.0)
    mean = unit(first + second)
    # Opposite faces have no mean normal: the first one decides.
    mean = np.where(has_length(mean), mean, first)
    kind = _roof_edges(meshes, table)
    is_eave = kind == EAVE
    # The slope, not the ceiling below it, gives an eave its axes.
    turns = is_eave & (second[:, 1] > first[:, 1])
    mean[is_eave] = np.where(turns[:, None], second, first)[is_eave]
    start = meshes.points[np.where(turns, table.start, table.end)]
    along = meshes.points[np.where(turns, table.end, table.start)] - start
    rotation = _frames_along(unit(along), mean)
    shapes, size = _segments(norm(along))
    return ComponentMeshes(
        mesh=table.mesh,
        index=index_in_row(np.bincount(table.mesh, minlength=len(meshes))),
        shapes=shapes,
        rotation=rotation,
        origin=start,
        pivot=start,
        size=size,
        direction=mean,
        is_border=table.is_boundary,
        roof_edge=kind,
    )


def vertices(meshes: Meshes) -> ComponentMeshes:
    """Every point that a face uses, in the order of the points."""
    table = edge_table(meshes)
    num_points = len(meshes.points)
    rows = meshes.corner_points()
    used = np.flatnonzero(np.bincount(rows, minlength=num_points))
    normals = face_normals(meshes)[meshes.face_of_corner()]
    sums = np.empty((num_points, 3))
    for axis in range(3):
        sums[:, axis] = np.bincount(rows, normals[:, axis], num_points)
    mean = unit(sums[used])
    mesh = meshes.mesh_of_point()[used]
    count = len(used)
    return ComponentMeshes(
        mesh=mesh,
        index=index_in_row(np.bincount(mesh, minlength=len(meshes))),
        shapes=Meshes.from_polygons(np.zeros((count, 3)), np.ones(count, np.int64)),
        rotation=_frames(mean, cross(mean, np.broadcast_to([1.0, 0.0, 0.0], mean.shape))),
        origin=meshes.points[used],
        pivot=meshes.points[used],
        size=np.zeros((count, 3)),
        direction=mean,
        is_border=_border_points(meshes, table)[used],
        roof_edge=np.full(count, NO_ROOF_EDGE, np.int8),
    )


def face_edges(meshes: Meshes) -> ComponentMeshes:
    """Every edge of every face, in the order of their first corners, those of holes last; shared edges once per face.

    Bridges between an outline and its hole are left out.
    """
    table = edge_table(meshes)
    rows, _ = in_rings(meshes, table.edge_of_corner)
    start, along, normals = _around_faces(meshes)
    along, normals, start = along.take(rows, axis=0), normals.take(rows, axis=0), start.take(rows, axis=0)
    parts, size = _segments(norm(along))
    boundary = table.is_boundary[table.edge_of_corner[rows]]
    return _beside_faces(meshes, rows, parts, along, normals, start, size, boundary)


def face_vertices(meshes: Meshes) -> ComponentMeshes:
    """Every corner of every face, in their order."""
    table = edge_table(meshes)
    start, along, normals = _around_faces(meshes)
    count = len(start)
    direction = unit(along)
    following = next_in_row(meshes.face_offsets)
    arriving = np.empty_like(direction)
    arriving[following] = direction
    tangent = unit(direction + arriving)
    # An outline that turns straight back has no tangent: the leaving edge decides.
    tangent = np.where(has_length(tangent), tangent, direction)
    parts = Meshes.from_polygons(np.zeros((count, 3)), np.ones(count, np.int64))
    border = _border_points(meshes, table)[meshes.corner_points()]
    return _beside_faces(meshes, np.arange(count), parts, tangent, normals, start, np.zeros((count, 3)), border)


def extract_faces(meshes: Meshes, chosen: Indices, sizes: Indices) -> Meshes:
    """One mesh from each set of faces, with the points that its faces use."""
    corner_index, face_offsets = take_rows(meshes.face_offsets, chosen)
    rows = meshes.corner_points()[corner_index]
    corner_set = np.repeat(row_of_value(sizes), np.diff(face_offsets))
    where, corners = distinct_keys(corner_set * max(len(meshes.points), 1) + rows)
    point_set = corner_set[where]
    mesh_points = offsets_from_counts(np.bincount(point_set, minlength=len(sizes)))
    return Meshes(
        points=meshes.points.take(rows[where], axis=0),
        corners=corners - mesh_points[corner_set],
        face_offsets=face_offsets,
        mesh_faces=offsets_from_counts(sizes),
        mesh_points=mesh_points,
        tags=meshes.tags[chosen],
        data=None if meshes.data is None else meshes.data.take(corner_index, chosen),
    )


def unaligned(components: ComponentMeshes) -> ComponentMeshes:
    """The same components in the axes of their meshes, with the scopes fitted to them: CGA's ``noAlign``."""
    owner = components.shapes.mesh_of_point()
    turned = apply(components.rotation.take(owner, axis=0), components.shapes.points)
    points = turned + components.origin.take(owner, axis=0)
    shapes, low, size = _fitted(components.shapes.with_points(points, turn=components.rotation))
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
    merged = Meshes.from_polygons(local[shapes.corner_points()], counts, faces).with_data(parts.shapes.data)
    fitting, low, size = _fitted(merged.with_points(merged.points, turn=rotation[first].swapaxes(1, 2)))
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
    has_two_faces = (first >= 0) & (second >= 0)
    graph = coo_array(
        (np.ones(has_two_faces.sum()), (first[has_two_faces], second[has_two_faces])), shape=(len(chosen), len(chosen))
    )
    label = connected_components(graph, directed=False)[1].astype(np.int64)
    leader = np.full(len(chosen), len(chosen), np.int64)
    np.minimum.at(leader, label, np.arange(len(chosen)))
    order = np.argsort(leader[label], kind="stable")
    return chosen[order], np.unique(leader[label], return_counts=True)[1]


def upwards(components: ComponentMeshes) -> ComponentMeshes:
    """Edges with descending ones reversed, as CGA orients ridges, hips and valleys."""
    descends = components.rotation[:, 1, 0] < -_LEVEL_SLOPE
    turned = components.rotation * np.where(descends[:, None, None], [-1.0, -1.0, 1.0], 1.0)
    far = components.pivot + components.rotation[:, :, 0] * components.size[:, :1]
    start = np.where(descends[:, None], far, components.pivot)
    return replace(components, rotation=turned, origin=start, pivot=start)


def _frames(z: Floats, x: Floats) -> Floats:
    """[K, 3, 3] frames with the given z axis (unit or zero) and x as near as possible to the given direction."""
    z = np.where(has_length(z), z, any_normal(x))
    across = unit(x - z * dot(x, z)[:, None])
    across = np.where(has_length(across), across, any_normal(z))
    return np.stack((across, cross(z, across), z), axis=2)


def _first_edges(meshes: Meshes) -> Floats:
    """[F, 3] the first edge of each face that has a length; zero where there is none."""
    along = corner_edges(meshes)
    face = meshes.face_of_corner()
    has_length = np.flatnonzero(along.any(axis=1))
    result = np.zeros((meshes.num_faces, 3))
    # Written in reverse order, so that the first edge of a face is kept.
    result[face[has_length[::-1]]] = along[has_length[::-1]]
    return result


def _fitted(meshes: Meshes) -> tuple[Meshes, Floats, Floats]:
    """Meshes moved so that their bounding boxes begin at zero, and their previous low corners and sizes [K, 3].

    Extents that are only rounding errors become exactly zero.
    """
    low, high = meshes.bounds()
    size = high - low
    flat = size <= _FLAT_SHARE * size.max(axis=1, keepdims=True, initial=0.0)
    mesh = meshes.mesh_of_point()
    points = np.where(flat.take(mesh, axis=0), 0.0, meshes.points - low.take(mesh, axis=0))
    return meshes.with_points(points), np.where(flat, 0.5 * (low + high), low), np.where(flat, 0.0, size)


def _frames_along(x: Floats, z: Floats) -> Floats:
    """[K, 3, 3] frames with the given x axis (unit or zero) and z as near as possible to the given direction."""
    turned = _frames(x, z)
    # The roles are swapped there: its z is x here, and its x is z here.
    return np.stack((turned[:, :, 2], -turned[:, :, 1], turned[:, :, 0]), axis=2)


def _roof_edges(meshes: Meshes, table: Edges) -> NDArray[np.int8]:
    """[E] the kind of every edge, with y as the direction of up.

    An eave is a horizontal edge at the bottom, on the border or along a face that points down (the ceiling of a closed
    roof). A valley is an inside edge whose faces form a concavity, a hip another inside edge that touches an eave, a
    ridge any other inside edge.
    """
    normals = face_normals(meshes)
    start, end = meshes.points[table.start], meshes.points[table.end]
    along = end - start
    low, high = meshes.bounds()
    slack = _LEVEL_SLOPE * (high - low).max(axis=1, initial=0.0)[table.mesh]
    at_bottom = np.maximum(start[:, 1], end[:, 1]) <= low[table.mesh, 1] + slack
    is_level = np.abs(along[:, 1]) <= _LEVEL_SLOPE * norm(along)
    inside = ~table.is_boundary
    first = normals[table.faces[:, 0]]
    second = normals[table.faces[:, 1]]
    looks_down = np.minimum(first[:, 1], np.where(inside, second[:, 1], 0.0)) < -_LEVEL_SLOPE
    # A gable stands on its edge, which is not an eave.
    is_slope = np.maximum(first[:, 1], np.where(inside, second[:, 1], 0.0)) > _LEVEL_SLOPE
    eave = is_level & at_bottom & (table.is_boundary | looks_down) & is_slope

    touches_eave = np.zeros(len(meshes.points), bool)
    touches_eave[table.start[eave]] = True
    touches_eave[table.end[eave]] = True
    concave = dot(cross(first, second), along) < -_LEVEL_SLOPE * norm(along)
    near_eave = touches_eave[table.start] | touches_eave[table.end]
    kind = np.where(concave, VALLEY, np.where(near_eave, HIP, RIDGE))
    return np.where(eave, EAVE, np.where(inside, kind, NO_ROOF_EDGE)).astype(np.int8)


def _segments(length: Floats) -> tuple[Meshes, Floats]:
    """Edges along x of lengths [K] as faces of two corners, and their sizes [K, 3]."""
    points = np.zeros((2 * len(length), 3))
    points[1::2, 0] = length
    size = np.zeros((len(length), 3))
    size[:, 0] = length
    return Meshes.from_polygons(points, np.full(len(length), 2)), size


def _border_points(meshes: Meshes, table: Edges) -> NDArray[np.bool_]:
    """[P] whether points are ends of edges at the border of their mesh."""
    at_border = np.zeros(len(meshes.points), bool)
    at_border[table.start[table.is_boundary]] = True
    at_border[table.end[table.is_boundary]] = True
    return at_border


def _around_faces(meshes: Meshes) -> tuple[Floats, Floats, Floats]:
    """[C, 3] each corner, the edge that leaves it, and the normal of its face."""
    normals = face_normals(meshes).take(meshes.face_of_corner(), axis=0)
    return meshes.points.take(meshes.corner_points(), axis=0), corner_edges(meshes), normals


def _beside_faces(
    meshes: Meshes,
    corners: Indices,
    parts: Meshes,
    x: Floats,
    y: Floats,
    start: Floats,
    size: Floats,
    is_border: NDArray[np.bool_],
) -> ComponentMeshes:
    """Components at corners [K] of faces: x along the outline, y the face's normal, z out of the face."""
    across = _frames(y, x)
    rotation = np.stack((across[:, :, 0], across[:, :, 2], -across[:, :, 1]), axis=2)
    mesh = meshes.mesh_of_face()[meshes.face_of_corner()[corners]]
    return ComponentMeshes(
        mesh=mesh,
        index=index_in_row(np.bincount(mesh, minlength=len(meshes))),
        shapes=parts,
        rotation=rotation,
        origin=start,
        pivot=start,
        size=size,
        direction=rotation[:, :, 2],
        is_border=is_border,
        roof_edge=np.full(len(corners), NO_ROOF_EDGE, np.int8),
    )
