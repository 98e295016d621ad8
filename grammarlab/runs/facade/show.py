"""Facades as files for other programs."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from grammarlab.errors import UsageError
from grammarlab.export.save import FORMATS, SaveOptions, save
from grammarlab.facade.showing.drawing import draw
from grammarlab.facade.showing.scene import realize_facade
from grammarlab.facade.showing.svg import svg
from grammarlab.facade.tree import Facade
from grammarlab.facade.writing.pictures import store_as_assets
from grammarlab.files import atomic_file, write_text

PIXELS_PER_METRE = 50.0
ENDINGS = ("svg", "png", *FORMATS)


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
    if ending not in ENDINGS:
        raise UsageError(f"{path.name!r}: expected a file that ends in one of .{', .'.join(ENDINGS)}.")
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
