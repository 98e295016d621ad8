"""Random solids for the laws of mesh operations."""

import numpy as np
from hypothesis import strategies as st

from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import builtin_asset, cylinder, sphere, star
from tests.geometry.polygons import lots, simple


@st.composite
def rotations(draw):
    """Proper rotations [3, 3]."""
    quaternion = np.array(draw(st.lists(st.integers(-5, 5), min_size=4, max_size=4).filter(any)), float)
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def turned(meshes, rotation):
    """Meshes with every point turned about the origin."""
    return meshes.with_points(meshes.points @ rotation.T)


def prism(ring, height=1.0):
    """A closed prism over a polygon [n, 2] on the ground."""
    return extrude(lots([ring]), np.array([height]))


prisms = simple.map(prism)
"""Prisms over simple polygons of every kind."""

round_solids = st.one_of(
    st.sampled_from(["cube", "cone", "sphere", "star"]).map(builtin_asset),
    st.integers(3, 9).map(cylinder),
    st.builds(sphere, st.integers(3, 8), st.integers(2, 6)),
    st.builds(star, st.integers(3, 7), st.floats(0.2, 0.9)),
)
"""Primitives with a volume."""

solids = st.one_of(prisms, round_solids)
"""Closed meshes."""

FRAME = Meshes.single(
    np.array([[0, 0, 0], [0, 0, 9], [9, 0, 9], [9, 0, 0], [3, 0, 3], [6, 0, 3], [6, 0, 6], [3, 0, 6.0]]),
    [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)],
)
"""A square with a square hole, joined by a keyhole."""


def as_triangles(meshes):
    """The mesh as a trimesh, one mesh only."""
    import trimesh

    from grammarlab.geometry.meshes.triangulate import triangulate

    return trimesh.Trimesh(meshes.points, triangulate(meshes)[0], process=False)
