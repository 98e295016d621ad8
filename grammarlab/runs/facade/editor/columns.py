"""Drawing data of facades for a page: numbers as columns in buffers, other values as JSON."""

from __future__ import annotations

import numpy as np

from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import Facade
from grammarlab.runs.serving.windows import Message


def drawing(facade: Facade) -> tuple[Message, bytes]:
    """Drawing data of a facade.

    Returns:
        label: [L] index of each leaf into `colors`; -1 for none.
        picture: [L] index of each leaf's picture, -1 for none.
        outlines: for each leaf with an outline: its index among leaves, and its corners as fractions of its box.
        And as bytes [L, 8] doubles: left, bottom, width and height in metres, left, bottom, right and top of its part
        of the picture.
    """
    leaves = facade.leaves
    counts = np.diff(facade.outline_offsets)[leaves]
    values = {
        "width": facade.width,
        "height": facade.height,
        "label": facade.label[leaves].tolist(),
        "picture": facade.picture[leaves].tolist(),
        "outlines": [
            {"leaf": leaf, "corners": facade.outline(int(leaves[leaf])).tolist()}
            for leaf in np.flatnonzero(counts).tolist()
        ],
    }
    return values, np.hstack([boxes(facade)[leaves], facade.window[leaves]]).astype("<f8").tobytes()


def colors(facade: Facade) -> list[str]:
    """The color of each label, with that of unlabelled leaves last."""
    return [look_of(label).color for label in (*facade.labels, "")]


def boxes(facade: Facade) -> np.ndarray:
    """[N, 4] left, bottom, width and height of all nodes, metres, from the lower left corner of the facade."""
    return np.hstack([facade.position - facade.position[0], facade.size])
