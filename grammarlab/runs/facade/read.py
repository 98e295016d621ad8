"""From a file of labelled boxes or of a building to the file of a facade."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from grammarlab.facade.boxes.assembling import assemble
from grammarlab.facade.file import save_facade
from grammarlab.facade.grids.proposals import with_proposals
from grammarlab.facade.pictures import is_plain, load_picture, picture_size
from grammarlab.facade.reading.choosing import read_annotation
from grammarlab.facade.tree import Facade
from grammarlab.files import check_overwrites


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
        path: an annotation by one of many programs, a table of boxes, or CityGML; docs/facades.md lists the formats.
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
        pixels = picture_size(picture)
    made = assemble(
        annotation,
        width=width,
        height=height,
        tolerance=tolerance,
        split=split,
        picture=picture,
        pixels=pixels,
    )
    facade = with_proposals(made.facade)
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        save_facade(facade, file)
    return ReadResult(facade, file, made.moved, made.notes, time.perf_counter() - start)
