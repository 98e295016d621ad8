"""The OpenGL renderer draws what the default renderer draws, but for openness and mirror images."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.errors import UsageError
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.choice import choose
from grammarlab.rendering.rasterize import OpenGLRenderer
from grammarlab.rendering.renderer import RenderOptions
from tests.rendering.models import CASCADE, GLASS, RED_BOX, TOWER, batch, moved, picture

VIEWS = {"perspective": View(), "parallel": View(field_of_view=0.0), "behind": View(azimuth=200.0, elevation=50.0)}


@cache
def working() -> str:
    return choose("auto").platform


@pytest.fixture
def renderer():
    if not working():
        pytest.skip("OpenGL does not work on this machine")
    return OpenGLRenderer(working())


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@pytest.mark.parametrize("text", [TOWER, CASCADE, RED_BOX], ids=["tower", "cascade", "box"])
def test_it_draws_what_rays_draw(renderer, text, view):
    one, other = (picture(batch(text), chosen, view, openness_rays=0) for chosen in (None, renderer))
    assert np.abs(one - other).mean() < 1
    assert np.mean(np.abs(one - other).max(axis=2) > 12) < 0.04  # along edges and shadows


def test_glass_shows_what_is_behind_it(renderer):
    one, other = (picture(batch(GLASS), chosen, openness_rays=0) for chosen in (None, renderer))
    assert np.abs(one - other).mean() < 10  # rays see the other panes, too
    middle = other[24:34, 20:28].reshape(-1, 3).mean(0)
    solid = picture(batch(GLASS.replace("0.4", "1")), renderer)[24:34, 20:28].reshape(-1, 3).mean(0)
    assert middle[0] / middle[2] > 1.3 * solid[0] / solid[2]


def test_the_same_model_gives_the_same_picture(renderer):
    assert np.array_equal(picture(batch(GLASS), renderer), picture(batch(GLASS), renderer))


def test_many_materials_are_told_apart(renderer):
    stripes = "Lot --> split(x) { 0.01 : Stripe }*\nStripe --> color(rand, rand, rand) extrude(1) Stripe."
    model = batch(stripes)
    assert len(model.materials) > 256
    one, other = (picture(model, chosen, openness_rays=0) for chosen in (None, renderer))
    assert np.abs(one - other).mean() < 2.5


def test_it_uses_neither_place_nor_size(renderer):
    model = batch(TOWER)
    assert np.abs(picture(moved(model, 1e6 * np.eye(3)), renderer) - picture(model, renderer)).mean() < 0.3


def test_an_empty_model_is_an_empty_sheet(renderer):
    assert np.array_equal(picture(batch("Lot --> NIL"), renderer), picture(batch("Lot --> NIL")))


def test_a_model_of_glass_alone_is_drawn(renderer):
    model = batch(RED_BOX)
    channels = np.array([[*(CHANNELS | {"opacity": 0.5}).values()]] * len(model.materials))
    glass = replace(model, materials=Materials(channels, model.materials.textures))
    assert np.abs(picture(glass, renderer, openness_rays=0) - picture(glass, openness_rays=0)).mean() < 6


def test_the_environment_is_left_as_it_was(renderer, monkeypatch):
    monkeypatch.setenv("PYOPENGL_PLATFORM", "mine")
    picture(batch(RED_BOX), renderer)
    assert os.environ["PYOPENGL_PLATFORM"] == "mine"


def test_vertices_that_are_not_finite_are_refused():
    model = batch(RED_BOX)
    broken = moved(model, np.eye(3), (float("nan"), 0, 0))
    with pytest.raises(UsageError, match="finite"):
        picture(broken, OpenGLRenderer("egl"))


def test_a_picture_too_large_for_opengl_is_refused():
    model = batch(RED_BOX)
    with pytest.raises(UsageError, match="at most 4096"):
        OpenGLRenderer("egl").render(model, frame(model.vertices, 1.0, View()), RenderOptions(5000, 100))


def test_without_pyrender_a_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrender", None)
    with pytest.raises(UsageError, match=r"pip install 'grammarlab\[gl\]'"):
        picture(batch(RED_BOX), OpenGLRenderer("egl"))
