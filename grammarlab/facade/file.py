"""Facades as JSON files, with their pictures in the same folder; docs/facades/file.md describes the format.

A file may come from a stranger: its values are bounded and checked before a facade is made.
"""

from __future__ import annotations

import io
import json
import re
import warnings
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.arrays import Floats, Ints, offsets_from_counts
from grammarlab.errors import FacadeError, shown
from grammarlab.facade.grid import Grid
from grammarlab.facade.size_locks import lock_values, parsed_locks
from grammarlab.facade.sizes.size_wishes import Wish
from grammarlab.facade.tree import LEAF, Facade, Picture, X, Y, check
from grammarlab.facade.values import (
    a_list,
    a_number,
    a_text,
    a_whole_number,
    an_object,
    numbers,
    parse_json,
    read_bounded,
)
from grammarlab.files import rewrite_text, write_bytes, write_text

MOST_BYTES = 64 * 2**20
"""Largest size of the file of a picture."""
MOST_PIXELS = 100_000_000
"""Largest number of pixels of a picture."""
_PLAIN_NAME = re.compile(r"[\w-][\w .()+-]{0,150}\.(png|jpg|jpeg)", re.IGNORECASE)
_PICTURE_FORMATS = ("PNG", "JPEG")
FORMAT = "grammarlab facade"
VERSION = 1
_MOST_NODES = 1_000_000
_MOST_LABELS, _MOST_PICTURES, _MOST_GRIDS, _MOST_CORNERS = 1_000_000, 1_000, 10_000, 100_000
_MOST_PLACES = 10_000_000
"""Largest number of rows times columns of a grid."""
_AXES = {X: "x", Y: "y"}
_REACH = 0.5 + 1e-6
"""Largest distance from the middle of the range 0 to 1, rounding errors included."""
_ALL = [0.0, 0.0, 1.0, 1.0]


def save_facade(facade: Facade, path: Path | str, locks: Sequence[Wish] = (), *, edited: bool = False) -> Path:
    """Write a facade with its locks, and its pictures into the same folder.

    Args:
        facade: the facade.
        path: path of the file.
        locks: locks of the facade.
        edited: whether the file was opened for editing, so that a link to it and its permissions stay.

    Raises:
        FacadeError: If the facade is invalid, or a file with the name of a picture has other content.

    >>> import grammarlab as gl
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> arcade = gl.load_facade(gl.examples_folder() / "facades" / "arcade.json")
    >>> with TemporaryDirectory() as folder:
    ...     file = gl.save_facade(arcade, Path(folder) / "arcade.json")
    ...     len(gl.load_facade(file)) == len(arcade)
    True
    """
    path = Path(path)
    text = dumps(check(facade), locks)
    store_pictures(facade.pictures, path.parent)
    (rewrite_text if edited else write_text)(path, text)
    return path


def load_facade(path: Path | str) -> Facade:
    """Read a facade with its pictures.

    Raises:
        FacadeError: If the file is not a facade, or too large; with the position of the mistake.

    >>> import grammarlab as gl
    >>> arcade = gl.load_facade(gl.examples_folder() / "facades" / "arcade.json")
    >>> [grid.name for grid in arcade.grids]
    ['arched window', 'band', 'square window']
    """
    return load_locked(Path(path))[0]


def load_locked(path: Path) -> tuple[Facade, tuple[Wish, ...]]:
    """Read a facade with its pictures and locks.

    Raises:
        FacadeError: If the file is not a facade, or too large; with the position of the mistake.
    """
    content = read_bounded(path)
    try:
        return loads_locked(content, lambda name: load_picture(name, path.parent))
    except FacadeError as error:
        raise FacadeError(f"{path.name}: {error}") from error


def dumps(facade: Facade, locks: Sequence[Wish] = ()) -> str:
    """The text of a file: one line per node, numbers to the last bit."""
    names = [picture.name for picture in facade.pictures]
    for list_name, entries in (("labels", facade.labels), ("pictures", names)):
        if len(set(entries)) < len(entries):
            raise FacadeError(f"The {list_name} of a facade have different names, found {shown(list(entries))}.")
    head = {"format": FORMAT, "version": VERSION, "labels": facade.labels, "pictures": names}
    lines = [f'"{key}": {_line(value)},\n' for key, value in head.items()]
    nodes = ",\n".join(_line(_node_values(facade, node)) for node in range(len(facade)))
    grids = ",\n".join(_line(_grid_values(grid)) for grid in facade.grids)
    lock_lines = ",\n".join(_line(values) for values in lock_values(locks))
    tail = f'],\n"locks": [\n{lock_lines}\n' if locks else ""
    return f'{{{"".join(lines)}"nodes": [\n{nodes}\n],\n"grids": [\n{grids}\n{tail}]}}\n'


