"""Pictures by ray casting: laws of light, symmetry and independence of how they are made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.errors import UsageError
from grammarlab.rendering import raycast
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.light.look import Look
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.rendering.shot import develop
from grammarlab.scene import TriangleBatch
from tests.rendering.models import CASCADE, GLASS, PLAIN, RED_BOX, TOWER, batch, moved, picture

TEXTS = {"tower": TOWER, "glass": GLASS, "cascade": CASCADE}
MIRROR = np.diag([-1.0, 1.0, 1.0])


def square(color=(1.0, 1.0, 1.0), **channels) -> TriangleBatch:
    """A square of one metre on the ground, seen from above by `FROM_ABOVE`."""
    values = CHANNELS | dict(zip(("color.r", "color.g", "color.b"), color, strict=True)) | channels
    zero, one = np.zeros(1, np.int32), np.array([0, 1])
    return TriangleBatch(
        1,
        Materials(np.array([[*values.values()]]), ("",)),
        np.array([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]], np.float32),
        np.array([[0, 1, 0]] * 4, np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
        zero,
        zero,
        one * 4,
        one * 2,
        one,
        np.full(2, -1, np.int32),
        np.zeros((0, 2, 4)),
        np.zeros((1, 3)),
    )


FROM_ABOVE = View(azimuth=0.0, elevation=89.0, field_of_view=0.0)


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_the_same_model_gives_the_same_picture(text):
    assert np.array_equal(picture(batch(text)), picture(batch(text)))


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_picture_does_not_depend_on_the_bands_it_is_cut_into(text, monkeypatch):
    whole = picture(batch(text))
    monkeypatch.setattr(raycast, "BAND_SAMPLES", 600)
    assert np.array_equal(picture(batch(text)), whole)


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_mirrored_scene_gives_the_mirrored_picture(text):
    """Rays that look for openness are not mirrored, so without them; the sun's disc is taken as a point."""
    look, view = Look(sun_softness=0.0), View()
    other_look, other_view = replace(look, sun_azimuth=-look.sun_azimuth), replace(view, azimuth=-view.azimuth)
    one = picture(batch(text), view=view, look=look, openness_rays=0)
    other = picture(moved(batch(text), MIRROR), view=other_view, look=other_look, openness_rays=0)
    assert np.abs(one - other[:, ::-1]).mean() < 0.3


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
@pytest.mark.parametrize(("scale", "by"), [(1.0, (64.0, 16.0, -32.0)), (1024.0, (0, 0, 0)), (2.0**-10, (0, 0, 0))])
def test_a_picture_depends_on_neither_place_nor_size_of_the_model(text, scale, by):
    one, other = picture(batch(text)), picture(moved(batch(text), scale * np.eye(3), by))
    assert np.abs(one - other).mean() < 0.3


def test_a_model_far_from_the_origin_of_its_map_is_drawn_as_elsewhere():
    model = batch(RED_BOX)
    there = moved(model, np.eye(3), (500_000.0, 300.0, -4_000_000.0))
    assert np.abs(picture(there) - picture(model)).mean() < 12  # single precision: a box is some centimetres off


def test_a_red_box_is_red_in_the_middle_of_the_picture():
    red, green, blue = picture(batch(RED_BOX), edges=False)[20:28, 20:28].reshape(-1, 3).mean(0)
    assert red > 1.5 * green
    assert red > 1.5 * blue


