"""Corners that neighbours share.

Cuts are rounded to millimetres, so the end of a cut is beside the edge that it ends on. With the point in both
outlines, the parcels of a block have neither gaps nor overlaps. So that it is clear which points are on an edge, the
ends of cuts are moved along their edges onto corners that are near.
"""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.arrays import Floats, connected, offsets_from_counts
from grammarlab.city.plot_cuts import Cuts, Plots

_REACH = 0.006
"""Tolerance: metres from an edge; a cut is rounded by 0.7 mm, and so is each earlier one along the same edge."""
SNAP = 0.3
"""Tolerance: metres along an edge between corners; nearer ones become one."""


def snapped(plots: Plots, cuts: Cuts, corners: Floats) -> Cuts:
    """Cuts whose ends are moved along their edges onto corners that are near.

    Args:
        plots: the plots that are cut.
        cuts: K cuts, all those that are made at a time.
        corners: [n, 2] all corners so far.
    """
    ends = cuts.end.reshape(-1, 2)
    edge = cuts.edge.reshape(-1)
    along = plots.corners[plots.following[edge]] - plots.corners[edge]
    along /= np.hypot(*along.T)[:, None]
    points = np.concatenate([np.unique(corners, axis=0), ends])
    num_corners = len(points) - len(ends)
    tree = shapely.STRtree(np.asarray(shapely.points(points)))
    end, point = tree.query(shapely.points(ends), predicate="dwithin", distance=SNAP)
    offset = points[point] - ends[end]
    lateral = np.abs(along[end, 0] * offset[:, 1] - along[end, 1] * offset[:, 0])
    end, point = end[lateral <= _REACH], point[lateral <= _REACH]
    # Ends near each other meet at the first of them in the order of their coordinates, or at a corner near it.
    is_end = point >= num_corners
    cluster = connected(len(ends), end[is_end], point[is_end] - num_corners)
    order = np.lexsort((ends[:, 1], ends[:, 0], cluster))
    first = order[np.searchsorted(cluster[order], np.arange(cluster.max(initial=-1) + 1))]
    target = ends[first]
    has_corner = ~is_end
    distance = np.hypot(*(points[point[has_corner]] - ends[end[has_corner]]).T)
    by_distance = np.lexsort((point[has_corner], distance, cluster[end[has_corner]]))
    owner, nearest = np.unique(cluster[end[has_corner]][by_distance], return_index=True)
    target[owner] = points[point[has_corner][by_distance][nearest]]
    return Cuts(cuts.row, cuts.edge, target[cluster].reshape(-1, 2, 2))


def with_shared_corners(plots: Plots) -> Plots:
    """The plots with all corners of others that are on their edges."""
    if not len(plots):
        return plots
    start, end = plots.corners, plots.corners[plots.following]
    points = np.unique(plots.corners, axis=0)
    tree = shapely.STRtree(np.asarray(shapely.points(points)))
    edges = shapely.linestrings(np.stack([start, end], axis=1))
    edge, point = tree.query(edges, predicate="dwithin", distance=_REACH)
    along = end[edge] - start[edge]
    share = ((points[point] - start[edge]) * along).sum(axis=1) / (along**2).sum(axis=1)
    is_inner = (
        (share > 0)
        & (share < 1)
        & (points[point] != start[edge]).any(axis=1)
        & (points[point] != end[edge]).any(axis=1)
    )
    edge, point, share = edge[is_inner], point[is_inner], share[is_inner]
    order = np.lexsort((share, edge))
    edge, point = edge[order], point[order]
    corners = np.insert(plots.corners, edge + 1, points[point], axis=0)
    on_street = np.insert(plots.on_street, edge + 1, plots.on_street[edge])
    counts = np.diff(plots.offsets) + np.bincount(plots.row[edge], minlength=len(plots))
    return Plots(corners, on_street, offsets_from_counts(counts))
