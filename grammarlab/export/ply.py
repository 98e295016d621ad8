"""Binary PLY files: positions, normals and colours at the vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import row_of_value
from grammarlab.scene import TriangleBatch

VERTEX = np.dtype(
    [(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")]
    + [(name, "u1") for name in ("red", "green", "blue", "alpha")]
)
FACE = np.dtype([("count", "u1"), ("corners", "<u4", 3)])
PROPERTY_TYPES = {"<f4": "float", "|u1": "uchar"}


def ply_bytes(batch: TriangleBatch, offsets: NDArray[np.float64]) -> bytes:
    """All models as one mesh, with the sRGB colours of their materials.

    Args:
        batch: the models.
        offsets: [num_models, 3] where each model stands, in metres.
    """
    vertices = np.empty(len(batch.vertices), VERTEX)
    positions = batch.vertices + np.repeat(offsets, np.diff(batch.group_vertices[batch.model_groups]), axis=0)
    material = batch.group_material[row_of_value(np.diff(batch.group_vertices))]
    colors = np.rint(np.clip(batch.materials.channels[:, :4], 0.0, 1.0) * 255).astype(np.uint8)[material]
    for index, name in enumerate(("x", "y", "z")):
        vertices[name] = positions[:, index]
        vertices["n" + name] = batch.normals[:, index]
    for index, name in enumerate(("red", "green", "blue", "alpha")):
        vertices[name] = colors[:, index]
    faces = np.empty(len(batch.triangles), FACE)
    faces["count"] = 3
    faces["corners"] = batch.triangles
    header = ["ply", "format binary_little_endian 1.0", "comment grammarlab: metres, y up"]
    header.append(f"element vertex {len(vertices)}")
    header += [f"property {PROPERTY_TYPES[VERTEX[name].str]} {name}" for name in VERTEX.names or ()]
    header += [f"element face {len(faces)}", "property list uchar uint vertex_indices", "end_header"]
    return ("\n".join(header) + "\n").encode() + vertices.tobytes() + faces.tobytes()
