"""Derivations on disk: one folder per forest, one Parquet file per table, for pandas, polars or DuckDB.

nodes.parquet      one row per node       model, parent, symbol, rule, child, repeat
leaves.parquet     one row per leaf       node, position, size (fixed lists of 3), frame, mesh, material, texture_map
draws.parquet      one row per draw       node, site, value, log_density
reports.parquet    one row per report     node, key, value
frames.parquet     one row per frame      rotation (fixed list of 9, row by row)
maps.parquet       one row per map        coordinates (fixed list of 8, row by row)
meshes.parquet     one row per mesh       points, face_sizes, corners, tags (lists); corner_values and slots, if there
                                          are meshes of files with normals, texture coordinates or materials
materials.parquet  one row per material   color.r ... emissive.b, texture; cut_out, if transparent parts are holes
lots.parquet       one row per model      seed, model, footprint, start_rule, attribute.NAME (or null)
footprints.parquet one row per footprint  points (list of fixed lists of 3), street_width (list) if widths are known
forest.json        num_models and the names for the integers

Columns have the meaning, type and unit of the fields of the same name in `grammarlab.derivation.forest` and, for the
last two tables, `grammarlab.derivation.lots`. Node and model are indices within the folder, except in ``lots.parquet``,
where a model is its index under its seed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts
from grammarlab.derivation.forest import Draws, Forest, Leaves, Nodes, Reports, RuleName, Site, SiteKind
from grammarlab.derivation.lots import AttributeColumn, Footprints, Lots
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.errors import AssetError, UsageError
from grammarlab.files import atomic_folder, read_bounded
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.mesh import Meshes

FORMAT = 5
"""Version of the layout above. In version 1 a site was a line of text; before version 3 there were no maps; before
version 4 the header held one seed and the index of the first model, and neither footprints nor attributes, and all
positions counted from the origin of the world; before version 5 meshes had no values at their corners."""

HEADER = "forest.json"
FILES = (
    "nodes.parquet",
    "leaves.parquet",
    "draws.parquet",
    "reports.parquet",
    "frames.parquet",
    "meshes.parquet",
    "materials.parquet",
    "maps.parquet",
    "lots.parquet",
    "footprints.parquet",
    HEADER,
)
_SINCE = {"maps.parquet": 3, "lots.parquet": 4, "footprints.parquet": 4}
"""Tables that earlier formats lack, and the first format that has them."""
MAX_HEADER_BYTES = 1 << 28
"""Largest size of the header."""
_ATTRIBUTE = "attribute."
Array = NDArray[Any]
_FIRST_KINDS: dict[str, SiteKind] = {"choice": "choice", "rand": "uniform", "p": "bernoulli", "fileRandom": "file"}


def save_forest(forest: Forest, folder: Path | str) -> None:
    """Write a forest into a folder; files of an earlier forest in it are replaced, others stay.

    If the process is killed, the folder holds a whole forest or none.
    """
    header = {
        "format": FORMAT,
        "num_models": forest.num_models,
        "start_rules": forest.lots.start_rules,
        "symbols": forest.symbols,
        "rules": [[rule.symbol, rule.parameters, list(rule.branch), rule.line] for rule in forest.rules],
        "sites": [list(astuple(site)) for site in forest.sites],
        "report_keys": forest.reports.keys,
    }
    tables = {
        "nodes": _columns(forest.nodes),
        "leaves": _columns(forest.leaves),
        "draws": _columns(forest.draws),
        "reports": _columns(forest.reports),
        "frames": {"rotation": forest.frames.reshape(-1, 9)},
        "maps": {"coordinates": forest.texture_maps.reshape(-1, 8)},
    }
    with atomic_folder(Path(folder), FILES) as part:
        for name, columns in tables.items():
            _write_table(
                pa.table({key: _to_arrow(column) for key, column in columns.items()}), part / f"{name}.parquet"
            )
        _write_table(_meshes_to_arrow(forest.meshes), part / "meshes.parquet")
        _write_table(_materials_to_arrow(forest.materials), part / "materials.parquet")
        _write_table(_lots_to_arrow(forest.lots), part / "lots.parquet")
        _write_table(_footprints_to_arrow(forest.lots.footprints), part / "footprints.parquet")
        (part / HEADER).write_text(json.dumps(header, indent=1), encoding="utf-8")


def load_forest(folder: Path | str) -> Forest:
    """The forest that `save_forest` wrote, equal to the last bit.

    Raises:
        AssetError: If the folder was not written by `save_forest`, or is damaged.
    """
    folder = Path(folder)
    _require(folder, [name for name in FILES if name not in _SINCE])
    try:
        header = json.loads(read_bounded(folder / HEADER, MAX_HEADER_BYTES))
        version = header["format"]
        if version not in range(1, FORMAT + 1):
            raise AssetError(f"{folder}: expected derivations of format {FORMAT}, found format {version}.")
        _require(folder, [name for name, since in _SINCE.items() if version >= since])
        leaves = _read(folder, "leaves")
        maps = np.zeros((0, 2, 4))
        if version < _SINCE["maps.parquet"]:
            leaves["texture_map"] = np.full(len(leaves["node"]), -1, dtype=np.int32)
        else:
            maps = _read(folder, "maps")["coordinates"].reshape(-1, 2, 4)
        return Forest(
            lots=_lots(folder, header),
            symbols=tuple(header["symbols"]),
            rules=tuple(RuleName(symbol, n, tuple(branch), line) for symbol, n, branch, line in header["rules"]),
            sites=tuple(map(_site, header["sites"])),
            nodes=Nodes(**_read(folder, "nodes")),
            leaves=Leaves(**leaves),
            draws=Draws(**_read(folder, "draws")),
            reports=Reports(**_read(folder, "reports"), keys=tuple(header["report_keys"])),
            frames=_read(folder, "frames")["rotation"].reshape(-1, 3, 3),
            meshes=_meshes_from_arrow(_read_table(folder / "meshes.parquet")),
            materials=_materials_from_arrow(_read_table(folder / "materials.parquet")),
            texture_maps=maps,
        )
    except (
        OSError,
        ValueError,
        LookupError,
        TypeError,
        AttributeError,
        RecursionError,
        UsageError,
        pa.ArrowException,
    ) as error:
        raise AssetError(f"{folder}: the derivations are damaged ({error}). Sample them again.") from error


def _require(folder: Path, names: Sequence[str]) -> None:
    missing = [name for name in names if not (folder / name).is_file()]
    if missing:
        raise AssetError(f"{folder}: expected derivations here, but {', '.join(missing)} is missing.")


def _lots_to_arrow(lots: Lots) -> pa.Table:
    columns = {name: pa.array(getattr(lots, name)) for name in ("seed", "model", "footprint", "start_rule")}
    for name, column in lots.attributes.items():
        columns[_ATTRIBUTE + name] = pa.array(column.values, mask=~column.is_given)
    return pa.table(columns)


def _footprints_to_arrow(footprints: Footprints) -> pa.Table:
    columns = {"points": _ragged(footprints.points, footprints.offsets)}
    if footprints.street_width is not None:
        columns["street_width"] = _ragged(footprints.street_width, footprints.offsets)
    return pa.table(columns)


def _footprints(table: pa.Table) -> Footprints:
    points, counts = _flat(table.column("points"))
    widths = _flat(table.column("street_width"))[0] if "street_width" in table.column_names else None
    return Footprints(points, offsets_from_counts(counts), widths)


def _lots(folder: Path, header: Mapping[str, Any]) -> Lots:
    """The lots of a stored forest; for an earlier format the stored fields, on the default footprint."""
    if header["format"] < _SINCE["lots.parquet"]:
        return Lots.of(header["num_models"], header["seed"], first_model=header["first_model"])
    table = _read_table(folder / "lots.parquet")
    names = [name for name in table.column_names if name.startswith(_ATTRIBUTE)]
    return Lots(
        seed=_from_arrow(table.column("seed")),
        model=_from_arrow(table.column("model")),
        footprints=_footprints(_read_table(folder / "footprints.parquet")),
        footprint=_from_arrow(table.column("footprint")),
        attributes={name.removeprefix(_ATTRIBUTE): _attribute(table.column(name)) for name in names},
        start_rules=tuple(header["start_rules"]),
        start_rule=_from_arrow(table.column("start_rule")),
    )


def _attribute(column: pa.ChunkedArray) -> AttributeColumn:
    is_valid = column.is_valid().to_numpy()
    if pa.types.is_string(column.type):
        return AttributeColumn(np.array(column.fill_null("").to_pylist(), dtype=np.str_), is_valid)
    values = column.fill_null(False if pa.types.is_boolean(column.type) else 0.0).to_numpy()
    return AttributeColumn(values, is_valid)


def _site(entry: str | Sequence[Any]) -> Site:
    """A site of the header; for the first version from its text: ``choice of 3 (line 12)``."""
    if not isinstance(entry, str):
        return Site(*entry)
    match = re.fullmatch(r"(\w+)(?: of (\d+))? \(line (\d+)\)", entry)
    if match is None:
        raise ValueError(f"expected a random expression, found {entry!r}")
    word, choices, line = match.groups()
    return Site(entry, _FIRST_KINDS[word], "", int(line), int(choices or 0))


def _columns(table: Nodes | Leaves | Draws | Reports) -> Mapping[str, Array]:
    values = {field.name: getattr(table, field.name) for field in fields(table)}
    return {name: value for name, value in values.items() if isinstance(value, np.ndarray)}


def _to_arrow(column: Array) -> pa.Array:
    """A column [N] unchanged, a column [N, K] as fixed lists of K."""
    if column.ndim == 1:
        return pa.array(column)
    return pa.FixedSizeListArray.from_arrays(pa.array(column.ravel()), column.shape[1])


def _from_arrow(column: pa.ChunkedArray) -> Array:
    array = column.combine_chunks()
    if pa.types.is_fixed_size_list(array.type):
        return array.flatten().to_numpy().reshape(-1, array.type.list_size)
    return array.to_numpy()


def _write_table(table: pa.Table, path: Path) -> None:
    with path.open("wb") as stream:  # Arrow refuses names of files that are not UTF-8
        pq.write_table(table, stream)


def _read_table(path: Path) -> pa.Table:
    with path.open("rb") as stream:
        return pq.read_table(stream)


def _read(folder: Path, name: str) -> dict[str, Array]:
    table = _read_table(folder / f"{name}.parquet")
    return {key: _from_arrow(table.column(key)) for key in table.column_names}


def _ragged(values: Array, offsets: NDArray[np.integer]) -> pa.Array:
    """A ragged list as an Arrow list column; rows [N, 3] become fixed lists of 3."""
    return pa.LargeListArray.from_arrays(pa.array(offsets, pa.int64()), _to_arrow(values))


def _flat(column: pa.ChunkedArray) -> tuple[Array, Array]:
    """The values of a list column, and the length of each row."""
    array = column.combine_chunks()
    return _from_arrow(pa.chunked_array([array.flatten()])), np.diff(array.offsets.to_numpy())


def _meshes_to_arrow(meshes: Meshes) -> pa.Table:
    mesh_corners = meshes.face_offsets[meshes.mesh_faces]
    columns = {
        "points": _ragged(meshes.points, meshes.mesh_points),
        "face_sizes": _ragged(np.diff(meshes.face_offsets), meshes.mesh_faces),
        "corners": _ragged(meshes.corners, mesh_corners),
        "tags": _ragged(meshes.tags, meshes.mesh_faces),
    }
    if meshes.data is not None:
        columns["corner_values"] = _ragged(meshes.data.values, mesh_corners)
        columns["slots"] = _ragged(meshes.data.slots, meshes.mesh_faces)
    return pa.table(columns)


def _meshes_from_arrow(table: pa.Table) -> Meshes:
    points, points_per_mesh = _flat(table.column("points"))
    face_sizes, faces_per_mesh = _flat(table.column("face_sizes"))
    corners, _ = _flat(table.column("corners"))
    tags, _ = _flat(table.column("tags"))
    data = None
    if "corner_values" in table.column_names:
        data = CornerData(_flat(table.column("corner_values"))[0], _flat(table.column("slots"))[0])
    return Meshes(
        points=points,
        corners=corners,
        face_offsets=offsets_from_counts(face_sizes),
        mesh_faces=offsets_from_counts(faces_per_mesh),
        mesh_points=offsets_from_counts(points_per_mesh),
        tags=tags,
        data=data,
    )


def _materials_to_arrow(materials: Materials) -> pa.Table:
    channels = {name: pa.array(materials.channels[:, k].copy()) for k, name in enumerate(CHANNELS)}
    columns = {**channels, "texture": pa.array(materials.textures, pa.string())}
    if materials.cut_out:
        columns["cut_out"] = pa.array([texture in materials.cut_out for texture in materials.textures])
    return pa.table(columns)


def _materials_from_arrow(table: pa.Table) -> Materials:
    channels = np.stack([_from_arrow(table.column(name)) for name in CHANNELS], axis=1)
    textures = tuple(table.column("texture").to_pylist())
    flags = table.column("cut_out").to_pylist() if "cut_out" in table.column_names else []
    cut_out = frozenset(texture for texture, is_cut_out in zip(textures, flags, strict=False) if is_cut_out)
    return Materials(channels, textures, cut_out=cut_out)
