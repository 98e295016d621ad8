"""The moving picture of samples while a grammar is learned."""

from pathlib import Path

from PIL import Image

from docs.gen.motion import NUMBERS, WIDTH

FILE = Path(__file__).parents[2] / "docs" / "images" / "learned.webp"


def test_the_moving_picture_has_a_sheet_for_each_number_of_scores():
    with Image.open(FILE) as picture:
        assert getattr(picture, "n_frames", 1) == len(NUMBERS)
        assert picture.width == WIDTH