def loads_locked(content: bytes, picture_named: Callable[[str], Picture]) -> tuple[Facade, tuple[Wish, ...]]:
    """The facade of a file and its locks.

    Args:
        content: the file.
        picture_named: function that returns the picture with a name.

    Raises:
        FacadeError: If it is not a facade; with the position of the mistake.
    """
    document = parse_json(content)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise FacadeError(f'This is not a facade: expected an object with "format": "{FORMAT}".')
    if document.get("version") != VERSION:
        raise FacadeError(f"Expected version {VERSION} of the format, found {shown(document.get('version'))}.")
    labels = _names(document.get("labels"), "labels", _MOST_LABELS)
    pictures = _names(document.get("pictures", []), "pictures", _MOST_PICTURES)
    entries = a_list(document.get("nodes"), "nodes", _MOST_NODES)
    nodes = [(f"Node {index}", an_object(entry, f"Node {index}")) for index, entry in enumerate(entries)]
    outlines = [_outline(node, where) for where, node in nodes]

    def column(key: str) -> list[float]:
        return [a_number(node.get(key), f"{where}, {key}") for where, node in nodes]

    parents = [a_whole_number(node.get("parent"), f"{where}, parent", -1, len(nodes)) for where, node in nodes]
    facade = Facade(
        parent=np.array(parents, dtype=np.int64),
        axis=np.array([_axis(node, where) for where, node in nodes], dtype=np.int8),
        position=np.array([column("x"), column("y")]).T.copy(),
        size=np.array([column("width"), column("height")]).T.copy(),
        label=_indices(nodes, "label", labels),
        labels=labels,
        outline_offsets=offsets_from_counts(np.array([len(outline) for outline in outlines], dtype=np.int64)),
        outline_points=np.vstack([np.zeros((0, 2)), *(outline for outline in outlines if len(outline))]),
        pictures=tuple(picture_named(name) for name in pictures),
        picture=_indices(nodes, "picture", pictures),
        window=np.array([_window(node, where) for where, node in nodes]).reshape(-1, 4),
        grids=_grids(document.get("grids", []), len(nodes)),
    )
    return check(facade), parsed_locks(document.get("locks", []), facade)


def load_picture(name: str, folder: Path) -> Picture:
    """The picture with a name in a folder.

    Raises:
        FacadeError: If the name is not plain, or the file is missing, a link out of the folder, too large, or not a
            picture.
    """
    if not is_plain(name):
        raise FacadeError(
            f"The picture {shown(name)}: expected the plain name of a .png or .jpg file in the folder of the facade."
        )
    path = folder / name
    if not path.is_file() or path.resolve().parent != folder.resolve():
        raise FacadeError(f"The picture {shown(name)} is not in the folder of the facade.")
    picture = Picture(name, read_bounded(path, MOST_BYTES))
    picture_size(picture)
    return picture


def store_pictures(pictures: Iterable[Picture], folder: Path) -> None:
    """Write pictures into a folder, each under its name.

    Raises:
        FacadeError: If a name is not plain, or belongs to another existing file. Nothing is written then.
    """
    new = []
    for picture in pictures:
        if not is_plain(picture.name):
            raise FacadeError(f"The picture {shown(picture.name)}: expected a plain name that ends in .png or .jpg.")
        path = folder / picture.name
        if not path.exists():
            new.append(picture)
        elif path.stat().st_size != len(picture.content) or path.read_bytes() != picture.content:
            raise FacadeError(f"{path} exists and differs from the picture of this facade: write into another folder.")
    for picture in new:
        write_bytes(folder / picture.name, picture.content)


def picture_size(picture: Picture) -> tuple[int, int]:
    """Width and height in pixels; only the head of the file is read.

    Raises:
        FacadeError: If it is not a PNG or JPEG file, or has more than `MOST_PIXELS`.
    """
    from PIL import Image  # noqa: PLC0415  # facades without pictures do without

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # large pictures are refused below
            with Image.open(io.BytesIO(picture.content), formats=_PICTURE_FORMATS) as image:
                width, height = image.size
    except Exception as error:  # readers raise any exception for a broken file
        raise FacadeError(f"The picture {shown(picture.name)} is not a PNG or JPEG file: {error}.") from error
    if width * height > MOST_PIXELS:
        raise FacadeError(
            f"The picture {shown(picture.name)} has {width} x {height} pixels; expected at most {MOST_PIXELS:,}."
        )
    return width, height


