"""Pictures of grids and of edits of our own facades, after figures 3, 8 and 10 to 13 of paper 000."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from grammarlab.facade.drawing import draw
from grammarlab.facade.editing.grids import grid_of, with_grid
from grammarlab.facade.editing.springs import origin_of
from grammarlab.facade.editing.variations import Edit, Variation, applied, unedited
from grammarlab.facade.file import load_facade
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.solve import resize
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.runs.facade.gallery import sheet

SCALE = 28.0
"""Pixels per metre."""
COLORS = ("#E4572E", "#1B8A5A", "#2D6CDF", "#B5179E", "#E0A100")
FACADES = Path(__file__).parents[2] / "grammars" / "facades"
LEVELS = ("storeys", "sashes 2", "panes 17")
"""Grids of the school, each within an element of the one before."""


def called(facade: Facade, *labels: str) -> list[int]:
    """Leaves of these labels."""
    return [leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) in labels]


def panel(facade: Facade, active: Sequence[str]) -> Image.Image:
    """The facade with boxes around the elements of these grids, and circles for their phantoms."""
    picture = Image.fromarray(draw(facade, SCALE)).convert("RGB")
    pen = ImageDraw.Draw(picture)
    for name, color in zip(active, cycle(COLORS), strict=False):
        grid = grid_of(facade, name)
        low = (facade.position[grid.node] - facade.position[0]) * SCALE
        high = low + facade.size[grid.node] * SCALE
        for (left, bottom), (right, top) in zip(low.tolist(), high.tolist(), strict=True):
            pen.rectangle([left, picture.height - top, right, picture.height - bottom], outline=color, width=5)
        for x, y in phantoms(grid, (low + high) / 2.0):
            pen.ellipse([x - 12, picture.height - y - 12, x + 12, picture.height - y + 12], outline=color, width=5)
    return picture


def phantoms(grid: Grid, middle: np.ndarray) -> list[tuple[float, float]]:
    """Positions of the phantoms of a grid, from the centres [E, 2] of its elements."""
    empty = np.argwhere(grid.places() < 0).tolist()
    return [
        (float(middle[grid.column == column, X].mean()), float(middle[grid.row == row, Y].mean()))
        for row, column in empty
    ]


def steps(facade: Facade, edits: Sequence[Edit]) -> list[Image.Image]:
    """The facade, and the result of each edit on the one before, with the grids of the edit."""
    variation, pictures = unedited(facade), [panel(facade, edits[0].grids)]
    for edit in edits:
        variation = applied(variation, edit)
        pictures.append(panel(solved(facade, variation), edit.grids))
    return pictures


def solved(facade: Facade, variation: Variation) -> Facade:
    """A variation with solved sizes."""
    return resize(variation.facade, [], origin_of(facade, variation)).facade


def general_grid() -> list[Image.Image]:
    """Figure 3: a grid with phantoms; grids within elements of grids, on three levels."""
    arcade = load_facade(FACADES / "arcade.json")
    arcade = with_grid(arcade, "openings", called(arcade, "arched window", "square window", "portal"))
    return [panel(arcade, ["openings"]), panel(load_facade(FACADES / "school.json"), LEVELS)]


def three_steps() -> list[Image.Image]:
    """Figure 8: three steps, each with a different active grid."""
    townhouse = load_facade(FACADES / "townhouse.json")
    windows = Edit(("french window",), X, 0, 4)
    return steps(townhouse, [windows, Edit(("french window",), Y, 0, 1), Edit(("shop",), X, 2, 3)])


def inner_and_outer() -> list[Image.Image]:
    """Figure 10: one row of panes more in all sashes, one column of sashes more in all storeys, both."""
    school = load_facade(FACADES / "school.json")
    inner = Edit(tuple(each.name for each in school.grids if each.name.startswith("panes")), Y, 0, 1)
    outer = Edit(tuple(each.name for each in school.grids if each.name.startswith("sashes")), X, 0, 1)
    return [steps(school, [inner])[-1], steps(school, [outer])[-1], steps(school, [inner, outer])[-1]]


def door() -> list[Image.Image]:
    """Figures 11 and 12: a door over two rows among windows of two kinds; one column more, then one row more."""
    arcade = load_facade(FACADES / "arcade.json")
    arcade = with_grid(arcade, "openings", called(arcade, "arched window", "square window", "portal"))
    return steps(arcade, [Edit(("openings",), X, 0, 1), Edit(("openings",), Y, 0, 0)])


def small_grids() -> list[Image.Image]:
    """Figure 13: several small grids without a dominant one."""
    townhouse = load_facade(FACADES / "townhouse.json")
    rows = grid_of(townhouse, "french window").places()
    townhouse = with_grid(with_grid(townhouse, "top", rows[0]), "french window", rows[1:])
    return steps(townhouse, [Edit(("top",), X, 0, 2), Edit(("shop",), X, 2), Edit(("french window",), X, 3)])


FIGURES = {
    "grids": general_grid,
    "steps": three_steps,
    "levels": inner_and_outer,
    "door": door,
    "small": small_grids,
}


def main(folder: Path) -> None:
    """Write each figure as one picture."""
    for name, make in FIGURES.items():
        sheet(make()).save(folder / f"facade_{name}.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
