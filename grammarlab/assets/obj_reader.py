"""Polygons of OBJ files.

Faces keep all of their corners; a negative number of a corner counts back from the line of its face. Lines, points,
curves and surfaces are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from grammarlab.arrays import Floats, row_of_value
from grammarlab.assets.mesh_parts import (
    FARTHEST,
    Indices,
    MeshPart,
    Neighbours,
    PartMaterial,
    require_few_materials,
)
from grammarlab.assets.mtl_reader import read_mtl
from grammarlab.errors import AssetError

_WIDTHS = {b"vt": 2, b"vn": 3}
"""Numbers that are read of each texture coordinate and each normal, in the order of their references in faces."""
_MOST_VALUES = 1 << 40
"""More than any file has; larger numbers of texture coordinates and normals are none."""
_LARGEST_VALUE = 1e9
"""Largest number of a texture coordinate or normal; larger ones are none."""
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
    values: dict[bytes, list[bytes]] = field(default_factory=lambda: {b"vt": [], b"vn": []})
    """Words of texture coordinates (two each) and normals (three each)."""
    value_corners: dict[bytes, list[int]] = field(default_factory=lambda: {b"vt": [], b"vn": []})
    """[C] number of those of the corners of faces, from 1; 0 for none. Empty if no face has any."""
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
    r"""Parts of an OBJ file, one for each material; the points if there are no faces.

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
    return _by_material(points, corners, counts, text, neighbours)


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
        elif keyword in _WIDTHS:
            text.values[keyword] += [*words[1 : 1 + _WIDTHS[keyword]], b"0", b"0"][: _WIDTHS[keyword]]
        elif keyword == b"f" and len(words) > 3:  # faces of two corners are empty
            if b"/" in line:
                _add_value_corners(text, words[1:])
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


def _add_value_corners(text: _Text, words: Sequence[bytes]) -> None:
    """Add the texture coordinates and normals of the corners of a face; those that cannot be read are none."""
    for place, (keyword, width) in enumerate(_WIDTHS.items(), 1):
        references = text.value_corners[keyword]
        references += [0] * (len(text.corners) - len(references))
        total = len(text.values[keyword]) // width
        for word in words:
            parts = word.split(b"/", 3)
            try:
                reference = int(parts[place]) if len(parts) > place else 0
            except ValueError:
                reference = 0
            references.append(min(max(reference if reference >= 0 else total + 1 + reference, 0), _MOST_VALUES))


def _corner_values(text: _Text, keyword: bytes) -> Floats | None:
    """[C, 2 or 3] texture coordinates or normals of the corners of faces, NaN for none; None if no corner has any."""
    references, width = text.value_corners[keyword], _WIDTHS[keyword]
    if not any(references):
        return None
    values = np.array([_number(word) for word in text.values[keyword]]).reshape(-1, width)
    values[~(np.abs(values) <= _LARGEST_VALUE).all(axis=1)] = np.nan
    rows = np.array([*references, *[0] * (len(text.corners) - len(references))])
    return np.concatenate([np.full((1, width), np.nan), values])[np.where(rows > len(values), 0, rows)]


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


def _by_material(
    points: Floats, corners: Indices, counts: Indices, text: _Text, neighbours: Neighbours
) -> list[MeshPart]:
    """A part for each material, in the order of their first faces.

    Raises:
        AssetError: If there are too many materials, or concave faces have too many corners.
    """
    materials = _materials(text, neighbours)
    numbers = {material: number for number, material in enumerate(dict.fromkeys(materials))}
    require_few_materials(len(numbers))
    number = np.array([numbers[material] for material in materials])
    normals, coordinates = _corner_values(text, b"vn"), _corner_values(text, b"vt")
    parts = []
    for material, number_of_material in numbers.items():
        faces = number == number_of_material
        chosen = faces.repeat(counts)
        part = MeshPart.of_faces(
            points,
            corners[chosen],
            counts[faces],
            material,
            None if normals is None else normals[chosen],
            () if coordinates is None else (coordinates[chosen],),
        )
        part.require_simple()
        parts.append(part)
    return parts


def _materials(text: _Text, neighbours: Neighbours) -> list[PartMaterial | None]:
    """[F] material of each face."""
    if not any(text.materials):
        return [None] * len(text.materials)
    library: dict[bytes, PartMaterial | None] = {}
    for name in dict.fromkeys(text.libraries):
        try:
            library |= read_mtl(neighbours(name.decode("utf-8", errors="replace")))
        except AssetError:
            continue  # the shape is complete without its materials
    return [library.get(material) for material in text.materials]


def _excerpt(line: bytes) -> str:
    text = line.decode("utf-8", errors="replace").strip()
    return repr(text if len(text) <= _MAX_CHARACTERS else text[:_MAX_CHARACTERS] + "…")
