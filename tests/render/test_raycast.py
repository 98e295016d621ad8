"""Pictures: the same every time, of what is in front of the camera."""

from __future__ import annotations

import numpy as np

from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar
from grammarlab.render.camera import View, frame
from grammarlab.render.raycast import RaycastRenderer
from grammarlab.render.renderer import RenderOptions
from grammarlab.scene import realize, triangles


def picture(text: str, **options) -> np.ndarray:
    batch = triangles(realize(derive(Grammar.parse(text), 1, 1, footprint=(4.0, 4.0))))
    camera = frame(batch.vertices, 1.0, View())
    return RaycastRenderer().render(batch, camera, RenderOptions(48, 48, **options))


def test_the_same_model_gives_the_same_picture():
    text = 'Lot --> color("#cc4422") extrude(3)'
    assert np.array_equal(picture(text), picture(text))


def test_a_red_box_is_red_in_the_middle_of_the_picture():
    red, green, blue = picture('Lot --> color("#cc2020") extrude(3)', edges=False)[20:28, 20:28].reshape(-1, 3).mean(0)
    assert red > 1.5 * green
    assert red > 1.5 * blue


def test_the_corners_of_the_picture_show_no_model():
    image = picture('Lot --> color("#cc2020") extrude(3)').astype(int)
    corners = image[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert (corners[:, 0] < corners[:, 2] + 40).all()


def test_the_ground_can_be_left_out():
    text = 'Lot --> color("#cc2020") extrude(3)'
    assert not np.array_equal(picture(text, ground=True), picture(text, ground=False))
