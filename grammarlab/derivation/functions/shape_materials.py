"""Materials of shapes as tables of names and values: ``getMaterial``, and what ``setMaterial`` takes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.shape_attributes import ASSET_MATERIAL
from grammarlab.derivation.state.array_table import Table, cell_text
from grammarlab.derivation.state.shapes import Ids, Shapes, Value, number_column
from grammarlab.language.syntax.keywords import KEYWORDS


def asset_materials(shapes: Shapes) -> Ids:
    """[N] the materials that the geometry of shapes had when it was inserted; 0 if the grammar does not ask."""
    return number_column(shapes.state.get(ASSET_MATERIAL, 0.0), shapes.num).astype(np.int32)


def with_asset_materials(shapes: Shapes, materials: Ids) -> Shapes:
    """Shapes whose geometry was inserted with materials [N], if the grammar asks for them."""
    if ASSET_MATERIAL not in shapes.state:
        return shapes
    return shapes._replace(state={**shapes.state, ASSET_MATERIAL: materials.astype(np.float64)})


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
    arrays = [
        Table("string", len(row), 2, tuple(text for name, value in row.items() for text in (name, cell_text(value))))
        for row in rows
    ]
    return call.workspace.tables.ids(arrays)[inverse]


BUILTINS: dict[str, Builtin] = {
    "getMaterial": Builtin(_get_material, (0, 2), keywords=KEYWORDS["material_source"] | KEYWORDS["material_mode"]),
}
