"""Facade files from labelled boxes, from files of buildings, and from one side of a derived building."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from grammarlab.derivation import derive
from grammarlab.errors import AssetError
from grammarlab.facade.drawing import front, picture_size
from grammarlab.facade.editing.grid_proposals import with_proposals
from grammarlab.facade.file import is_plain, load_picture, save_facade
from grammarlab.facade.file import picture_size as size_in_pixels
from grammarlab.facade.reading.assembling import assemble
from grammarlab.facade.reading.derived_face import face_of
from grammarlab.facade.reading.formats import read_annotation
from grammarlab.facade.tree import Facade, Picture
from grammarlab.facade.values import MOST_BYTES
from grammarlab.files import check_overwrites, read_bounded
from grammarlab.rendering.renderer import LARGEST_SIDE
from grammarlab.runs.sample.records import compiled
from grammarlab.runs.sample.shipped import find_rules

PIXELS_PER_METRE, MAX_PIXELS = 50.0, 1_000_000
"""Largest resolution and largest area of the picture of a side."""
_MARK = "Software", "grammarlab"
"""Text in the pictures drawn here."""


@dataclass(frozen=True, slots=True)
class ReadResult:
    """A facade from another format."""

    facade: Facade
    file: Path | None
    """Written file; None if there is none."""
    snapped: float
    """Largest move of a side by snapping, metres."""
    notes: tuple[str, ...]
    """Notes for the user on the reading."""
    seconds: float
    """Duration of reading and writing."""


def read_facade(
    path: Path | str,
    output: Path | str | None = None,
    *,
    wall: str = "",
    width: float | None = None,
    height: float | None = None,
    tolerance: float | None = None,
    split: bool = False,
) -> ReadResult:
    """Read the facade of a file, propose grids for it, and write it as a facade file if there is an `output`.

    Args:
        path: an annotation by one of many programs, a table of boxes, or CityGML;
            docs/facades/how-to.md lists the formats.
        output: file to write; its picture is written into the same folder. By default nothing is written.
        wall: name of the wall or image in a file with several.
        width: metres; from the file when left out.
        height: metres; from the width and the aspect ratio of the picture when left out.
        tolerance: largest difference of sides in line, as a fraction of the shorter side of the facade; by the unit of
            the file when left out.
        split: whether boxes of a pinwheel may be cut.

    Raises:
        UsageError: If the file is of an unknown kind, or has no such wall.
        FacadeError: If it is broken, or its boxes form a pinwheel.

    >>> import grammarlab as gl
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> boxes = ["label,x,y,width,height", "wall,0,0,4,3", "window,1,1,1,1", "window,2.5,1,1,1"]
    >>> with TemporaryDirectory() as folder:
    ...     _ = (Path(folder) / "wall.csv").write_text(chr(10).join(boxes))
    ...     facade = gl.read_facade(Path(folder) / "wall.csv", width=4.0).facade
    >>> facade.width, facade.labels
    (4.0, ('wall', 'window'))
    """
    start = time.perf_counter()
    path = Path(path)
    file = None if output is None else Path(output)
    if file is not None:
        check_overwrites([file], [path])
    annotation = read_annotation(path, wall)
    picture = pixels = None
    if is_plain(annotation.picture) and (path.parent / annotation.picture).is_file():
        picture = load_picture(annotation.picture, path.parent)
        pixels = size_in_pixels(picture)
    assembled = assemble(
        annotation,
        width=width,
        height=height,
        tolerance=tolerance,
        split=split,
        picture=picture,
        pixels=pixels,
    )
    facade = with_proposals(assembled.facade)
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        save_facade(facade, file)
    return ReadResult(facade, file, assembled.moved, assembled.notes, time.perf_counter() - start)


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
        tolerance: largest difference of sides in line, as in `assemble`.
        split: whether boxes of a pinwheel may be cut.

    Raises:
        GrammarlabError: If the rules, the side or the boxes have an error.
    """
    start = time.perf_counter()
    source = find_rules(rules)
    grammar, _ = compiled(source.text(), source.name)
    forest = derive(grammar, 1, seed=seed, start_rule=start_rule, assets=source.assets)
    name = f"{output.name.removesuffix('.json').removesuffix('.facade')}.png"
    view = face_of(forest, face, parts, name)
    width, height = (view.annotation.picture_area[1] - view.annotation.picture_area[0]).tolist()
    scale = min(PIXELS_PER_METRE, (MAX_PIXELS / (width * height)) ** 0.5, LARGEST_SIDE / max(width, height))
    pixels = picture_size(width, height, scale)
    content = BytesIO()
    mark = PngInfo()
    mark.add_text(*_MARK)
    Image.fromarray(front(view.shapes, *pixels, view.azimuth)).save(content, "PNG", optimize=True, pnginfo=mark)
    assembled = assemble(
        view.annotation,
        tolerance=tolerance,
        split=split,
        picture=Picture(name, content.getvalue()),
        pixels=pixels,
    )
    output.parent.mkdir(parents=True, exist_ok=True)
    if output.exists() and _is_drawn(output.parent / name):  # replaced, with its picture; a photograph is not
        (output.parent / name).unlink()
    facade = with_proposals(assembled.facade)
    save_facade(facade, output)
    return ReadResult(facade, output, assembled.moved, assembled.notes, time.perf_counter() - start)


def _is_drawn(path: Path) -> bool:
    """Whether a file is a picture that was drawn here."""
    try:
        content = read_bounded(path, MOST_BYTES)
        with Image.open(BytesIO(content), formats=("PNG",)) as image:
            return image.info.get(_MARK[0]) == _MARK[1]
    except (AssetError, OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return False
