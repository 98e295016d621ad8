"""A solved layout as a facade: the topmost shape at each point, in a tree of rectangles."""

from __future__ import annotations

import numpy as np

from grammarlab.facade.boxes.assembling import OUTSIDE
from grammarlab.facade.boxes.cutting import cut
from grammarlab.facade.boxes.filling import WALL, fill
from grammarlab.facade.boxes.overlaps import VisiblePieces
from grammarlab.facade.layers.showing.panels import Panels, rectangles
from grammarlab.facade.tree import Facade, X, Y


def flattened(panels: Panels) -> Facade:
    """The facade of all visible shapes.

    The visible rest of a partly hidden shape is divided into rectangles. Regions without a straight cut are divided
    with
    as few cuts as possible; shapes that are fully visible are cut last. Empty parts of the facade are `outside`, or
    show the lowest shape that covers the whole canvas.
    """
    frame = (0, 0, len(panels.lines[X]) - 1, len(panels.lines[Y]) - 1)
    everywhere = [number for number, panel in enumerate(panels.panels) if panel.lines == frame]
    behind = everywhere[-1] if everywhere else WALL
    boxes: list[tuple[int, int, int, int]] = []
    source: list[int] = []
    whole: list[bool] = []
    for number, panel in enumerate(panels.panels):
        left, bottom, right, top = panel.lines
        seen = panels.topmost[bottom:top, left:right] == number
        if seen.any() and number != behind:
            found = rectangles(seen, panel.lines)
            boxes += found
            source += [number] * len(found)
            whole += [len(found) == 1] * len(found)
    pieces = VisiblePieces(
        np.array(boxes).reshape(-1, 4), np.array(source, dtype=np.int64), np.array(whole, dtype=np.bool_)
    )
    tiles, shown = fill(pieces, frame, split=True)
    shown = np.where(shown == WALL, behind, shown)
    low, high = (
        np.stack([panels.lines[X][tiles[:, side]], panels.lines[Y][tiles[:, side + 1]]], axis=1) for side in (0, 2)
    )
    names = [OUTSIDE if each == WALL else panels.panels[each].shape.label for each in shown.tolist()]
    return cut(low, high, names)[0]
