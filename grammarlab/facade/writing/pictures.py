"""Positions of pictures on the nodes of a facade, and their CGA text."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.pictures import store_pictures
from grammarlab.facade.tree import LEAF, Facade
from grammarlab.facade.writing.rule_text import number

Floats = NDArray[np.float64]

SAME = 1e-7
"""Largest difference of the windows of two leaves that show one picture, as a fraction of the picture."""
_DIGITS = 12


@dataclass(frozen=True, slots=True)
class ShownPictures:
    """The picture that each node shows as a whole, as adjacent leaves of one picture do."""

    picture: NDArray[np.int64]
    """[N] index into the pictures of the facade; -1 for nodes with none, or with several."""
    window: Floats
    """[N, 4] left, bottom, right, top of the picture's part on the whole facade, if the picture were continued."""


def shown(facade: Facade) -> ShownPictures:
    """The picture of every node: a node has the picture of its children, if they share one in one position."""
    picture, window = np.where(facade.axis == LEAF, facade.picture, -1), _extended(facade)
    for node in range(len(facade) - 1, -1, -1):
        parts = facade.children[node]
        if not len(parts) or picture[parts[0]] < 0:
            continue
        if (picture[parts] == picture[parts[0]]).all() and np.ptp(window[parts], axis=0).max() <= SAME:
            picture[node], window[node] = picture[parts[0]], window[parts[0]]
    return ShownPictures(picture, window)


def _extended(facade: Facade) -> Floats:
    """[N, 4] the window of each node, extended from its box to that of the facade."""
    low, size = facade.window[:, :2], facade.window[:, 2:] - facade.window[:, :2]
    scale = size / facade.size
    first = low - (facade.position - facade.position[0]) * scale
    return np.concatenate([first, first + facade.size[0] * scale], axis=1)


def picture_file(facade: Facade, picture: int) -> str:
    """The file name of a picture in rules."""
    names = [re.sub(r"[^A-Za-z0-9._-]", "_", each.name).lstrip(".-") for each in facade.pictures[: picture + 1]]
    return f"{picture}_{names[-1]}" if names[-1] in names[:-1] else names[-1]


def projection(facade: Facade, shows: ShownPictures, node: int) -> str:
    """The operations that set up a picture on a node, for ``projectUV`` below it; empty if it cannot be shown."""
    place = (facade.position[node] - facade.position[0]) / facade.size[0]
    part = facade.size[node] / facade.size[0]
    low, whole = shows.window[node, :2], shows.window[node, 2:] - shows.window[node, :2]
    return window_projection(picture_file(facade, int(shows.picture[node])), low + place * whole, part * whole)


def window_projection(file: str, first: Floats, extent: Floats) -> str:
    """The operations that lay a window of a picture on a rectangle; empty for one that has no area.

    Args:
        file: name of the picture in the folder of assets.
        first: [2] left and bottom of the window, as parts of the picture.
        extent: [2] width and height of the window.
    """
    if (np.abs(extent) < SAME).any():
        return ""
    sizes = ", ".join(f"'{number(value, _DIGITS)}" for value in (1.0 / extent).tolist())
    offsets = ", ".join(f"'{number(value, _DIGITS)}" for value in (first / extent).tolist())
    return f'texture("{file}") setupProjection(0, scope.xy, {sizes}, {offsets})'


def store_as_assets(facade: Facade, folder: Path) -> None:
    """Write the pictures of a facade into a folder of assets, under their names in rules and scenes.

    Raises:
        FacadeError: If a file of such a name exists with another picture; nothing is written then.
    """
    names = [picture_file(facade, index) for index in range(len(facade.pictures))]
    store_pictures((replace(each, name=name) for each, name in zip(facade.pictures, names, strict=True)), folder)
