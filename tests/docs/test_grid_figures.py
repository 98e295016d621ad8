"""The page of figures: its pictures can be made, and the tests that it names are there."""

import re
from pathlib import Path

from docs.gen.grid_figures import three_steps

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "facades" / "grids.md").read_text(encoding="utf-8")


def test_every_figure_has_a_test_that_is_there_or_a_picture() -> None:
    rows = re.findall(r"^\| (\d+) \|.*\|(.*)\|$", PAGE, re.MULTILINE)
    assert [int(number) for number, _ in rows] == [3, 4, 5, 6, 8, 10, 11, 12, 13]
    code = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests" / "facade").rglob("test_*.py"))
    for _, where in rows:
        named = re.findall(r"`(test_\w+)`", where)
        assert named or "picture" in where
        assert all(f"def {name}(" in code for name in named)


def test_steps_are_drawn() -> None:
    pictures = three_steps()
    assert len({picture.size for picture in pictures}) >= 3
    assert all(len(picture.getcolors(1 << 20) or ()) > 100 for picture in pictures)
