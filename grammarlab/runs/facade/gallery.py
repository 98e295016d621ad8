"""Facades as files for other programs, and several facades in one folder with a picture of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

from grammarlab.errors import UsageError
from grammarlab.export.save import FORMATS, SaveOptions, save
from grammarlab.facade.drawing import draw, svg
from grammarlab.facade.file import save_facade
from grammarlab.facade.grammar.leaf_looks import store_as_assets
from grammarlab.facade.scene import realize_facade
from grammarlab.facade.sizes.size_wishes import Wish
from grammarlab.facade.tree import Facade
from grammarlab.files import atomic_file, write_bytes, write_text
from grammarlab.runs.work.run_folder import only_run_in, replace_written

PIXELS_PER_METRE = 50.0
"""Largest resolution of the pictures of a gallery, and default resolution of a picture."""
_ENDINGS = ("svg", "png", *FORMATS)
_CONTACT, GALLERY = "contact.png", "gallery"
"""The picture of all facades, and the name of the command in the record of written files."""
_FACADE = ".facade.json"
_MAX_SIDE = 640
"""Largest side of a picture of a gallery, pixels."""
_SAMPLES_PER_PIXEL = 1
"""Samples per pixel: most edges are along pixels, and pictures are needed at once."""
_SHEET_WIDTH, _MARGIN = 2400, 24
"""Width of the contact sheet, and distance between facades, pixels."""


@dataclass(frozen=True, slots=True)
class Gallery:
    """Facades with their drawings; all pictures have one scale."""

    facades: Sequence[Facade]
    drawings: Sequence[str]
    """SVG of each facade."""
    pictures: Sequence[Image.Image]


def show_facade(facade: Facade, path: Path | str, pixels_per_metre: float = PIXELS_PER_METRE) -> Path:
    """Write a facade as a drawing, a picture or a model, by the suffix of the file.

    Raises:
        UsageError: If the suffix is unknown.
        FacadeError: If the picture would be too large.

    >>> import grammarlab as gl
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> arcade = gl.load_facade(gl.examples_folder() / "facades" / "arcade.json")
    >>> with TemporaryDirectory() as folder:
    ...     gl.show_facade(arcade, Path(folder) / "arcade.png", 10).stat().st_size > 1000
    True
    """
    path = Path(path)
    ending = path.suffix.lower().removeprefix(".")
    if ending not in _ENDINGS:
        raise UsageError(f"{path.name!r}: expected a file that ends in one of .{', .'.join(_ENDINGS)}.")
    path.parent.mkdir(parents=True, exist_ok=True)
    if ending == "svg":
        write_text(path, svg(facade))
    elif ending == "png":
        picture = Image.fromarray(draw(facade, pixels_per_metre))
        with atomic_file(path) as part:
            picture.save(part)
    else:
        with TemporaryDirectory() as folder:
            store_as_assets(facade, Path(folder))
            save(realize_facade(facade), path, options=SaveOptions(assets=Path(folder)))
    return path


def save_gallery(
    facades: Sequence[Facade], folder: Path, source: Path | None = None, locks: Sequence[Sequence[Wish]] = ()
) -> list[Path]:
    """Write each facade as ``001.facade.json``, ``001.svg`` and ``001.png``, and all as ``contact.png``.

    Everything is drawn before the first file is written. Other files of the earlier run are removed unless they were
    changed: a folder shows one run.

    Args:
        facades: the facades, at least one.
        folder: where to write; created if missing.
        source: the edited file; refused if a run into the folder overwrites or removes it.
        locks: locks of each facade; none when left out.

    Returns:
        The files of the facades.

    Raises:
        UsageError: If the source would be overwritten or removed, or another run is writing into the folder.
        FacadeError: If a facade cannot be drawn, or a file with the name of one of its pictures has other content.
    """
    gallery = draw_gallery(facades, folder, source)
    with only_run_in(folder):
        files, written = write_gallery(gallery, folder, locks)
        replace_written(folder, GALLERY, written, [source] if source else ())
    return files


def draw_gallery(facades: Sequence[Facade], folder: Path, source: Path | None = None) -> Gallery:
    """Drawings of facades for `write_gallery`; nothing is written.

    Raises:
        UsageError: If the source would be overwritten or removed.
        FacadeError: If a facade cannot be drawn.
    """
    names = _names(len(facades))
    files = {folder / f"{name}{_FACADE}" for name in names} | set(folder.glob(f"[0-9][0-9][0-9]{_FACADE}"))
    if source and any(file.exists() and file.samefile(source) for file in files):
        raise UsageError(f"{source} would be overwritten or removed: write to another folder.")
    longest = max(max(facade.width, facade.height) for facade in facades)
    scale = min(PIXELS_PER_METRE, _MAX_SIDE / longest)
    facades = [_renamed(facade, {_CONTACT, *(f"{name}.png" for name in names)}) for facade in facades]
    drawings = [svg(facade) for facade in facades]
    pictures = [Image.fromarray(draw(facade, scale, _SAMPLES_PER_PIXEL)) for facade in facades]
    return Gallery(facades, drawings, pictures)


def write_gallery(
    gallery: Gallery, folder: Path, locks: Sequence[Sequence[Wish]] = ()
) -> tuple[list[Path], list[Path]]:
    """Write a gallery into a folder that the caller has locked (`only_run_in`).

    Returns:
        The files of the facades, and all files except the pictures that facades show.
    """
    names = _names(len(gallery.facades))
    files = [folder / f"{name}{_FACADE}" for name in names]
    locks = locks or [()] * len(files)
    written = [folder / _CONTACT, *files]
    for name, file, facade, facade_locks, drawing, picture in zip(
        names, files, gallery.facades, locks, gallery.drawings, gallery.pictures, strict=True
    ):
        save_facade(facade, file, facade_locks)
        write_text(folder / f"{name}.svg", drawing)
        write_bytes(folder / f"{name}.png", png_of(picture))
        written += [folder / f"{name}.svg", folder / f"{name}.png"]
    write_bytes(folder / _CONTACT, png_of(sheet(gallery.pictures)))
    return files, written


def sheet(pictures: Sequence[Image.Image]) -> Image.Image:
    """Pictures side by side on white, in as many rows as needed, aligned at the bottom of each row."""
    rows: list[list[Image.Image]] = [[]]
    for picture in pictures:
        if rows[-1] and _MARGIN + sum(image.width + _MARGIN for image in (*rows[-1], picture)) > _SHEET_WIDTH:
            rows.append([])
        rows[-1].append(picture)
    width = max(_MARGIN + sum(image.width + _MARGIN for image in row) for row in rows)
    bottom = np.cumsum([max(image.height for image in row) + _MARGIN for row in rows]).tolist()
    page = Image.new("RGB", (width, bottom[-1] + _MARGIN), "white")
    for row, floor in zip(rows, bottom, strict=True):
        x = _MARGIN
        for picture in row:
            page.paste(picture, (x, floor - picture.height))
            x += picture.width + _MARGIN
    return page


def png_of(picture: Image.Image) -> bytes:
    """Content of a PNG file."""
    content = BytesIO()
    picture.save(content, "PNG")
    return content.getvalue()


def _names(num: int) -> list[str]:
    return [f"{number:03}" for number in range(1, num + 1)]


def _renamed(facade: Facade, used_names: set[str]) -> Facade:
    """The facade, with other names for pictures whose names the drawings need."""
    pictures = [
        replace(picture, name=f"shown-{picture.name}") if picture.name.lower() in used_names else picture
        for picture in facade.pictures
    ]
    return replace(facade, pictures=tuple(pictures))
