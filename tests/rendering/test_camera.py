"""Cameras: what is framed is in the picture, and fills it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.rendering.camera import Camera, View, frame, frame_alike, seen_aspect

coordinates = st.floats(-1e4, 1e4, width=32)
points = st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=1, max_size=12).map(
    lambda rows: np.array(rows, np.float32)
)
views = st.builds(
    View, st.floats(-180, 180), st.floats(-80, 80), st.sampled_from([0.0, 20.0, 60.0]), st.floats(0.0, 0.3)
)
aspects = st.floats(0.3, 3.0)


def places(camera: Camera, at: np.ndarray, aspect: float) -> np.ndarray:
    """[P, 2] where points lie in the picture, -1..1: the inverse of `Camera.rays`."""
    seen = (at - camera.position) @ camera.axes.T
    depth = 1.0 if camera.parallel else -seen[:, 2:]
    return seen[:, :2] / depth / camera.half_height / (aspect, 1.0)


@given(points, views, aspects)
def test_every_point_is_in_the_picture_and_inside_its_margin(at, view, aspect):
    found = np.abs(places(frame(at, aspect, view), at.astype(float), aspect))
    assert found.max() <= 1 - 2 * view.margin + 1e-3


@given(points, views, aspects)
def test_every_point_is_in_front_of_the_camera(at, view, aspect):
    camera = frame(at, aspect, view)
    assert ((at - camera.position) @ camera.axes[2] < 0).all()


@given(points, views, aspects)
def test_a_model_with_some_breadth_reaches_the_margin_on_both_sides(rows, view, aspect):
    corners = np.array([[x, y, z] for x in (-1e4, 1e4) for y in (-1e4, 1e4) for z in (-1e4, 1e4)], np.float32)
    at = np.concatenate([rows, corners])
    found = places(frame(at, aspect, view), at.astype(float), aspect)
    inside = 1 - 2 * view.margin
    gaps = np.abs(np.stack([found.min(axis=0) + inside, found.max(axis=0) - inside]))
    assert gaps.max(axis=0).min() < 1e-3


@given(views, aspects, points)
def test_rays_go_through_the_places_that_they_are_asked_for(view, aspect, at):
    camera = frame(at, aspect, view)
    x, y = np.array([-1.0, 0.25, 1.0], np.float32), np.array([1.0, -0.5], np.float32)
    origins, directions = camera.rays(x, y, aspect)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1, atol=1e-5)
    size = float(np.linalg.norm(camera.position - at.mean(axis=0))) + 1
    back = places(camera, origins.astype(float) + size * directions, aspect)
    error = 1e-3 + 1e-6 * float(np.abs(camera.position).max()) / (
        size * camera.half_height if not camera.parallel else camera.half_height
    )
    assert np.abs(back - np.stack([np.tile(x, 2), np.repeat(y, 3)], axis=1)).max() < error


def test_models_framed_alike_have_one_scale_and_one_direction():
    small, large = np.array([[0, 0, 0], [1, 1, 1]], np.float32), np.array([[50, 0, 50], [59, 9, 59]], np.float32)
    one, other = frame_alike([small, large], 1.0, View())
    assert np.array_equal(one.axes, other.axes)
    assert one.half_height == other.half_height
    middles = np.array([[0.5, 0, 0.5], [54.5, 0, 54.5]])
    assert one.position - middles[0] == pytest.approx(other.position - middles[1])


def test_a_camera_in_other_units_sees_the_same():
    at = np.array([[3, 0, 1], [9, 5, 2], [4, 4, 4]], np.float32)
    for field_of_view in (0.0, 30.0):
        camera = frame(at, 1.5, View(field_of_view=field_of_view))
        origin, unit = np.array([5.0, 2.0, 1.0]), 7.0
        assert places(camera.seen_from(origin, unit), (at - origin) / unit, 1.5) == pytest.approx(
            places(camera, at, 1.5)
        )


@pytest.mark.parametrize(
    ("at", "expected"), [([[0, 0, 0], [8, 2, 0]], 4.0), ([[0, 0, 0]], 1.0), ([[0, 0, 0], [0, 5, 0]], 1.0)]
)
def test_the_aspect_is_width_over_height_as_seen(at, expected):
    assert seen_aspect(np.array(at, np.float32), View(azimuth=0.0, elevation=0.0)) == pytest.approx(expected)


@pytest.mark.parametrize(
    "values", [{"elevation": 90.0}, {"field_of_view": 121.0}, {"margin": 0.5}, {"azimuth": float("nan")}]
)
def test_views_that_make_no_sense_are_refused(values):
    with pytest.raises(UsageError, match=f"{next(iter(values))} of the view"):
        View(**values)
