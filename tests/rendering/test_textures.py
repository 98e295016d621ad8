"""Pictures on triangles: colours, holes, and surfaces that light passes through."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.errors import UsageError
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.light.look import Look
from grammarlab.rendering.light.surfaces import prepare
from grammarlab.rendering.light.textures import has_holes
from grammarlab.rendering.rasterize import OpenGLRenderer
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.scene import TriangleBatch

RED, GREEN, BLUE, CLEAR = (255, 0, 0, 255), (0, 255, 0, 255), (0, 0, 255, 255), (255, 255, 0, 0)
FRONT = View(azimuth=0.0, elevation=0.0, field_of_view=0.0, margin=0.0)
BACK = replace(FRONT, azimuth=180.0)
PLAIN = RenderOptions(width=32, height=32, samples=1, openness_rays=0, edges=False, ground=False)


def png(rows: list[list[tuple[int, int, int, int]]]) -> bytes:
    content = BytesIO()
    Image.fromarray(np.array(rows, np.uint8)).save(content, "PNG")
    return content.getvalue()


def panel(picture: bytes, *, cut_out: bool = True, thin: bool = False, depth: float = 0.0) -> TriangleBatch:
    """An upright square of one metre that faces +z and shows a picture once."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    zero, one = np.zeros(1, np.int32), np.array([0, 1])
    return TriangleBatch(
        num_models=1,
        materials=Materials(
            np.array([[*CHANNELS.values()]]),
            ("a.png",),
            {"a.png": picture},
            frozenset({"a.png"} if cut_out else ()),
            frozenset({0} if thin else ()),
        ),
        vertices=np.column_stack([corners, np.full(4, depth, np.float32)]),
        normals=np.array([[0, 0, 1]] * 4, np.float32),
        triangles=np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
        group_model=zero,
        group_material=zero,
        group_vertices=one * 4,
        group_triangles=one * 2,
        model_groups=one,
        texture_map=np.full(2, -1, np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((1, 3)),
        coordinates=corners,
    )


def render(batch: TriangleBatch, view: View = FRONT, **options) -> np.ndarray:
    camera = frame(batch.vertices, 1.0, view)
    return RaycastRenderer().render(batch, camera, replace(PLAIN, **options)).astype(int)


def quarters(picture: np.ndarray) -> list[int]:
    """Brightest channel at the middle of each quarter of a picture, row by row."""
    return [int(picture[row, column, :3].argmax()) for row in (8, 24) for column in (8, 24)]


def test_a_picture_is_upright_and_not_mirrored():
    batch = panel(png([[RED, GREEN], [BLUE, RED]]))
    assert quarters(render(batch)) == [0, 1, 2, 0]
    assert quarters(render(batch, BACK)) == [1, 0, 0, 2]


def test_a_white_picture_changes_nothing():
    batch = panel(png([[(255, 255, 255, 255)] * 2] * 2))
    np.testing.assert_array_equal(render(batch), render(replace(batch, coordinates=None)))


def test_a_material_multiplies_its_picture():
    batch = panel(png([[RED, GREEN], [BLUE, RED]]))
    channels = batch.materials.channels.copy()
    channels[:, :3] = (0.5, 1.0, 1.0)
    dark = render(replace(batch, materials=replace(batch.materials, channels=channels)))
    assert dark[8, 8, 0] < render(batch)[8, 8, 0]
    np.testing.assert_array_equal(dark[8, 24], render(batch)[8, 24])


def test_rays_pass_through_holes():
    """Beside a hole is the panel, in it the background, from the front and from the back."""
    batch = panel(png([[RED, CLEAR], [CLEAR, RED]]))
    empty = render(panel(png([[CLEAR] * 2] * 2)))
    assert has_holes(batch)
    for view, open_quarters in ((FRONT, (False, True, True, False)), (BACK, (True, False, False, True))):
        picture = render(batch, view)
        for (row, column), is_open in zip(((8, 8), (8, 24), (24, 8), (24, 24)), open_quarters, strict=True):
            assert (picture[row, column] == empty[row, column]).all() == is_open


def test_transparency_of_other_pictures_is_ignored():
    batch = panel(png([[RED, CLEAR], [CLEAR, RED]]), cut_out=False)
    assert not has_holes(batch)
    assert (render(batch) != render(panel(png([[CLEAR] * 2] * 2)))).any(axis=2).all()


def test_shadows_have_holes():
    tracer = prepare(panel(png([[RED, CLEAR], [CLEAR, RED]]))).blockers
    # The square is [-s, s] in model units.
    side = np.sqrt(0.125)
    origins = np.array([[-side, side, 1], [side, side, 1], [-side, -side, 1], [side, -side, 1]], np.float32)
    forward = np.tile(np.array([[0, 0, -1]], np.float32), (4, 1))
    assert tracer.is_blocked(origins, forward).tolist() == [True, False, False, True]
    assert tracer.is_blocked(origins, forward, 0.9).tolist() == [False] * 4
    assert (tracer.first_hit(origins, forward).distance > 1.1).tolist() == [False, True, True, False]


@pytest.mark.parametrize(("u", "triangles"), [(0.25, (-1,)), (0.75, (2, 3))])
def test_what_is_behind_a_hole_is_hit(u: float, triangles: tuple[int, ...]):
    """Behind a panel with holes is one that shows a single point of the same picture: a hole, or solid."""
    near, far = panel(png([[RED, CLEAR], [CLEAR, RED]]), depth=0.5), panel(png([[RED]]))
    both = replace(
        near,
        vertices=np.concatenate([near.vertices, far.vertices]),
        normals=np.concatenate([near.normals, far.normals]),
        triangles=np.concatenate([near.triangles, far.triangles + np.uint32(4)]),
        group_vertices=np.array([0, 8]),
        group_triangles=np.array([0, 4]),
        texture_map=np.full(4, -1, np.int32),
        coordinates=np.concatenate([near.vertices[:, :2], np.tile(np.array([[u, 0.25]], np.float32), (4, 1))]),
    )
    origins, forward = np.array([[0.1, 0.1, 2]], np.float32), np.array([[0, 0, -1]], np.float32)
    assert int(prepare(both).tracer.first_hit(origins, forward).triangle[0]) in triangles


def test_light_passes_through_thin_surfaces_only():
    """The sun is behind: a leaf is brighter than a board, and as bright as before where it is lit."""
    white = png([[(255, 255, 255, 255)] * 2] * 2)
    behind = Look(sun_azimuth=180.0, sun_elevation=20.0)
    board, leaf = (render(panel(white, thin=thin), look=behind) for thin in (False, True))
    assert (leaf > board).all()


def test_a_cut_out_has_the_shape_of_the_model():
    batch = panel(png([[RED, CLEAR], [CLEAR, RED]]))
    picture = RaycastRenderer().cut_out(batch, frame(batch.vertices, 1.0, FRONT), PLAIN)
    expected = np.kron([[255, 0], [0, 255]], np.ones((16, 16), int))
    np.testing.assert_array_equal(picture[:, :, 3], expected)
    # What is transparent has colours of the model nearby.
    assert (picture[:, :, 0] > picture[:, :, 1]).all()


def test_broken_pictures_are_refused():
    with pytest.raises(UsageError, match="cannot be drawn"):
        render(panel(b"\x89PNG\r\n\x1a\n"))


def test_opengl_leaves_surfaces_with_images_to_ray_casting():
    wall = replace(panel(png([[RED, GREEN], [BLUE, RED]]), cut_out=False), coordinates=None)
    camera = frame(wall.vertices, 1.0, FRONT)
    cast = RaycastRenderer().render(wall, camera, PLAIN)
    assert np.array_equal(OpenGLRenderer("none").render(wall, camera, PLAIN), cast)
    middle = cast[8:24, 8:24].reshape(-1, 3).astype(int)
    assert np.unique(np.argmax(middle, axis=1)).tolist() == [0, 1, 2]
