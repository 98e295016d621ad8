import numpy as np
from PIL import ImageColor

from docs.gen.real_facades import drawing, row
from grammarlab.facade.looks import look_of
from tests.facade.grammar.houses import of_columns


def test_leaves_have_the_colours_of_their_labels() -> None:
    facade = of_columns(["WDW", "WWW"])
    pixels = np.asarray(drawing(facade, 20.0))
    for leaf in facade.leaves.tolist():
        x, y = (20.0 * (facade.position[leaf] + 0.5 * facade.size[leaf])).astype(int)
        assert tuple(pixels[len(pixels) - 1 - y, x]) == ImageColor.getrgb(look_of(facade.name_of(leaf)).color)


def test_drawings_stand_on_one_ground() -> None:
    facades = [of_columns(["WDW", *["WWW"] * rows]) for rows in (1, 3)]
    image = np.asarray(row(facades)).astype(int)
    assert image.shape == (250, 1240, 3)
    filled = (image != 255).any(axis=2)
    ends = np.flatnonzero(np.diff(filled[-1].astype(int)))
    assert len(ends) == 3  # two drawings, the first one from the left side
    assert filled[0, ends[1] + 1 : ends[2]].all()
    assert not filled[0, : ends[0]].any()
