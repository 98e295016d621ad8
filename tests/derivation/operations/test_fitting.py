"""Which asset or image fits a scope best."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from PIL import Image

from grammarlab.derivation import derive
from grammarlab.errors import DerivationError
from grammarlab.language.grammar import Grammar

SIZES = {"cube": (1, 1, 1), "flat": (2, 1, 2), "large": (8, 8, 8), "tower": (1, 9, 1)}


@pytest.fixture
def assets(tmp_path):
    for name, size in SIZES.items():
        corners = [(0, 0, 0), (size[0], 0, 0), (0, size[1], 0), (0, 0, size[2])]
        text = "".join("v {} {} {}\n".format(*corner) for corner in corners)
        (tmp_path / f"{name}.obj").write_text(text + "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n")
    for name, size in {"square": (8, 8), "tall": (4, 8), "wide": (64, 8)}.items():
        Image.new("L", size).save(tmp_path / f"{name}.png")
    return tmp_path


def printed(expression: str, assets, num_models: int = 1) -> list[str]:
    rules = f"Lot --> s(8, 4, 8) print({expression})"
    return list(derive(Grammar.parse(rules), num_models, seed=1, assets=assets).prints)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        # Scales along x, y, z: cube 8 4 8, flat 4 4 4, large 1 0.5 1, tower 8 0.44 8.
        ('assetsSortSize({}, xyz, 0)', "large flat cube tower"),
        ('assetsSortSize({}, y, 0)', "large tower cube flat"),
        ('assetsSortSize({}, y, 0.5)', "large"),
        ('assetsSortSize({}, "xyz", 0.4)', ""),
        ('assetsSortRatio({}, xyz)', "flat cube large tower"),
        ('assetsSortRatio({}, xz)', "cube flat large tower"),
        ('assetBestSize("*.obj", "xyz")', "large"),
        ('assetBestSize("*.obj", "y")', "large"),
        ('assetBestRatio("*.obj", "xy")', "flat"),
        ('assetBestRatio("*.dae", "xy")', ""),
        ('assetFitSize("*.obj", "x", 0.1)', "large"),
        ('assetFitSize("*.obj", "x", 0.001 - 0.0005)', "large"),
        ('assetApproxRatio("*.obj", "xyz", 1)', "flat"),
        ('imageBestRatio("*.png", "xz")', "square"),
        ('imageBestRatio("*.png", "yx")', "tall"),
        ('imagesSortRatio("wide.png;square.png;tall.png", xy)', "square wide tall"),
        ('imageInfo("wide.png", sx) + ";" + imageInfo("wide.png", sy)', "64 8"),
        ('imageInfo("gone.png", sx)', "1"),
    ],
)  # fmt: skip
def test_files_are_sorted_by_how_well_they_fit(assets, expression, expected):
    names = '"cube.obj;flat.obj;large.obj;tower.obj"'
    (text,) = printed(expression.format(names), assets)
    assert [item.partition(".")[0] for item in text.split(";") if item] == expected.split()


@pytest.mark.parametrize("order", list(permutations(SIZES)))
def test_files_that_fit_equally_well_keep_their_order(assets, order):
    names = [f"{name}.obj" for name in order if name != "tower"]
    assert printed(f'assetsSortRatio("{";".join(names)}", xz)', assets) == ["".join(f"{name};" for name in names)]


def test_one_of_the_best_files_is_drawn_evenly_and_recorded(assets):
    rules = 'Lot --> s(8, 4, 8) print(assetApproxSize("*.obj", "xyz", 2)) A'
    forest = derive(Grammar.parse(rules), 2000, seed=3, assets=assets)
    names, counts = np.unique(forest.prints, return_counts=True)
    assert names.tolist() == ["flat.obj", "large.obj"]
    assert abs(counts[0] - 1000) < 100
    assert np.allclose(forest.log_probability(), -np.log(2))
    assert forest.sites[0].kind == "item"


def test_the_best_file_differs_from_shape_to_shape(assets):
    rules = 'Lot --> split(x) { 1 : s(1, 9, 1) A | ~1 : s(8, 8, 8) A }\nA --> print(assetBestSize("*.obj", "xyz"))'
    assert set(derive(Grammar.parse(rules), 1, seed=1, assets=assets).prints) == {"tower.obj", "large.obj"}


def test_no_file_fits_a_flat_scope_along_the_axis_it_lacks(assets):
    rules = (
        'Lot --> print(assetsSortSize("cube.obj;flat.obj;", y, 9)) print(assetsSortSize("cube.obj;flat.obj;", y, 0))'
    )
    assert list(derive(Grammar.parse(rules), 1, seed=1, assets=assets).prints) == ["", "cube.obj;flat.obj;"]


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ('imageInfo("cube.obj", sx)', 'the image "cube.obj" cannot be read'),
        ('imageInfo("../x.png", sx)', "outside the asset folder"),
        ('assetsSortSize("../x.obj;", x, 0)', "outside the asset folder"),
        ("assetBestSize(3, 4)", "expected a string, found a float"),
        ('assetApproxSize("*", "x", "y")', "expected a number last, found a string"),
    ],
)
def test_what_cannot_be_measured_is_named_with_its_place(assets, expression, message):
    with pytest.raises(DerivationError, match=rf"<text>:1:\d+: .*{message}"):
        printed(expression, assets)
