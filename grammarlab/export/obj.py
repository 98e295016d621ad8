"""OBJ files with an MTL library: readable text, y up, metres."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.texture_files import find_texture
from grammarlab.derivation.materials import Materials
from grammarlab.export.model_files import AbstractWriter, Output, write_whole
from grammarlab.export.names import MaterialNumbers, shape_names
from grammarlab.scene import Scene, TriangleBatch
from grammarlab.scene.polygons import polygon_coordinates, polygons


@final
class ObjWriter(AbstractWriter):
    """A file of polygons in which each model is an object, and each of its symbols and materials a group.

    The format has no transforms, and most readers store coordinates in 32 bits. So a comment in the first
    lines gives the origin of the file, and coordinates are relative to it.

    Args:
        output: the file.
        path: path of the file; the library and the images go beside it.
        origin: [3] origin of the file in the world, in metres.
        assets: folder of the textures; None leaves them out.
    """

    def __init__(self, output: Output, path: Path, origin: NDArray[np.float64], assets: AssetRoot | None) -> None:
        self._stream = output.stream
        self._path = path
        self._stem = re.sub(r"\s", "_", path.stem)
        self._assets = assets
        self._numbers = MaterialNumbers()
        self._library = ["# grammarlab: colours are sRGB; Pr and Pm are roughness and metalness"]
        self._images: dict[int, tuple[str, bytes]] = {}
        self._num_materials = 0
        self._num_vertices = 0
        self._num_coordinates = 0
        self._write(["# grammarlab: metres, y up", *origin_comments("# ", origin), f"mtllib {self._stem}.mtl"])

    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """See `AbstractWriter.add`."""
        moved = _rows("v", batch.vertices + offset, 12) if offset.any() else _rows("v", batch.vertices)
        lines = [moved, _rows("vn", batch.normals), f"o {name}"]
        faces, names = polygons(scene, batch), shape_names(scene)
        for group, material in enumerate(batch.group_material.tolist()):
            number = self._material(batch.materials, material)
            chosen = slice(*faces.group_faces[group : group + 2].tolist())
            offsets = faces.offsets[chosen.start : chosen.stop + 1]
            corners = faces.rows[offsets[0] : offsets[-1]] + 1 + self._num_vertices
            sizes = np.diff(offsets).tolist()
            if names is not None and batch.group_symbol is not None:
                lines.append(f"g {names.name(int(batch.group_symbol[group]), batch.materials, material)}")
            lines.append(f"usemtl {self._numbers.name(batch.materials, material)}")
            if number in self._images and batch.coordinates is not None:
                vertices = slice(*batch.group_vertices[group : group + 2])
                lines.append(_rows("vt", batch.coordinates[vertices]))
                texture = corners + (self._num_coordinates - self._num_vertices - vertices.start)
                self._num_coordinates += vertices.stop - vertices.start
                lines.append(_faces("%d/%d/%d", np.stack([corners, texture, corners], axis=1), sizes))
            elif number in self._images:
                lines.append(_rows("vt", polygon_coordinates(batch, faces, chosen)))
                texture = self._num_coordinates + 1 + np.arange(len(corners))
                self._num_coordinates += len(corners)
                lines.append(_faces("%d/%d/%d", np.stack([corners, texture, corners], axis=1), sizes))
            else:
                lines.append(_faces("%d//%d", np.stack([corners, corners], axis=1), sizes))
        self._num_vertices += len(batch.vertices)
        self._write(lines)

    def finish(self) -> tuple[Path, ...]:
        """Write the images and the library before the geometry that refers to them."""
        files = {self._path.with_name(name): content for name, content in self._images.values()}
        files[self._path.with_name(f"{self._stem}.mtl")] = _encoded("\n".join(self._library) + "\n")
        for path, content in files.items():
            write_whole(path, content)
        return tuple(files)

    def _write(self, lines: list[str]) -> None:
        self._stream.write(_encoded("".join(f"{line}\n" for line in lines if line)))

    def _material(self, table: Materials, material: int) -> int:
        """Number of a material, which is added to the library.

        Colours are written as sRGB, as programs without colour management expect.
        """
        number = self._numbers.number(table, material)
        if number < self._num_materials:
            return number
        self._num_materials += 1
        lines = self._library
        lines += [f"newmtl {self._numbers.name(table, material)}", "illum 2"]
        for keyword, color in (("Kd", table.color[material]), ("Ke", table.emissive[material])):
            lines.append(keyword + "".join(f" {value:.6g}" for value in np.clip(color, 0.0, 1.0)))
        lines.append(f"d {np.clip(table.opacity[material], 0.0, 1.0):.6g}")
        lines.append(f"Pr {np.clip(table.roughness[material], 0.0, 1.0):.6g}")
        lines.append(f"Pm {np.clip(table.metallic[material], 0.0, 1.0):.6g}")
        texture = find_texture(table.textures[material], self._assets, table.pictures)
        if texture is not None:
            name = f"{self._stem}_texture_{number}{texture.suffix}"
            self._images[number] = (name, texture.content)
            lines.append(f"map_Kd {name}")
            if table.textures[material] in table.cut_out:
                lines.append(f"map_d {name}")
        return number


def _encoded(text: str) -> bytes:
    """UTF-8; file names that are not UTF-8 have their bytes."""
    return text.encode(errors="surrogateescape")


def origin_comments(start: str, origin: NDArray[np.float64]) -> list[str]:
    """Line with the origin [3] of a file in 64 bits; none for that of the world."""
    x, y, z = origin.tolist()
    return [f"{start}origin {x!r} {y!r} {z!r} (metres, to be added to all coordinates)"] if origin.any() else []


def _rows(keyword: str, values: NDArray[np.floating], digits: int = 9) -> str:
    """One line per row; nine digits reproduce every 32-bit number exactly."""
    template = "\n".join([keyword + f" %.{digits}g" * values.shape[1]] * len(values))
    return template % tuple(values.ravel().tolist())


def _faces(corner: str, references: NDArray[np.int64], sizes: Sequence[int]) -> str:
    """One line per face from the references of its corners [C, 2 or 3] and the numbers of corners of the faces."""
    line_of_size = {size: "f" + f" {corner}" * size for size in set(sizes)}
    template = "\n".join([line_of_size[size] for size in sizes])
    return template % tuple(references.ravel().tolist())