def is_plain(name: str) -> bool:
    """Whether a name is that of a picture file in the same folder."""
    return _PLAIN_NAME.fullmatch(name) is not None


def _line(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _node_values(facade: Facade, node: int) -> dict[str, Any]:
    """Values of a node that differ from the defaults."""
    (x, y), (width, height) = facade.position[node].tolist(), facade.size[node].tolist()
    values: dict[str, Any] = {"parent": int(facade.parent[node]), "x": x, "y": y, "width": width, "height": height}
    if facade.axis[node] != LEAF:
        values["axis"] = _AXES[int(facade.axis[node])]
    if facade.label[node] >= 0:
        values["label"] = facade.name_of(node)
    if len(corners := facade.outline(node)):
        values["outline"] = corners.tolist()
    if facade.picture[node] >= 0:
        values["picture"] = facade.pictures[int(facade.picture[node])].name
    if (window := facade.window[node].tolist()) != _ALL:
        values["window"] = window
    return values


def _grid_values(grid: Grid) -> dict[str, Any]:
    cells = zip(grid.node.tolist(), grid.row.tolist(), grid.column.tolist(), strict=True)
    elements = [{"node": node, "row": row, "column": column} for node, row, column in cells]
    return {"name": grid.name, "elements": elements}


def _names(value: Any, where: str, most: int) -> tuple[str, ...]:
    names = tuple(a_text(name, where) for name in a_list(value, where, most))
    if len(set(names)) < len(names):
        raise FacadeError(f"{where}: expected unique names.")
    return names


def _outline(node: dict[str, Any], where: str) -> Floats:
    corners = a_list(node.get("outline", []), f"{where}, outline", _MOST_CORNERS)
    points = np.array([numbers(corner, f"{where}, outline", 2) for corner in corners]).reshape(-1, 2)
    if 0 < len(points) < 3 or (np.abs(points - 0.5) > _REACH).any():
        raise FacadeError(f"{where}, outline: expected at least 3 corners from 0 to 1.")
    return points


def _axis(node: dict[str, Any], where: str) -> int:
    axis = {None: LEAF, "x": X, "y": Y}.get(node.get("axis") if isinstance(node.get("axis"), str | None) else "")
    if axis is None:
        raise FacadeError(f'{where}, axis: expected "x", "y" or nothing, found {shown(node.get("axis"))}.')
    return axis


def _indices(nodes: list[tuple[str, dict[str, Any]]], key: str, names: tuple[str, ...]) -> Ints:
    """[N] index of the name in each node's entry, -1 for nodes without one."""
    index_of_name = {name: number for number, name in enumerate(names)}
    indices = np.full(len(nodes), -1, dtype=np.int64)
    for number, (where, node) in enumerate(nodes):
        if key in node:
            name = a_text(node[key], f"{where}, {key}")
            if name not in index_of_name:
                raise FacadeError(f'{where}, {key}: {shown(name)} is not in the list "{key}s" of the file.')
            indices[number] = index_of_name[name]
    return indices


def _window(node: dict[str, Any], where: str) -> list[float]:
    window = numbers(node.get("window", _ALL), f"{where}, window", 4)
    if any(abs(coordinate - 0.5) > _REACH for coordinate in window):
        raise FacadeError(f"{where}, window: expected numbers from 0 to 1, found {window}.")
    return window


def _grids(value: Any, num_nodes: int) -> tuple[Grid, ...]:
    grids = [
        _grid(an_object(entry, f"Grid {index}"), f"Grid {index}", num_nodes)
        for index, entry in enumerate(a_list(value, "grids", _MOST_GRIDS))
    ]
    if len({grid.name for grid in grids}) < len(grids):
        raise FacadeError("grids: expected unique names.")
    return tuple(grids)


def _grid(values: dict[str, Any], where: str, num_nodes: int) -> Grid:
    elements = [an_object(entry, where) for entry in a_list(values.get("elements"), f"{where}, elements", num_nodes)]
    node, row, column = (
        np.array([a_whole_number(entry.get(key), f"{where}, {key}", 0, end) for entry in elements], dtype=np.int64)
        for key, end in (("node", num_nodes), ("row", _MOST_NODES), ("column", _MOST_NODES))
    )
    grid = Grid(a_text(values.get("name"), f"{where}, name"), node, row, column)
    if (np.diff(node) <= 0).any():
        raise FacadeError(f"{where}: expected elements with ascending nodes.")
    if grid.num_rows * grid.num_columns > _MOST_PLACES or len(set(zip(row, column, strict=True))) < len(elements):
        raise FacadeError(f"{where}: expected one element per row and column, and at most {_MOST_PLACES:,} places.")
    return grid
