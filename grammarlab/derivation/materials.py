"""Materials of surfaces, interned so that a shape has one integer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import distinct, ranked

CHANNELS = {
    "color.r": 1.0,
    "color.g": 1.0,
    "color.b": 1.0,
    "opacity": 1.0,
    "metallic": 0.0,
    "roughness": 0.8,
    "emissive.r": 0.0,
    "emissive.g": 0.0,
    "emissive.b": 0.0,
}
"""Numbers of a material and their values on an initial shape, all in 0..1; colours are sRGB, as in CGA."""

_OTHER_MAPS = ("bump", "dirt", "specular", "opacity", "normal", "emissive", "occlusion", "roughness", "metallic")
_IDENTITY = {"su": 1.0, "sv": 1.0, "tu": 0.0, "tv": 0.0, "rw": 0.0}

REMEMBERED: dict[str, float | str | bool] = {
    "name": "",
    "shader": "CityEngineShader",
    "doubleSided": True,
    "reflectivity": 0.0,
    "shininess": 1.0,
    "bumpValue": 1.0,
    **{f"{light}.{channel}": 0.0 for light in ("ambient", "specular") for channel in "rgb"},
    **{f"{kind}map": "" for kind in _OTHER_MAPS},
    **{f"{kind}map.{part}": value for kind in ("color", *_OTHER_MAPS) for part, value in _IDENTITY.items()},
}
"""Other material attributes of CGA, with their values on an initial shape; rules may read them, pictures do not."""


@dataclass(frozen=True, slots=True)
class Materials:
    """K materials as columns."""

    channels: NDArray[np.float64]
    """[K, 9] in the order of `CHANNELS`."""
    textures: tuple[str, ...]
    """[K] path of the colour map relative to the asset folder, empty for none."""
    pictures: Mapping[str, bytes] = field(default_factory=dict)
    """Contents of PNG or JPEG files by their names in `textures`: pictures that no asset folder has."""
    cut_out: frozenset[str] = frozenset()
    """Names of textures whose transparent parts are holes; the transparency of the others is ignored."""
    thin: frozenset[int] = frozenset()
    """Rows of materials through which light passes to the other side, as through leaves; pictures show it."""

    def __len__(self) -> int:
        return len(self.textures)

    @property
    def color(self) -> NDArray[np.float64]:
        """[K, 3] sRGB in 0..1."""
        return self.channels[:, 0:3]

    @property
    def opacity(self) -> NDArray[np.float64]:
        return self.channels[:, 3]

    @property
    def metallic(self) -> NDArray[np.float64]:
        return self.channels[:, 4]

    @property
    def roughness(self) -> NDArray[np.float64]:
        return self.channels[:, 5]

    @property
    def emissive(self) -> NDArray[np.float64]:
        """[K, 3] sRGB in 0..1."""
        return self.channels[:, 6:9]


class MaterialTable:
    """The different materials of one derivation. Id 0 is the material of an initial shape.

    A shape whose faces have several materials has one id for all of them, a palette: a change of the id is a change of
    each of them. To rules, a palette looks like its first material.
    """

    def __init__(self) -> None:
        default_row = (*CHANNELS.values(), "")
        self._ids: dict[tuple[float | str, ...], int] = {default_row: 0}
        self._rows: list[tuple[float | str, ...]] = [default_row]
        self._palettes: dict[tuple[int, ...], int] = {}
        self._members: dict[int, tuple[int, ...]] = {}
        self.cut_out: set[str] = set()
        """As in `Materials`."""

    def changed(
        self, materials: NDArray[np.int32], changes: Mapping[str, float | str | NDArray[np.float64]]
    ) -> NDArray[np.int32]:
        """Materials [N] with some channels changed.

        Args:
            materials: [N] ids.
            changes: channel (a name of `CHANNELS`, or ``texture``) to its new value: one for all, or [N].
        """
        columns = {name: value for name, value in changes.items() if isinstance(value, np.ndarray)}
        constants = {name: value for name, value in changes.items() if not isinstance(value, np.ndarray)}
        table = np.column_stack([materials.astype(np.float64), *columns.values()])
        unique, inverse = np.unique(table, axis=0, return_inverse=True) if len(table) > 1 else (table, np.zeros(1, int))
        ids = [
            self._intern(int(row[0]), {**constants, **dict(zip(columns, row[1:].tolist(), strict=True))})
            for row in unique
        ]
        return np.array(ids, dtype=np.int32)[inverse]

    def changed_by_code(
        self,
        materials: NDArray[np.int32],
        codes: NDArray[np.int32],
        changes: Callable[[int], Mapping[str, float | str]],
    ) -> NDArray[np.int32]:
        """Materials [N] changed by ``changes`` of their codes [N], which is called once for each different code."""
        changes_by_code: dict[int, Mapping[str, float | str]] = {}
        base = int(codes.max(initial=0)) + 1
        pairs, inverse = ranked(materials.astype(np.int64) * base + codes, len(self._rows) * base)
        ids = []
        for pair in pairs.tolist():
            material, code = divmod(pair, base)
            if code not in changes_by_code:
                changes_by_code[code] = changes(code)
            ids.append(self._intern(material, changes_by_code[code]))
        return np.array(ids, dtype=np.int32)[inverse]

    def repainted(self, materials: NDArray[np.int32], constants: Mapping[str, float | str]) -> NDArray[np.int32]:
        """Materials [N] with some channels set to the same constant for all."""
        first = materials[0]
        if (materials == first).all():
            return np.full(len(materials), self._intern(int(first), constants), dtype=np.int32)
        table = np.zeros(len(self._rows), np.int32)  # computed first, since interning adds rows
        for used in distinct(materials, len(self._rows)).tolist():
            table[used] = self._intern(used, constants)
        return table[materials]

    def inserted(
        self, materials: NDArray[np.int32], of_asset: Sequence[Mapping[str, float | str] | None]
    ) -> NDArray[np.int32]:
        """Materials [N] of shapes after an asset with materials was inserted.

        Args:
            materials: [N] ids before.
            of_asset: all channels of each material of the asset; None for faces that keep the material of the shape.
        """
        used, inverse = ranked(materials, len(self._rows))
        ids = []
        for material in used.tolist():
            members = [material if channels is None else self._intern(0, channels) for channels in of_asset]
            ids.append(self.palette([self.members(member)[0] for member in members]))
        return np.array(ids, dtype=np.int32)[inverse]

    def without(self, materials: NDArray[np.int32], assets: NDArray[np.int32]) -> NDArray[np.int32]:
        """Materials [N] without what they have from the materials of assets [N]: only what was changed since."""
        pairs, inverse = np.unique(np.column_stack((materials, assets)), axis=0, return_inverse=True)
        ids = [self.palette([self._difference(*both) for both in self._slots(*pair)]) for pair in pairs.tolist()]
        return np.array(ids, dtype=np.int32)[inverse.ravel()]

    def _slots(self, material: int, asset: int) -> list[tuple[int, int]]:
        """The members of two materials by the slots of faces; those of one are repeated for all slots of the other."""
        one, other = self.members(material), self.members(asset)
        count = max(len(one), len(other))
        return list(zip((one * count)[:count], (other * count)[:count], strict=True))

    def _difference(self, material: int, asset: int) -> int:
        changed = self._changed(material, asset)
        return self._intern(0, {name: self._rows[material][_INDEX_OF_CHANNEL[name]] for name in changed})

    def _changed(self, material: int, other: int) -> list[str]:
        """Channels of which one material differs from another; the three of a colour are set together."""
        rows = list(zip(_INDEX_OF_CHANNEL, self._rows[material], self._rows[other], strict=True))
        groups = {name.partition(".")[0] for name, value, other_value in rows if value != other_value}
        return [name for name, *_ in rows if name.partition(".")[0] in groups]

    def attributes(self, material: int, *, changed: bool) -> dict[str, float | str]:
        """Attributes of one material by their names in CGA, without ``material.``; those of a palette's first member.

        Args:
            material: its id.
            changed: whether only those are of interest that differ from the material of an initial shape.
        """
        names = self._changed(material, 0) if changed else _INDEX_OF_CHANNEL
        row = self._rows[material]
        return {"colormap" if name == "texture" else name: row[_INDEX_OF_CHANNEL[name]] for name in names}

    def members(self, material: int) -> tuple[int, ...]:
        """The materials of a palette by the slots of faces; the material itself for other ids."""
        return self._members.get(material, (material,))

    @property
    def has_palettes(self) -> bool:
        """Whether some shapes have several materials."""
        return bool(self._members)

    def channel(self, materials: NDArray[np.int32], name: str) -> NDArray[np.float64]:
        """One number of each material [N]."""
        index = _INDEX_OF_CHANNEL[name]
        return np.array([row[index] for row in self._rows], dtype=np.float64)[materials]

    def texture(self, material: int) -> str:
        """The path of the colour map of one material."""
        return str(self._rows[material][-1])

    def freeze(self) -> Materials:
        """All materials as columns."""
        channels = np.array([row[:-1] for row in self._rows], dtype=np.float64)
        return Materials(channels, tuple(str(row[-1]) for row in self._rows), cut_out=frozenset(self.cut_out))

    def palette(self, members: Sequence[int]) -> int:
        """The id of shapes whose faces have these materials, by their slots; none of them is a palette."""
        key = tuple(members)
        if len(set(key)) == 1:
            return key[0]
        if key not in self._palettes:
            self._palettes[key] = len(self._rows)
            self._members[len(self._rows)] = key
            self._rows.append(self._rows[key[0]])
        return self._palettes[key]

    def _intern(self, material: int, changes: Mapping[str, float | str]) -> int:
        if material in self._members:
            return self.palette([self._intern(member, changes) for member in self._members[material]])
        row = list(self._rows[material])
        for name, value in changes.items():
            row[_INDEX_OF_CHANNEL[name]] = value
        key = tuple(row)
        index = self._ids.get(key)
        if index is None:
            index = self._ids[key] = len(self._rows)
            self._rows.append(key)
        return index


_INDEX_OF_CHANNEL = {name: index for index, name in enumerate((*CHANNELS, "texture"))}
