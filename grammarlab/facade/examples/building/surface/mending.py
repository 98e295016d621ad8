"""Remaining open edges, closed without regard to shape: walks along them are filled with triangles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from grammarlab.facade.examples.mesh.surface import Ints, Surface, naked_edges, without_empty

_MOST = 20_000
"""Largest number of open edges; surfaces with more have large gaps, and stay open."""


def mended(surface: Surface) -> Surface:
    """The surface without open edges, if it has few: each closed walk along them becomes a fan of triangles.

    Open edges always form closed walks, since they are the boundary of a sum of triangles.
    """
    edges, times = naked_edges(surface.triangles, len(surface.points))
    if not len(edges) or times.sum() > _MOST:
        return surface
    fans = [_fan(walk) for walk in _walks(np.repeat(edges, times, axis=0))]
    rows = np.concatenate(fans)
    of_point = np.zeros(len(surface.points), dtype=np.int64)
    of_point[surface.triangles.ravel()] = np.repeat(surface.material, 3)
    return without_empty(
        Surface(
            surface.points,
            np.concatenate([surface.triangles, rows]),
            np.concatenate([surface.material, of_point[rows[:, 0]]]),
        )
    )


def _walks(edges: Ints) -> list[list[int]]:
    """Closed walks without repeated points that use every directed edge once."""
    following: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        following.setdefault(start, []).append(end)
    walks = []
    for start in sorted(following):
        while following[start]:
            walk, place = [start], {start: 0}
            while True:
                point = following[walk[-1]].pop()
                if point in place:
                    first = place[point]
                    walks.append(walk[first:])
                    for each in walk[first + 1 :]:
                        del place[each]
                    walk = walk[: first + 1]
                    if first == 0 and not following[start]:
                        break
                    if first == 0:
                        continue
                else:
                    place[point] = len(walk)
                    walk.append(point)
    return walks


def _fan(walk: list[int]) -> Ints:
    """Triangles whose edges are opposite to those of a walk."""
    first, rest = walk[0], walk[1:]
    return np.array([(first, b, a) for a, b in pairwise(rest)], dtype=np.int64).reshape(-1, 3)