def test_the_corners_of_the_picture_show_no_model():
    corners = picture(batch(RED_BOX))[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert (corners[:, 0] < corners[:, 2] + 40).all()


def test_a_face_in_the_sun_is_brighter_than_one_in_shadow():
    """The roof of the base: beside the tower on the side of the sun, and on the other."""
    model = batch(CASCADE)
    view, look = View(azimuth=0.0, elevation=80.0, field_of_view=0.0), PLAIN
    seen = picture(model, view=view, look=look, openness_rays=0).sum(axis=2)
    towards_sun, away = seen[22:26, 6:9], seen[14:18, 36:39]
    assert towards_sun.min() > 1.2 * away.max()


def test_without_blockers_nothing_is_in_shadow():
    seen = picture(square(), view=FROM_ABOVE, openness_rays=4)[8:-8, 8:-8]
    assert np.ptp(seen.reshape(-1, 3), axis=0).max() <= 1


def test_a_deep_corner_is_darker_where_openness_is_looked_for():
    text = "Lot --> [ t(0, 0, 0) s('0.2, 0, '1) extrude(3) A. ] t('0.2, 0, 0) s('0.8, 0, '1) extrude(0.2) B."
    view = View(azimuth=0.0, elevation=80.0, field_of_view=0.0)
    look = replace(PLAIN, sun_azimuth=90.0)
    open_, closed = (picture(batch(text), view=view, look=look, openness_rays=rays) for rays in (0, 8))
    near, far = (
        open_[20:28, 14:16].mean() - closed[20:28, 14:16].mean(),
        open_[20:28, 38:42].mean() - closed[20:28, 38:42].mean(),
    )
    assert near > far + 5


@pytest.mark.parametrize("color", [(0.8, 0.2, 0.1), (0.1, 0.4, 0.1), (0.5, 0.5, 0.5)])
def test_a_white_light_shows_the_base_colour_that_files_hold(color):
    """A rough surface under nothing but a white sky of that strength looks as its colour was written."""
    white = (1.0, 1.0, 1.0)
    look = Look(sun=(0, 0, 0), sky=white, horizon=white, ground=white, bounce=1.0, exposure=1.0, shoulder=1.0 - 1e-6)
    values = {"roughness": 1.0}
    seen = picture(square(color, **values), view=FROM_ABOVE, look=look, edges=False)[16:32, 16:32].reshape(-1, 3)
    mirrored = picture(square((0.0, 0.0, 0.0), **values), view=FROM_ABOVE, look=look, edges=False)[24, 24]
    linear = lambda v: np.where(v <= 10, v / 12.92 / 255, ((v / 255 + 0.055) / 1.055) ** 2.4)  # noqa: E731
    expected = linear(np.array(color) * 255) * (1 - linear(mirrored)) + linear(mirrored)
    assert np.abs(seen - develop(expected)).max() <= 2


def test_glass_shows_what_is_behind_it():
    clear, solid = batch(GLASS), batch(GLASS.replace("0.4", "1"))
    middle = slice(24, 34), slice(20, 28)
    (red, _, blue), (other_red, _, other_blue) = (picture(m)[middle].reshape(-1, 3).mean(0) for m in (clear, solid))
    assert red / blue > 1.3 * other_red / other_blue


def test_opaque_glass_is_a_solid():
    model = batch(GLASS)
    channels = model.materials.channels.copy()
    channels[:, list(CHANNELS).index("opacity")] = 1.0
    solid = replace(model, materials=Materials(channels, model.materials.textures))
    assert np.array_equal(picture(solid), picture(batch(GLASS.replace("0.4", "1"))))


def test_edges_only_darken_and_only_the_model():
    without, with_ = (picture(batch(TOWER), edges=edges) for edges in (False, True))
    assert (with_ <= without).all()
    assert (with_ < without).any()
    assert np.array_equal(with_[:2], without[:2])


def test_the_ground_only_darkens_the_paper_and_can_be_left_out():
    without, with_ = (picture(batch(TOWER), ground=ground) for ground in (False, True))
    assert (with_ <= without).all()
    assert (with_ < without).any()


def test_a_free_standing_face_is_seen_from_both_sides():
    below = View(azimuth=0.0, elevation=-89.0, field_of_view=0.0)
    seen = picture(square((0.9, 0.1, 0.1)), view=below, ground=False)[20:28, 20:28].reshape(-1, 3).mean(0)
    assert seen[0] > 2 * seen[2]


def test_a_model_without_triangles_is_an_empty_sheet():
    empty = batch("Lot --> NIL")
    image = picture(empty)
    assert len(empty.triangles) == 0
    assert np.array_equal(image, np.repeat(image[:, :1], 48, axis=1))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_vertices_that_are_not_finite_are_refused(bad):
    model = square()
    vertices = model.vertices.copy()
    vertices[2, 1] = bad
    with pytest.raises(UsageError, match="finite vertices"):
        RaycastRenderer().render(
            replace(model, vertices=vertices), frame(model.vertices, 1.0, View()), RenderOptions(8, 8)
        )


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_huge_and_tiny_extents_are_drawn_without_a_warning(scale):
    assert picture(moved(batch(TOWER), scale * np.eye(3))).std() > 5


@pytest.mark.parametrize(
    "corners", [[[0, 0, 0]] * 3, [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 0, 0], [0, 5, 0], [0, 9, 0]]]
)
def test_triangles_without_area_are_harmless(corners):
    model = square()
    flat = replace(model, vertices=np.array([*corners, corners[0]], np.float32))
    assert picture(flat).shape == (48, 48, 3)


def test_normals_of_no_length_are_harmless():
    model = square()
    assert picture(replace(model, normals=np.zeros_like(model.normals)), view=FROM_ABOVE).shape == (48, 48, 3)


@pytest.mark.parametrize(
    "options", [{"width": 0}, {"width": 20_000}, {"samples": 9}, {"openness_rays": -1}, {"width": 9000, "height": 9000}]
)
def test_sizes_that_make_no_sense_are_refused(options):
    with pytest.raises(UsageError, match="picture"):
        RenderOptions(**options)


@pytest.mark.parametrize("shape", [(1, 1), (7, 3), (3, 50)])
def test_pictures_may_have_any_shape(shape):
    width, height = shape
    model = batch(RED_BOX)
    camera = frame(model.vertices, width / height, View())
    assert RaycastRenderer().render(model, camera, RenderOptions(width, height)).shape == (height, width, 3)
