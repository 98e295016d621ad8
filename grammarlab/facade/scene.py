"""A facade as a scene: each leaf is a box with the depth and colour of its label, or with its picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.functions.color_functions import parse_color
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.facade.grammar.leaf_looks import UPRIGHT, picture_file, prisms, shown_pictures
from grammarlab.facade.looks import THICKNESS, LabelLook, look_of
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box as solid_box
from grammarlab.scene.instances import Scene

_BOX, _PRISM = 0, 1


class _Piece(NamedTuple):
    """A mesh in the box of a leaf."""

    leaf: int
    mesh: int
    kind: int
    """`_BOX` or `_PRISM`."""
    look: LabelLook
    pictured: bool


def realize_facade(facade: Facade) -> Scene:
    """One model: x to the right, y up, the front of the wall at z = `THICKNESS` and its back at 0.

    A leaf with an outline is a prism over it, and the rest of its box is wall; that of a wall is empty. Pictures are on
    the front, with file names from `picture_file`.
    """
    pieces, meshes = _pieces(facade)
    leaf = np.array([piece.leaf for piece in pieces])
    kind = np.array([piece.kind for piece in pieces])
    depth = np.array([THICKNESS + piece.look.front for piece in pieces])
    low = facade.position[leaf] - facade.position[0]
    position = np.column_stack([low, np.zeros(len(leaf))])
    size = np.column_stack([facade.size[leaf], depth])
    is_prism = kind == _PRISM
    position[is_prism, 1] += facade.size[leaf[is_prism], Y]
    size[is_prism] = size[is_prism][:, [0, 2, 1]]
    materials, material = _materials(facade, pieces)
    order = np.argsort(material, kind="stable")
    pictured = np.array([piece.pictured for piece in pieces])
    num = len(pieces)
    return Scene(
        num_models=1,
        meshes=meshes,
        materials=materials,
        model=np.zeros(num, dtype=np.int32),
        mesh=np.array([piece.mesh for piece in pieces], dtype=np.int32)[order],
        material=material[order],
        position=position[order],
        size=size[order],
        frame=kind.astype(np.int32)[order],
        frames=np.stack([np.eye(3), UPRIGHT]),
        texture_map=np.where(pictured, leaf, -1).astype(np.int32)[order],
        texture_maps=_texture_maps(facade),
        origins=np.zeros((1, 3)),
    )


def _pieces(facade: Facade) -> tuple[list[_Piece], Meshes]:
    """The pieces of leaves, and their meshes; the first mesh is the unit cube."""
    pieces: list[_Piece] = []
    batches, num_meshes = [solid_box()], 1
    for leaf in facade.leaves.tolist():
        look, outline = look_of(facade.name_of(leaf)), facade.outline(leaf)
        pictured = bool(facade.picture[leaf] >= 0)
        if not len(outline):
            pieces.append(_Piece(leaf, 0, _BOX, look, pictured))
            continue
        around = look_of("outside") if look.is_flexible else look_of("")
        for batch, of_piece in zip(prisms(outline), (look, around), strict=True):
            batches.append(batch)
            pieces += [_Piece(leaf, num_meshes + k, _PRISM, of_piece, pictured) for k in range(len(batch))]
            num_meshes += len(batch)
    return pieces, Meshes.concatenate(batches)


def _materials(facade: Facade, pieces: list[_Piece]) -> tuple[Materials, NDArray[np.int32]]:
    """The distinct materials of pieces, and the material [I] of each."""
    number: dict[tuple[tuple[float, ...], str], int] = {}
    material = []
    for piece in pieces:
        texture = picture_file(facade, int(facade.picture[piece.leaf])) if piece.pictured else ""
        key = _channels(piece.look, pictured=piece.pictured), texture
        material.append(number.setdefault(key, len(number)))
    channels = np.array([values for values, _ in number]).reshape(-1, len(CHANNELS))
    return Materials(channels, tuple(texture for _, texture in number)), np.array(material, dtype=np.int32)


def _channels(look: LabelLook, *, pictured: bool) -> tuple[float, ...]:
    if pictured:
        return tuple(CHANNELS.values())
    color = parse_color(look.color) or ()
    changed_channels = {
        **dict(zip(("color.r", "color.g", "color.b", "opacity"), color, strict=False)),
        "metallic": look.metallic,
        "roughness": look.roughness,
    }
    return tuple({**CHANNELS, **changed_channels}.values())


def _texture_maps(facade: Facade) -> Floats:
    """[N, 2, 4] texture mapping of the picture of each node."""
    window = shown_pictures(facade).window
    maps = np.zeros((len(facade), 2, 4))
    for axis in (X, Y):
        maps[:, axis, axis] = (window[:, 2 + axis] - window[:, axis]) / facade.size[0, axis]
        maps[:, axis, 3] = window[:, axis]
    return maps
