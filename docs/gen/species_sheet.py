"""Picture of one tree of each shipped species: `python -m docs.gen.species_sheet`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from grammarlab.randomness import root_keys
from grammarlab.runs.sample.contact_sheet import draw_page, draw_tiles, lay_out
from grammarlab.runs.sample.shipped import find_rules
from grammarlab.runs.work.executors import SERIAL
from grammarlab.scene import TriangleBatch, triangles
from grammarlab.trees.accepted_trees import accepted_rows
from grammarlab.trees.growth import grow
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.species_file import parse

SPECIES = ("oak", "birch", "spruce", "poplar", "weeping_willow", "palm", "apple", "shrub")
PICTURE = Path(__file__).parents[1] / "images" / "species.jpg"
_AREA = 300 * 340
"""Pixels of each tree."""


def tree(name: str, model: int = 1, seed: int = 3) -> TriangleBatch:
    """A tree of a species."""
    source = find_rules(name)
    species = parse(source.text(), name)
    trees = accepted_rows(species, root_keys(seed, np.array([model])))
    return triangles(realize_trees(grow(trees.rows, trees.keys), species.look)).model(0)


def main() -> None:
    """Draw it."""
    models = [tree(name) for name in SPECIES]
    tiles = draw_tiles(models, _AREA, SERIAL)
    page = lay_out(len(models), 4, tiles.width, tiles.height)
    heights = [f"{np.ptp(model.vertices[:, 1]):.0f} m" for model in models]
    captions = [(name.replace("_", " "), height) for name, height in zip(SPECIES, heights, strict=True)]
    Image.fromarray(draw_page(page, tiles.pictures, captions, ("Eight species", "each to its own scale"))).save(
        PICTURE, quality=85, optimize=True
    )


if __name__ == "__main__":
    main()
