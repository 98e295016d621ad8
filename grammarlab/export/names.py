"""Names of the parts of files: materials by what they look like, shapes by their symbol and material."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.materials import Materials
from grammarlab.scene import Scene, TriangleBatch

_LONGEST = 64
"""Largest number of characters of the name of a texture in that of a material."""
_METAL = 0.5
"""Smallest metalness of what is called metal."""


class MaterialNumbers:
    """The different materials of one file, numbered in the order of their first use, with different names."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[bytes, str], int] = {}
        self._names: dict[str, None] = {}

    def number(self, table: Materials, material: int) -> int:
        """The number of a row of a table; rows of equal appearance have the same number in all tables."""
        key = table.channels[material].tobytes(), table.textures[material]
        if key not in self._numbers:
            self._numbers[key] = len(self._numbers)
            word = appearance(table, material)
            count = 1
            name = word
            while name in self._names:
                count += 1
                name = f"{word}_{count}"
            self._names[name] = None
        return self._numbers[key]

    def name(self, table: Materials, material: int) -> str:
        """Name of a row of a table, as in `appearance`, and numbered if an earlier material looks about the same."""
        return list(self._names)[self.number(table, material)]


def appearance(table: Materials, material: int) -> str:
    """What a material looks like: the name of its texture, or what it is and its sRGB colour: ``glass_a0c4d8``."""
    texture = PurePosixPath(table.textures[material].replace("\\", "/")).stem
    word = re.sub(r"\W+", "_", texture).strip("_")[:_LONGEST]
    if word:
        return word
    red, green, blue = (round(255 * min(max(value, 0.0), 1.0)) for value in table.color[material].tolist())
    kind = "color"
    if table.opacity[material] < 1.0:
        kind = "glass"
    elif table.emissive[material].any():
        kind = "light"
    elif table.metallic[material] >= _METAL:
        kind = "metal"
    return f"{kind}_{red:02x}{green:02x}{blue:02x}"


@dataclass(frozen=True, slots=True)
class ShapeNames:
    """Names and origins of the shapes of one model, by symbol and material."""

    symbols: tuple[str, ...]
    lines: Mapping[tuple[int, int], tuple[int, ...]]
    """Lines of the rules that made the shapes of each pair of symbol and material."""
    is_mixed: frozenset[int]
    """Symbols with several materials."""

    def name(self, symbol: int, table: Materials, material: int) -> str:
        """``Window``, or ``Wall.brick`` if the model has walls of several materials."""
        name = self.symbols[symbol].rstrip(".")
        return f"{name}.{appearance(table, material)}" if symbol in self.is_mixed else name

    def extras(self, symbol: int, material: int) -> dict[str, Any]:
        """Symbol and lines of shapes."""
        lines = self.lines[symbol, material]
        values: dict[str, Any] = {"symbol": self.symbols[symbol]}
        if len(lines) == 1:
            values["line"] = lines[0]
        elif lines:
            values["lines"] = list(lines)
        return values


def shape_names(scene: Scene) -> ShapeNames | None:
    """Names of the shapes of a scene of one model; None if it has no labels."""
    labels = scene.labels
    if labels is None:
        return None
    rows = np.stack([labels.symbol, scene.material, labels.line], axis=1)
    lines: dict[tuple[int, int], list[int]] = {}
    for symbol, material, line in np.unique(rows, axis=0).tolist():
        lines.setdefault((symbol, material), []).extend([line] if line else [])
    used = [symbol for symbol, _ in lines]
    mixed = frozenset(symbol for symbol in used if used.count(symbol) > 1)
    return ShapeNames(labels.symbols, {pair: tuple(numbers) for pair, numbers in lines.items()}, mixed)


def groups_by_name(batch: TriangleBatch, names: ShapeNames) -> list[tuple[int, int, int]]:
    """Symbol, material and group of each group of a model with labels, symbol by symbol."""
    if batch.group_symbol is None:
        return []
    groups = zip(
        batch.group_symbol.tolist(), batch.group_material.tolist(), range(len(batch.group_symbol)), strict=True
    )
    return sorted(groups, key=lambda entry: (names.symbols[entry[0]], entry[2]))


def model_values(scene: Scene) -> dict[str, dict[str, Any]]:
    """Attributes and sums of reports of a scene of one model, for readers of its file; without empty ones."""
    if scene.labels is None:
        return {}
    tables = {"attributes": scene.labels.attributes, "reports": scene.labels.reports}
    values = {
        kind: {name: value for name, column in columns.items() if (value := _plain(column)) is not None}
        for kind, columns in tables.items()
    }
    return {kind: columns for kind, columns in values.items() if columns}


def _plain(column: NDArray[Any]) -> Any:
    """The value of the first model; None if it is not a finite number, a truth value or a text."""
    (value,) = column[:1].tolist()
    return None if isinstance(value, float) and not np.isfinite(value) else value
