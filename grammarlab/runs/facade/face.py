"""From one side of a derived building to the file of a facade, with its picture."""

from __future__ import annotations

import time
from collections.abc import Collection
from io import BytesIO
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from grammarlab.derivation import derive
from grammarlab.errors import AssetError
from grammarlab.facade.boxes.assembling import assemble
from grammarlab.facade.file import save_facade
from grammarlab.facade.grids.proposals import with_proposals
from grammarlab.facade.pictures import MOST_BYTES
from grammarlab.facade.reading.face import face_of
from grammarlab.facade.showing.drawing import front, picture_size
from grammarlab.facade.tree import Picture
from grammarlab.files import read_bounded
from grammarlab.rendering.renderer import LARGEST_SIDE
from grammarlab.runs.facade.read import ReadResult
from grammarlab.runs.requests.examples import find_rules
from grammarlab.runs.sampling.derive_batch import compiled

PIXELS_PER_METRE, MOST_PIXELS = 50.0, 1_000_000
"""Largest resolution and largest area of the picture of a side."""
_MARK = "Software", "grammarlab"
"""Text in the pictures drawn here."""


def read_face(
    rules: str,
    output: Path,
    face: str,
    parts: Collection[str] = (),
    *,
    seed: int = 0,
    start_rule: str | None = None,
    tolerance: float | None = None,
    split: bool = False,
) -> ReadResult:
    """Make a facade of a side of the first model of a grammar, with grids and a picture of that side.

    Args:
        rules: a rule file, or the name of a shipped grammar.
        output: where to write; the picture has the same name, in the same folder.
        face: ``front``, ``right``, ``back`` or ``left``, see `face_of`.
        parts: symbols whose shapes become boxes; all leaves if empty.
        seed: seed of the model.
        start_rule: start symbol, in place of the one that the grammar marks.
        tolerance: see `assemble`.
        split: whether boxes of a pinwheel may be cut.

    Raises:
        GrammarlabError: If the rules, the side or the boxes have an error.
    """
    start = time.perf_counter()
    source = find_rules(rules)
    grammar, _ = compiled(source.text(), source.name)
    forest = derive(grammar, 1, seed=seed, start_rule=start_rule, assets=source.assets)
    name = f"{output.name.removesuffix('.json').removesuffix('.facade')}.png"
    found = face_of(forest, face, parts, name)
    width, height = (found.annotation.picture_area[1] - found.annotation.picture_area[0]).tolist()
    scale = min(PIXELS_PER_METRE, (MOST_PIXELS / (width * height)) ** 0.5, LARGEST_SIDE / max(width, height))
    pixels = picture_size(width, height, scale)
    content = BytesIO()
    mark = PngInfo()
    mark.add_text(*_MARK)
    Image.fromarray(front(found.shapes, *pixels, found.azimuth)).save(content, "PNG", optimize=True, pnginfo=mark)
    made = assemble(
        found.annotation,
        tolerance=tolerance,
        split=split,
        picture=Picture(name, content.getvalue()),
        pixels=pixels,
    )
    output.parent.mkdir(parents=True, exist_ok=True)
    if output.exists() and _is_drawn(output.parent / name):  # replaced, with its picture; a photograph is not
        (output.parent / name).unlink()
    facade = with_proposals(made.facade)
    save_facade(facade, output)
    return ReadResult(facade, output, made.moved, made.notes, time.perf_counter() - start)


def _is_drawn(path: Path) -> bool:
    """Whether a file is a picture that was drawn here."""
    try:
        content = read_bounded(path, MOST_BYTES)
        with Image.open(BytesIO(content), formats=("PNG",)) as image:
            return image.info.get(_MARK[0]) == _MARK[1]
    except (AssetError, OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return False
