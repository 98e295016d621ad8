"""A solved layout as a scene: all visible shapes, with the depths of their labels, shapes and layers."""

from __future__ import annotations

import numpy as np

from grammarlab.derivation.functions.colors import parse_color
from grammarlab.derivation.values.materials import CHANNELS, Materials
from grammarlab.facade.layers.designs.design import Design
from grammarlab.facade.layers.showing.panels import Panels
from grammarlab.facade.looks import THICKNESS, LabelLook, look_of
from grammarlab.facade.tree import X, Y
from grammarlab.geometry.solids.primitives import box
from grammarlab.scene.instances import Scene

_THINNEST = 0.01
"""Least thickness of a box, metres."""


def relief(design: Design, panels: Panels) -> Scene:
    """One model: x to the right, y up, the front of a wall at z = `THICKNESS` and all backs at 0.

    Shapes that are not opaque are in front of the shapes that are visible through them; opaque ones replace those
    below.
    """
    layers = design.visible_layers
    position, size, looks = [], [], []
    for panel, boxes in zip(panels.panels, panels.seen(), strict=True):
        look = look_of(panel.shape.label)
        depth = max(_THINNEST, THICKNESS + look.front + panel.shape.depth + layers[panel.layer].depth)
        for left, bottom, right, top in boxes:
            low = panels.lines[X][left], panels.lines[Y][bottom]
            position.append((*low, 0.0))
            size.append((panels.lines[X][right] - low[X], panels.lines[Y][top] - low[Y], depth))
            looks.append(look)
    distinct = sorted(set(looks), key=lambda look: (look.color, look.front))
    material = np.array([distinct.index(look) for look in looks], dtype=np.int32)
    order = np.argsort(material, kind="stable")
    num = len(looks)
    channels = np.array([_channels(look) for look in distinct]).reshape(-1, len(CHANNELS))
    return Scene(
        num_models=1,
        meshes=box(),
        materials=Materials(channels, ("",) * len(distinct)),
        model=np.zeros(num, dtype=np.int32),
        mesh=np.zeros(num, dtype=np.int32),
        material=material[order],
        position=np.array(position).reshape(-1, 3)[order],
        size=np.array(size).reshape(-1, 3)[order],
        frame=np.zeros(num, dtype=np.int32),
        frames=np.eye(3)[None],
        texture_map=np.full(num, -1, dtype=np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((1, 3)),
    )


def _channels(look: LabelLook) -> tuple[float, ...]:
    color = dict(zip(("color.r", "color.g", "color.b", "opacity"), parse_color(look.color) or (), strict=False))
    return tuple({**CHANNELS, **color, "metallic": look.metallic, "roughness": look.roughness}.values())
