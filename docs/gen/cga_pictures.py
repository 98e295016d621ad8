"""Pictures of the examples of operations: `python -m docs.gen.cga_pictures` draws them."""

from __future__ import annotations

import numpy as np
from PIL import Image

from docs.gen.cga_reference import LOT, PICTURES, Operation, all_operations
from docs.gen.reference import DOCS
from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.contact_sheet import draw_tiles
from grammarlab.runs.work.executors import SERIAL
from grammarlab.scene import realize, triangles

FOLDER = DOCS / PICTURES
_AREA = 200 * 140
"""Pixels of a picture."""
_COLORS = 48
"""Colours of its palette, which keep the files small."""


def picture(operation: Operation) -> Image.Image:
    """The example of an operation."""
    forest = derive(Grammar.parse(operation.example), 1, 1, footprint=LOT)
    batch = triangles(realize(forest)).model(0)
    drawn = draw_tiles([batch], _AREA, SERIAL).pictures[0]
    return Image.fromarray(np.ascontiguousarray(drawn)).quantize(_COLORS)


def main() -> None:
    """Draw all pictures, and remove those of operations that are gone."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for path in FOLDER.glob("*.png"):
        path.unlink()
    for operation in all_operations():
        if operation.has_picture:
            picture(operation).save(FOLDER / f"{operation.name}.png", optimize=True)


if __name__ == "__main__":
    main()
