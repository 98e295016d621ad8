"""3MF files of watertight solids with the colours of their materials (3MF Core Specification 1.3), z up."""

from __future__ import annotations

from pathlib import Path
from typing import IO, final
from xml.sax.saxutils import quoteattr
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.materials import Materials
from grammarlab.export.model_files import AbstractWriter, Output
from grammarlab.export.names import MaterialNumbers
from grammarlab.export.printable_solids import Solid, solid_of, z_up
from grammarlab.scene import Scene, TriangleBatch

_XML = '<?xml version="1.0" encoding="UTF-8"?>\n'
_TYPES = (
    _XML + '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
_RELATIONS = (
    _XML + '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)
_HEAD = (
    _XML + '<model unit="meter" xml:lang="en" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
    '<metadata name="Application">grammarlab</metadata>'
)
_PART = "3D/3dmodel.model"
_MATERIALS = 1
"""Id of the table of materials; models have the ids after it."""


@final
class ThreeMfWriter(AbstractWriter):
    """A package in which each model is an object, at its place; the description gives the origin of the file.

    Args:
        output: the file.
        origin: [3] origin of the file in the world, in metres, y up.
    """

    def __init__(self, output: Output, origin: NDArray[np.float64]) -> None:
        self._stream = output.stream
        self._objects = output.part()
        self._items: list[str] = []
        self._numbers = MaterialNumbers()
        self._bases: dict[int, str] = {}
        self._origin = origin

    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """See `AbstractWriter.add`."""
        solid = solid_of(scene)
        if not len(solid.triangles):
            return
        number = _MATERIALS + 1 + len(self._items)
        used, material = np.unique(solid.material, return_inverse=True)
        base = np.array([self._base(scene.materials, row) for row in used.tolist()])[material.ravel()]
        _write_object(self._objects, number, name, solid, base)
        x, y, z = z_up(offset[None])[0].tolist()
        self._items.append(f'<item objectid="{number}" transform="1 0 0 0 1 0 0 0 1 {x!r} {y!r} {z!r}"/>')

    def finish(self) -> tuple[Path, ...]:
        """See `AbstractWriter.finish`."""
        head = _HEAD
        if self._origin.any():
            x, y, z = z_up(self._origin[None])[0].tolist()
            head += f'<metadata name="Description">origin {x!r} {y!r} {z!r} metres, to be added</metadata>'
        with ZipFile(self._stream, "w", ZIP_DEFLATED) as package:
            for name, text in (("[Content_Types].xml", _TYPES), ("_rels/.rels", _RELATIONS)):
                package.writestr(_entry(name), text)
            with package.open(_entry(_PART), "w", force_zip64=True) as part:
                bases = "".join(self._bases.values())
                table = f'<basematerials id="{_MATERIALS}">{bases}</basematerials>' if bases else ""
                part.write(f"{head}<resources>{table}".encode())
                self._objects.seek(0)
                while block := self._objects.read(1 << 20):
                    part.write(block)
                part.write(f"</resources><build>{''.join(self._items)}</build></model>".encode())
        return ()

    def _base(self, table: Materials, material: int) -> int:
        number = self._numbers.number(table, material)
        if number not in self._bases:
            color = np.append(table.color[material], table.opacity[material])
            code = "".join(f"{value:02X}" for value in np.rint(np.clip(color, 0.0, 1.0) * 255).astype(int).tolist())
            name = quoteattr(self._numbers.name(table, material))
            self._bases[number] = f'<base name={name} displaycolor="#{code}"/>'
        return number


def _entry(name: str) -> ZipInfo:
    """A member of the package without the time of writing, so that equal models have equal files."""
    entry = ZipInfo(name)
    entry.compress_type = ZIP_DEFLATED
    return entry


def _write_object(part: IO[bytes], number: int, name: str, solid: Solid, base: NDArray[np.integer]) -> None:
    """One object; coordinates have the nine digits of 32 bits, so that different points are read as such."""
    lines = [f'<object id="{number}" name={quoteattr(name)} type="model" pid="{_MATERIALS}" pindex="{int(base[0])}">']
    lines.append("<mesh><vertices>")
    lines += [f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in z_up(solid.points).tolist()]
    lines.append("</vertices><triangles>")
    rows = zip(solid.triangles.tolist(), base.tolist(), strict=True)
    lines += [f'<triangle v1="{a}" v2="{b}" v3="{c}" pid="{_MATERIALS}" p1="{index}"/>' for (a, b, c), index in rows]
    lines.append("</triangles></mesh></object>")
    part.write("".join(lines).encode())
