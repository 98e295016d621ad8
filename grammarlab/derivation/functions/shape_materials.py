"""Materials as tables of names and values: ``getMaterial``, ``readMaterial``, and what ``setMaterial`` takes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial

import numpy as np

from grammarlab.assets.mesh_parts import PartMaterial
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.calls.table_columns import for_each
from grammarlab.derivation.functions.shape_attributes import ASSET_MATERIAL
from grammarlab.derivation.materials import CHANNELS
from grammarlab.derivation.state.array_table import Cell, Table, cell_text
from grammarlab.derivation.state.shapes import Ids, Shapes, Value, number_column
from grammarlab.errors import DerivationError
from grammarlab.language.syntax.keywords import KEYWORDS


def asset_materials(shapes: Shapes) -> Ids:
    """[N] the materials that the geometry of shapes had when it was inserted; 0 if the grammar does not ask."""
    return number_column(shapes.state.get(ASSET_MATERIAL, 0.0), shapes.num).astype(np.int32)


def with_asset_materials(shapes: Shapes, materials: Ids) -> Shapes:
    """Shapes whose geometry was inserted with materials [N], if the grammar asks for them."""
    if ASSET_MATERIAL not in shapes.state:
        return shapes
    return shapes._replace(state={**shapes.state, ASSET_MATERIAL: materials.astype(np.float64)})


def asset_channels(material: PartMaterial, *, has_image: bool = True) -> dict[str, float | str]:
    """The channels of a material of an asset."""
    values = (*material.color, material.metallic, material.roughness, *material.emissive)
    return {**dict(zip(CHANNELS, values, strict=True)), "texture": material.texture if has_image else ""}


def cut_out_images(materials: Iterable[PartMaterial | None]) -> set[str]:
    """The images of materials whose transparent parts are holes."""
    return {each.texture for each in materials if each is not None and each.is_cut_out} - {""}


def named_values(table: Table) -> Iterator[tuple[str, str]]:
    """Names and values in the cells of an array, in turn; a name without a value is left out."""
    texts = [cell_text(cell) for cell in table.cells]
    yield from zip(texts[::2], texts[1::2], strict=False)


def _get_material(call: FunctionCall) -> Value:
    """``getMaterial(used|shape|geometry, changed|all)``: a row of name and value for each attribute of a material.

    ``shape`` is what rules changed, ``geometry`` the material of the inserted asset, ``used`` both. Of several
    materials the first is taken.
    """
    words = [str(word) for word in call.arguments]
    used, asset, table = call.shapes.material, asset_materials(call.shapes), call.workspace.materials
    materials = asset if "geometry" in words else table.without(used, asset) if "shape" in words else used
    different, inverse = np.unique(materials, return_inverse=True)
    rows = [table.attributes(material, changed="all" not in words) for material in different.tolist()]
    return call.workspace.tables.ids([_rows_of(row) for row in rows])[inverse]


def _rows_of(attributes: Mapping[str, float | str]) -> Table:
    cells = tuple(text for name, value in attributes.items() for text in (name, cell_text(value)))
    return Table("string", len(attributes), 2, cells)


def _read_material(call: FunctionCall) -> Value:
    """``readMaterial(path)``: a row of name and value for each attribute of the first material of an MTL file."""
    return for_each(call.arguments, call.shapes.num, call.workspace, partial(_material_in, call), call.location)


def _material_in(call: FunctionCall, path: Cell | Table) -> Table:
    """The first material of a file; an empty array, and a record of it, if there is none to read."""
    if not isinstance(path, str):
        raise DerivationError(f"{call.name} expects the path of a file", call.location)
    material = call.workspace.material(path, call.location)
    if material is None:
        return _rows_of({})
    call.workspace.materials.cut_out |= cut_out_images([material])
    channels = asset_channels(material)
    return _rows_of({"colormap" if name == "texture" else name: value for name, value in channels.items()})


BUILTINS: dict[str, Builtin] = {
    "getMaterial": Builtin(_get_material, (0, 2), keywords=KEYWORDS["material_source"] | KEYWORDS["material_mode"]),
    "readMaterial": Builtin(_read_material, (1, 1)),
}
