"""Polygons of OBJ files.

Faces keep all of their corners; a negative number of a corner counts back from the line of its face. Lines, points,
curves and surfaces are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from grammarlab.arrays import Floats, row_of_value
from grammarlab.assets.mesh_parts import FARTHEST, Color, Indices, MeshPart, Neighbours, color_of
from grammarlab.errors import AssetError

_FREE_FORM = frozenset({b"curv", b"curv2", b"surf"})
_MAX_CHARACTERS = 60
"""Characters of a line that a message shows."""


@dataclass(slots=True)
class _Text:
    """Statements of an OBJ file."""

    coordinates: list[bytes] = field(default_factory=list)
    """[3 P] words."""
    point_lines: list[int] = field(default_factory=list)
    """[P] line of each point, from 0."""
    corners: list[int] = field(default_factory=list)
    """[C] points of the corners of faces, from 1."""
    counts: list[int] = field(default_factory=list)
    """[F] number of corners."""
    face_lines: list[int] = field(default_factory=list)
    """[F]."""
    materials: list[bytes] = field(default_factory=list)
    """[F] material in use."""
    libraries: list[bytes] = field(default_factory=list)
    """Names of files of materials."""
    free_form: bytes = b""
    """The first keyword of a curve or surface."""


def read_obj(content: bytes, neighbours: Neighbours) -> list[MeshPart]:
    r"""Parts of an OBJ file, one for each color; the points if there are no faces.

    Args:
        content: the whole file.
        neighbours: files of materials; those that are missing are left out.

    Raises:
        AssetError: If a line is invalid, or concave faces have too many corners.

    >>> wall = b"v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf -5 -4 -3 -2 -1"
    >>> read_obj(wall, lambda name: b"")[0].counts.tolist()
    [5]
    """
    lines = _joined(content)
    text = _statements(lines)
    points = _points(text, lines)
    if not text.counts:
        if text.free_form:
            raise AssetError(
                f"it has no faces but free-form geometry ({text.free_form.decode()}); export it as polygons"
            )
        return [MeshPart.of_points(points)] if len(points) else []
    counts = np.array(text.counts)
    corners = _checked_corners(counts, text, points)
    return _by_color(points, corners, counts, _colors(text, neighbours))


def _joined(content: bytes) -> list[bytes]:
    r"""Lines, with continued ones (those that end in ``\``) joined to the next; an empty line keeps their place."""
    lines = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n").split(b"\n")
    if b"\\\n" not in content and b"\\\r" not in content:
        return lines
    joined: list[bytes] = []
    pieces: list[bytes] = []
    for line in lines:
        pieces.append(line.removesuffix(b"\\"))
        if not line.endswith(b"\\"):
            joined += [b" ".join(pieces), *[b""] * (len(pieces) - 1)]
            pieces = []
    return [*joined, b" ".join(pieces)]


def _statements(lines: Sequence[bytes]) -> _Text:
    text = _Text()
    material = b""
    for number, line in enumerate(lines):
        words = (line.partition(b"#")[0] if b"#" in line else line).split()
        keyword = words[0] if words else b""
        if keyword == b"v":
            if len(words) < 4:
                raise AssetError(f"line {number + 1}: expected v x y z, found {_excerpt(line)}")
            text.coordinates += words[1:4]
            text.point_lines.append(number)
        elif keyword == b"f" and len(words) > 3:  # faces of two corners are empty
            text.corners += _corners(words, len(text.point_lines), number, line)
            text.counts.append(len(words) - 1)
            text.face_lines.append(number)
            text.materials.append(material)
        elif keyword == b"usemtl":
            material = b" ".join(words[1:])
        elif keyword == b"mtllib":
            text.libraries.append(line.strip()[len(keyword) :].strip())
        elif keyword in _FREE_FORM:
            text.free_form = text.free_form or keyword
    return text


def _corners(words: Sequence[bytes], num_points: int, number: int, line: bytes) -> list[int]:
    """Points of the corners of a face, from 1.

    Raises:
        AssetError: If they are not whole numbers.
    """
    names = [word.partition(b"/")[0] for word in words[1:]] if b"/" in line else words[1:]
    try:
        corners = list(map(int, names))
    except ValueError:
        raise AssetError(f"line {number + 1}: expected numbers of points, found {_excerpt(line)}") from None
    return corners if min(corners) > 0 else [num_points + 1 + corner if corner < 0 else corner for corner in corners]


def _points(text: _Text, lines: Sequence[bytes]) -> Floats:
    """[P, 3] points.

    Raises:
        AssetError: If a coordinate is not a finite number.
    """
    try:
        points = np.array(text.coordinates, dtype=np.float64).reshape(-1, 3)
    except ValueError:
        points = np.array([_number(word) for word in text.coordinates]).reshape(-1, 3)
    wrong = ~(np.abs(points) <= FARTHEST).all(axis=1)
    if wrong.any():
        number = text.point_lines[int(np.argmax(wrong))]
        raise AssetError(
            f"line {number + 1}: expected finite numbers up to {FARTHEST:g}, found {_excerpt(lines[number])}"
        )
    return points


def _number(word: bytes) -> float:
    try:
        return float(word)
    except ValueError:
        return np.nan


def _checked_corners(counts: Indices, text: _Text, points: Floats) -> Indices:
    """[C] points of the corners of faces.

    Raises:
        AssetError: If one does not exist.
    """
    try:
        corners = np.array(text.corners, dtype=np.int64) - 1
    except OverflowError:
        corners = np.array([corner - 1 if 0 < corner <= len(points) else -1 for corner in text.corners])
    wrong = (corners < 0) | (corners >= len(points))
    if wrong.any():
        number = text.face_lines[int(row_of_value(counts)[np.argmax(wrong)])]
        raise AssetError(
            f"line {number + 1}: a face has corners that do not exist; the file has {len(points):,} points"
        )
    return corners


def _by_color(points: Floats, corners: Indices, counts: Indices, colors: Sequence[Color | None]) -> list[MeshPart]:
    """A part for each color, in the order of their first faces.

    Raises:
        AssetError: If concave faces have too many corners.
    """
    numbers = {color: number for number, color in enumerate(dict.fromkeys(colors))}
    number = np.array([numbers[color] for color in colors])
    parts = []
    for color, number_of_color in numbers.items():
        faces = number == number_of_color
        parts.append(MeshPart.of_faces(points, corners[faces.repeat(counts)], counts[faces], color))
        parts[-1].require_simple()
    return parts


def _colors(text: _Text, neighbours: Neighbours) -> list[Color | None]:
    """[F] color of each face."""
    if not any(text.materials):
        return [None] * len(text.materials)
    library_colors: dict[bytes, Color | None] = {}
    for name in dict.fromkeys(text.libraries):
        try:
            library_colors |= _library(neighbours(name.decode("utf-8", errors="replace")))
        except AssetError:
            continue  # the shape is complete without its colors
    return [library_colors.get(material) for material in text.materials]


def _library(content: bytes) -> dict[bytes, Color | None]:
    """Diffuse color and opacity of each material of an MTL file."""
    colors: dict[bytes, list[bytes]] = {}
    opacity: dict[bytes, bytes] = {}
    material = b""
    for line in content.replace(b"\r", b"\n").split(b"\n"):
        words = line.split()
        if len(words) < 2:
            continue
        if words[0] == b"newmtl":
            material = b" ".join(words[1:])
            colors.setdefault(material, [])
        elif words[0].lower() == b"kd":
            colors[material] = words[1:4]
        elif words[0] == b"d":
            opacity[material] = words[-1]
    return {name: color_of([*color, opacity.get(name, b"1")]) for name, color in colors.items()}


def _excerpt(line: bytes) -> str:
    text = line.decode("utf-8", errors="replace").strip()
    return repr(text if len(text) <= _MAX_CHARACTERS else text[:_MAX_CHARACTERS] + "…")
