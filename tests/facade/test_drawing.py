from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grammarlab.errors import FacadeError
from grammarlab.facade.drawing import draw
from grammarlab.facade.file import load_facade
from grammarlab.facade.tree import Facade, Picture
from tests.facade.grammar.houses import house
from tests.facade.test_scene import pictured


def noise(facade: Facade, pixels: int) -> tuple[Facade, np.ndarray]:
    """A facade that shows a picture of noise, and the picture [H, W, 3]."""
    from io import BytesIO

    size = (round(facade.height * pixels), round(facade.width * pixels), 3)
    picture = np.random.default_rng(0).integers(0, 256, size, dtype=np.uint8)
    content = BytesIO()
    Image.fromarray(picture).save(content, "PNG")
    shown = replace(pictured(facade), pictures=(Picture("a.png", content.getvalue()),))
    return shown, picture


def test_leaves_that_show_one_picture_side_by_side_show_it_without_seams() -> None:
    # At ten pixels per metre, all sides of leaves are between whole pixels.
    shown, picture = noise(house(columns=3, rows=2), 10)
    assert np.array_equal(draw(shown, 10), picture)


def test_fewer_samples_give_the_same_picture_away_from_edges() -> None:
    coarse, fine = (draw(house(columns=2, rows=1), 24, samples).astype(int) for samples in (1, 2))
    assert coarse.shape == fine.shape
    assert np.quantile(np.abs(coarse - fine).max(axis=2), 0.75) <= 2
    assert not np.array_equal(coarse, fine)


def test_a_repeated_leaf_shows_its_picture_again() -> None:
    shown, _ = noise(house(columns=3, rows=2), 10)
    windows = [leaf for leaf in shown.leaves.tolist() if shown.name_of(leaf) == "window"]
    window = shown.window.copy()
    window[windows] = window[windows[0]]
    drawn = draw(replace(shown, window=window), 10)
    boxes = []
    for leaf in windows:
        low, high = (shown.position[leaf] * 10).round().astype(int), (shown.position[leaf] + shown.size[leaf]) * 10
        high = high.round().astype(int)
        boxes.append(drawn[len(drawn) - high[1] : len(drawn) - low[1], low[0] : high[0]])
    assert len(boxes) > 2
    assert all(np.array_equal(box, boxes[0]) for box in boxes)


def test_what_has_no_picture_looks_like_its_label() -> None:
    facade = house(columns=1, rows=2)
    drawn = draw(facade, 20).astype(int)
    assert drawn.shape == (round(facade.height * 20), round(facade.width * 20), 3)
    window = next(leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) == "window")
    x, y = ((facade.position[window] + facade.size[window] / 2) * 20).astype(int)
    wall, glass = drawn[-4, 4], drawn[len(drawn) - y, x]
    assert wall[0] > wall[2] + 20
    assert glass.sum() < wall.sum() - 150


def test_too_large_and_broken_pictures_are_explained() -> None:
    with pytest.raises(FacadeError, match="is too large"):
        draw(house(columns=3, rows=2), 1e5)
    with pytest.raises(FacadeError, match=r"The picture 'a\.png' cannot be read"):
        draw(replace(pictured(house(columns=1, rows=1)), pictures=(Picture("a.png", b"\x89PNG broken"),)), 10)


def test_surrounds_of_arched_windows_are_within_their_rectangles_and_so_move_with_them() -> None:
    arcade = load_facade(Path(__file__).parents[2] / "grammars" / "facades" / "arcade.json")
    blue = draw(arcade, 50.0)[:, :, 2]
    windows = arcade.leaves[arcade.label[arcade.leaves] == arcade.labels.index("arched window")]
    low, high = arcade.position[windows], arcade.position[windows] + arcade.size[windows]
    side = np.rint(50.0 * low[:, 0]).astype(np.int64)
    rows = len(blue) - np.rint(50.0 * (0.75 * low[:, 1] + 0.25 * high[:, 1])).astype(np.int64)
    # Only the surround has so much blue.
    beside, inside = (blue[rows[:, None], side[:, None] + np.array(columns)] for columns in ((-8, -5), (2, 5)))
    assert len(windows) == 13
    assert beside.max() < 200 < inside.min()
