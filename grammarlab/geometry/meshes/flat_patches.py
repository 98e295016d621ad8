"""Outlines of flat patches of triangles or faces, and the faces within them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.mesh import Indices
from grammarlab.geometry.meshes.triangulate import contains, keyhole


def loops_of(edges: Sequence[tuple[int, int]]) -> list[list[int]]:
    """Outlines of a flat patch, counter-clockwise, those of its holes clockwise.

    Args:
        edges: start and end of the directed edges of its faces; those passed in both directions are inside.
    """
    directed = set(edges)
    following: dict[int, list[int]] = defaultdict(list)
    for start, end in sorted(directed):
        if (end, start) not in directed:
            following[start].append(end)
    loops: list[list[int]] = []
    while following:
        start = current = min(following)
        loop: list[int] = []
        while current in following:
            loop.append(current)
            ends = following[current]
            step = ends.pop(0)
            if not ends:
                del following[current]
            current = step
            if current == start:
                break
        loops.append(loop)
    return loops


def faces_within(points: Floats, loops: Sequence[list[int]], normal: Floats) -> list[Indices]:
    """Faces of a flat patch with these outlines, with a keyhole for every hole.

    Args:
        points: [P, 3] all points, in metres.
        loops: points of each outline; those of less than three are left out.
        normal: [3] normal of the patch, of any length > 0.
    """
    loops = [loop for loop in loops if len(loop) > 2]
    if len(loops) < 2:
        return [np.array(loop) for loop in loops]
    z = normal / np.linalg.norm(normal)
    x = np.cross(z, np.eye(3)[np.abs(z).argmin()])
    x /= np.linalg.norm(x)
    axes = np.column_stack([x, np.cross(z, x)])
    flat: list[Floats] = [np.dot(points[loop], axes) for loop in loops]
    areas = [
        float(np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - np.roll(ring[:, 0], -1) * ring[:, 1])) for ring in flat
    ]
    outer = [number for number, area in enumerate(areas) if area > 0.0]
    result = []
    for number in outer:
        holes = [i for i, area in enumerate(areas) if area < 0.0 and _owner(flat, areas, outer, i) == number]
        rings = [number, *holes]
        order = keyhole([flat[i] for i in rings]) if holes else np.arange(len(loops[number]))
        result.append(np.concatenate([np.array(loops[i]) for i in rings])[order])
    return result


def _owner(flat: list[Floats], areas: list[float], outer: list[int], hole: int) -> int:
    """The smallest outline around a hole."""
    around = [i for i in outer if contains(flat[i], flat[hole])]
    return min(around, key=lambda i: areas[i], default=-1)
