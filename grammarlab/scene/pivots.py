"""Pivots: origins of models below them or in their middle, so that other programs turn and place them there."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from grammarlab.scene.instances import Scene, moved

Pivot = Literal["footprint", "centre", "world", "local"]
PIVOTS: tuple[str, ...] = get_args(Pivot)
_DECIMALS = 3
"""Decimals of a pivot in metres."""


def at_pivot(scene: Scene, pivot: Pivot) -> Scene:
    """The same models in the world, with their origins at their pivots, to the millimetre.

    Args:
        scene: the scene.
        pivot: ``footprint`` is the middle of the bottom of the bounding box of a model, ``centre`` that of the box;
            ``world`` and ``local`` keep the origins.
    """
    if pivot in ("world", "local") or len(scene) == 0:
        return scene
    from grammarlab.scene.instance_bounds import scene_bounds  # noqa: PLC0415  # most runs do without

    low, high = scene_bounds(scene)
    places = (low + high) / 2.0
    if pivot == "footprint":
        places[:, 1] = low[:, 1]
    return moved(scene, np.round(places, _DECIMALS) + 0.0)
