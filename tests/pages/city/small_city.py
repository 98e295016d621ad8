"""A small city on disk: boxes on a grid of parcels as 3D Tiles of two levels, and the table of its parcels."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import shapely
from numpy.typing import NDArray
from pyproj import Transformer

from grammarlab.city.parcel_addresses import Pins, addresses, read_pins
from grammarlab.city.plan import read_plan
from grammarlab.files import write_bytes, write_text
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.parcel_rows import ParcelRows
from grammarlab.runs.city.parcel_table import ParcelTableWriter

CRS_NAME = "EPSG:32631"
ORIGIN = (452_000.0, 5_412_000.0)
SIZE = 20.0
"""Metres between parcels, which are 16 m wide."""
ZONES = ("offices", "homes")
_FACES = ((1, 3, 7, 5), (0, 4, 6, 2), (2, 6, 7, 3), (0, 1, 5, 4), (4, 5, 7, 6))
"""Corners of the sides east, west, north, south and top of a box; bits of a corner are east, north and up."""


PLAN = """# Two zones of a small town
parcels = "parcels.geojson"
seed = 7

[[zones]]
name = "homes"  # low ones
where = "east < 0"
grammar = "toy"

[[zones]]
name = "offices"
grammar = "toy"
"""


def write_city(folder: Path, columns: int = 6, rows: int = 4, pins: Pins | None = None) -> list[str]:
    """Write the city, with its plan in the folder above; returns the ids of its parcels. The last parcel is empty."""
    index = np.arange(columns * rows)
    corner = (SIZE * np.stack([index % columns - columns / 2, index // columns - rows / 2], 1)).astype(np.float64)
    ids = [f"P-{number:03}" for number in index]
    places = addresses(np.array(ids, object), 7, pins or Pins())
    built = (index < len(index) - 1) & ~places.is_excluded
    heights = (6.0 + 5.0 * (places.model % np.uint64(6))).astype(np.float64)
    reason = np.where(built, "", np.where(index == index[-1], "small", "excluded")).astype(object)
    rows_of_table = ParcelRows(
        id=np.array(ids, object),
        outline=shapely.box(*corner.T, *(corner + 16).T),
        lot=shapely.box(*(corner + 2).T, *(corner + 14).T),
        zone=np.array([ZONES[int(number % columns < columns // 2)] for number in index], object),
        reason=reason,
        seed=places.seed,
        model=places.model,
        reroll=places.reroll,
        grammar=np.where(built, "0" * 64, "").astype(object),
        area=np.full(len(ids), 256.0),
        street_width=np.full(4 * len(ids), 4.0),
        lot_edges=4 * np.arange(len(ids) + 1),
        tile=np.where(built, "tiles/full.glb", "").astype(object),
        reports={"height": np.where(built, heights, np.nan)},
    )
    folder.mkdir(parents=True, exist_ok=True)
    with ParcelTableWriter(folder / "parcels.parquet", Frame(CRS_NAME, ORIGIN)) as writer:
        writer.add(rows_of_table)
    (folder / "tiles").mkdir(exist_ok=True)
    write_tiles(folder, np.array(ids)[built].tolist(), corner[built], heights[built])
    plan = folder.parent / "town.toml"
    if not plan.exists():
        plan.write_text(PLAN)
    (folder / "city.json").write_text(json.dumps({"plan": str(plan)}))
    return ids


def rebuild(folder: Path, parcels: Sequence[str]) -> list[str]:
    """Build the city again as its pins say; the size of the city stays that of its table."""
    plan = read_plan(Path(json.loads((folder / "city.json").read_text())["plan"]))
    number = pq.read_metadata(folder / "parcels.parquet").num_rows
    columns = {24: 6, 120: 12}[number]
    write_city(folder, columns, number // columns, read_pins(plan.pins))
    return ["tiles/coarse.glb", "tiles/full.glb"] if parcels else []


def write_tiles(folder: Path, ids: list[str], corner: NDArray[np.float64], heights: NDArray[np.float64]) -> None:
    """A coarse and a full tile of boxes 12 m wide in the middle of parcels, and their tileset."""
    low = np.column_stack([corner + 2, np.zeros(len(ids))])
    high = low + np.column_stack([np.full((len(ids), 2), 12.0), heights])
    for name, shrink in (("coarse", 0.0), ("full", 0.3)):
        inward = np.array([shrink, shrink, 0])
        write_bytes(folder / "tiles" / f"{name}.glb", glb(ids, low + inward, high - inward), lasting=False)
    middle, half = (low.min(0) + high.max(0)) / 2, (high.max(0) - low.min(0)) / 2
    box = [*middle, half[0], 0, 0, 0, half[1], 0, 0, 0, half[2]]
    child = {"boundingVolume": {"box": box}, "geometricError": 0, "content": {"uri": "tiles/full.glb"}}
    root = {
        "transform": east_north_up(*ORIGIN).T.ravel().tolist(),
        "boundingVolume": {"box": box},
        "geometricError": 4,
        "refine": "REPLACE",
        "content": {"uri": "tiles/coarse.glb"},
        "children": [child],
    }
    tileset = {"asset": {"version": "1.1"}, "geometricError": 16, "root": root}
    write_text(folder / "tileset.json", json.dumps(tileset))


def east_north_up(easting: float, northing: float) -> NDArray[np.float64]:
    """[4, 4] matrix from metres east, north and up of a point to earth-centred coordinates."""
    longitude, latitude = Transformer.from_crs(CRS_NAME, "OGC:CRS84", always_xy=True).transform(easting, northing)
    place = Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True).transform(longitude, latitude, 0.0)
    east, north = math.radians(longitude), math.radians(latitude)
    matrix = np.eye(4)
    matrix[:3, 0] = -math.sin(east), math.cos(east), 0
    matrix[:3, 1] = -math.sin(north) * math.cos(east), -math.sin(north) * math.sin(east), math.cos(north)
    matrix[:3, 2] = math.cos(north) * math.cos(east), math.cos(north) * math.sin(east), math.sin(north)
    matrix[:3, 3] = place
    return matrix


def glb(ids: list[str], low: NDArray[np.float64], high: NDArray[np.float64]) -> bytes:
    """Boxes as one mesh with feature ids, a chimney on each as instances, and the ids of buildings as metadata."""
    bits = np.array([[corner & 1, corner >> 1 & 1, corner >> 2] for corner in range(8)])
    corners = np.where(bits[None] == 1, high[:, None], low[:, None])  # [B, 8, 3] east, north, up
    points = corners[:, np.array(_FACES).ravel()][..., [0, 2, 1]] * [1, 1, -1]  # y up
    normals = np.repeat([[1, 0, 0], [-1, 0, 0], [0, 0, -1], [0, 0, 1], [0, 1, 0]], 4, axis=0)
    quads = np.arange(20 * len(ids)).reshape(-1, 4)
    chimney = np.where(bits == 1, 0.5, -0.5)[np.array(_FACES).ravel()][:, [0, 2, 1]] * [1, 1, -1]
    top = np.column_stack([(low + high)[:, :2] / 2, high[:, 2] + 0.5])[:, [0, 2, 1]] * [1, 1, -1]
    texts = [text.encode() for text in ids]
    triangles = quads[:, [0, 1, 2, 0, 2, 3]]
    writer = _Binary()
    mesh = {
        "attributes": {
            "POSITION": writer.accessor(points.reshape(-1, 3), "VEC3", bounds=True),
            "NORMAL": writer.accessor(np.tile(normals, (len(ids), 1)), "VEC3"),
            "_FEATURE_ID_0": writer.accessor(np.repeat(np.arange(len(ids)), 20), "SCALAR"),
        },
        "indices": writer.accessor(triangles, "SCALAR", np.uint32),
        "material": 0,
        "extensions": {
            "EXT_mesh_features": {"featureIds": [{"featureCount": len(ids), "attribute": 0, "propertyTable": 0}]}
        },
    }
    box = {
        "attributes": {
            "POSITION": writer.accessor(chimney, "VEC3", bounds=True),
            "NORMAL": writer.accessor(normals, "VEC3"),
        },
        "indices": writer.accessor(triangles[:5], "SCALAR", np.uint32),
        "material": 1,
    }
    instances = {
        "attributes": {
            "TRANSLATION": writer.accessor(top, "VEC3"),
            "_FEATURE_ID_0": writer.accessor(np.arange(len(ids)), "SCALAR"),
        }
    }
    features = {"featureIds": [{"featureCount": len(ids), "attribute": 0, "propertyTable": 0}]}
    properties = {
        "values": writer.view(b"".join(texts)),
        "stringOffsets": writer.view(np.cumsum([0, *map(len, texts)]).astype("<u4").tobytes()),
    }
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": [
            "EXT_mesh_features",
            "EXT_mesh_gpu_instancing",
            "EXT_instance_features",
            "EXT_structural_metadata",
        ],
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0},
            {"mesh": 1, "extensions": {"EXT_mesh_gpu_instancing": instances, "EXT_instance_features": features}},
        ],
        "meshes": [{"primitives": [mesh]}, {"primitives": [box]}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0}, "doubleSided": True}
            for color in ((0.75, 0.68, 0.55), (0.45, 0.2, 0.15))
        ],
        "extensions": {
            "EXT_structural_metadata": {
                "schema": {"id": "city", "classes": {"building": {"properties": {"id": {"type": "STRING"}}}}},
                "propertyTables": [{"class": "building", "count": len(ids), "properties": {"id": properties}}],
            }
        },
    }
    return writer.glb(document)


class _Binary:
    """The binary part of a GLB file."""

    def __init__(self) -> None:
        self.data, self.views, self.accessors = bytearray(), [], []

    def view(self, content: bytes) -> int:
        self.data += b"\0" * (-len(self.data) % 8)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content)})
        self.data += content
        return len(self.views) - 1

    def accessor(self, values: NDArray[Any], kind: str, dtype: type = np.float32, *, bounds: bool = False) -> int:
        components: dict[type, int] = {np.float32: 5126, np.uint32: 5125}
        rows = values.reshape(-1, 3) if kind == "VEC3" else values.ravel()
        accessor: dict[str, Any] = {"count": len(rows), "type": kind, "componentType": components[dtype]}
        accessor["bufferView"] = self.view(np.ascontiguousarray(rows, dtype).tobytes())
        if bounds:
            accessor |= {"min": rows.min(0).tolist(), "max": rows.max(0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def glb(self, document: dict[str, Any]) -> bytes:
        self.data += b"\0" * (-len(self.data) % 8)
        document |= {
            "buffers": [{"byteLength": len(self.data)}],
            "bufferViews": self.views,
            "accessors": self.accessors,
        }
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 8)
        length = 12 + 8 + len(text) + 8 + len(self.data)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(self.data), 0x004E4942)
        return struct.pack("<III", 0x46546C67, 2, length) + chunks + bytes(self.data)
