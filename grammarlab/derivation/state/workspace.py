"""Workspace of one derivation: its tables, records and attribute values. Made by `derive`, discarded afterwards."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.assets.mesh_files import Asset, AssetFolder
from grammarlab.assets.mesh_parts import PartMaterial
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.lots import Lots, Values
from grammarlab.derivation.materials import MaterialTable
from grammarlab.derivation.state.array_table import ArrayTable
from grammarlab.derivation.state.mesh_table import MeshTable
from grammarlab.derivation.state.recorder import Recorder
from grammarlab.derivation.state.shapes import Shapes, Value, join_values, take_value
from grammarlab.derivation.state.street_outlines import PLAN, StreetOutlines
from grammarlab.derivation.state.surroundings import Collector, Surroundings
from grammarlab.derivation.state.tag_table import TagTable
from grammarlab.derivation.state.texture_maps import TextureMapTable, map_name
from grammarlab.derivation.state.trim_planes import TrimPlanes
from grammarlab.derivation.state.width_attribute import StreetWidth, has_widths, widths_of_models
from grammarlab.derivation.strings import StringTable
from grammarlab.errors import (
    AssetError,
    BudgetError,
    DerivationError,
    Location,
    MissingAssetError,
    UnreadableAssetError,
)

Code: TypeAlias = "Callable[[Shapes, Workspace], Value]"
"""A compiled expression."""


@dataclass(frozen=True, slots=True)
class Budget:
    """Bounds on the size of one model, beyond which the derivation stops with an error."""

    shapes: int = 1_000_000
    """Largest number of nodes and parts per model."""
    depth: int = 1_000
    """Largest depth of rewritings by one recursive group of rules."""
    calls: int = 60
    """Largest depth of nested calls of functions."""


def nothing() -> None:
    """Nothing to finish yet."""


@dataclass(frozen=True, slots=True)
class CompiledAttribute:
    """An attribute or constant."""

    name: str
    code: Code
    draws: bool
    """Whether its value is random, so that it must be evaluated for every model."""
    street_width: StreetWidth
    """What its value is on lots whose streets are known."""
    location: Location


@dataclass(slots=True)
class Workspace:
    """Tables, records and attribute values of one derivation."""

    attributes: Mapping[str, CompiledAttribute]
    """The attributes and constants of the grammar, by name."""
    state_names: frozenset[str]
    """Names of the state that rules read or change, see `Program.state_names`."""
    uv_sets: frozenset[int]
    """Texture coordinate sets that rules use, see `Program.uv_sets`."""
    import_prefixes: tuple[str, ...]
    """Beginnings of names of files that were not read, see `Program.import_prefixes`."""
    pending: list[list[Shapes]]
    """Pending shapes of each rule, in the order they were made."""
    lots: Lots
    """[N] the lots of the derivation."""
    origins: Floats
    """[N, 3] `Lots.origins`: origin in the world of the positions of each model's shapes."""
    start_symbols: tuple[str, ...]
    """The symbols of `Lots.start_rules`."""
    roots: Shapes
    """Initial shapes, one per model."""
    strings: StringTable
    frames: FrameTable
    meshes: MeshTable
    materials: MaterialTable
    budget: Budget
    recorder: Recorder
    trim_planes: TrimPlanes
    assets: AssetFolder | None = None
    """Folder that asset paths are relative to and may not leave."""
    tags: TagTable | None = None
    """Sets of tags of faces, if rules read tags."""
    streets: StreetOutlines | None = None
    """Edges along streets, if rules use selectors such as ``street.front`` and something is known of streets."""
    collector: Collector | None = None
    """Shapes for the queries of a second derivation, in the first one of a grammar with spatial queries."""
    surroundings: Surroundings | None = None
    """Shapes that spatial queries see, in the second derivation; otherwise they have their default values."""
    finish: Callable[[], None] = field(default=nothing)
    """Applies the rules of all pending shapes; set when the derivation begins."""
    inline_depth: int = 0
    compared_pairs: int = 0
    """Pairs of shapes that spatial queries have compared."""
    tables: ArrayTable = field(default_factory=ArrayTable)
    texture_maps: TextureMapTable = field(init=False)
    count_again_at: int = field(init=False)
    """Number of nodes up to which no model can have exceeded its budget."""
    call_depth: int = 0
    _attributes: dict[str, Value] = field(default_factory=dict)
    _evaluating: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.count_again_at = self.budget.shapes
        self.texture_maps = TextureMapTable(self.frames)

    @property
    def has_corner_maps(self) -> bool:
        """Whether shapes may have texture coordinates at their corners in place of maps from the world."""
        return self.meshes.has_data or self.texture_maps.has_faces

    @property
    def map_names(self) -> tuple[str, ...]:
        """Names in `Shapes.state` of the ids of the maps that move with shapes."""
        names = tuple([map_name(uv_set) for uv_set in self.uv_sets])
        return names if self.streets is None else (*names, PLAN)

    def start_symbol(self, shapes: Shapes) -> Value:
        """Start symbol of the models of shapes [N]: one text for all, or string ids [N]."""
        names = self.start_symbols
        return names[0] if len(names) == 1 else self.strings.ids(names)[self.lots.start_rule[shapes.model]]

    def attribute(self, name: str) -> Value:
        """The value of an attribute or constant, evaluated once: a scalar or one per model.

        Raises:
            DerivationError: If its value depends on itself.
        """
        if name not in self._attributes:
            self._attributes[name] = self._evaluate(name)
        return self._attributes[name]

    def attribute_of(self, name: str, shapes: Shapes) -> Value:
        """Value of an attribute for shapes [N]: the last value set above them, or that of their model."""
        local = shapes.state.get(name)
        if local is not None:
            return local
        value = self.attribute(name)
        return value.take(shapes.model) if isinstance(value, np.ndarray) else value

    def asset(self, path: str, location: Location) -> Asset | None:
        """A mesh from the asset folder; None, and a record of it, if the file is missing or cannot be read.

        Raises:
            DerivationError: If there is no asset folder, or the file is outside it.
        """
        folder = self._folder(f'asset "{path}"', location)
        with self._noting(path, location):
            return folder.load(path)
        return None

    def material(self, path: str, location: Location) -> PartMaterial | None:
        """The first material of a file of the asset folder; None, and a record of it, if there is none to read.

        Raises:
            DerivationError: If there is no asset folder, or the file is outside it.
        """
        folder = self._folder(f'material "{path}"', location)
        with self._noting(path, location):
            material = folder.load_material(path)
            if material is None:
                hint = "a material needs newmtl with Kd or map_Kd below it"
                message = f'the file "{path}" has no material with a colour or an image'
                self.recorder.add_warning(message, location, hint)
            return material
        return None

    def _folder(self, thing: str, location: Location) -> AssetFolder:
        """The asset folder.

        Raises:
            DerivationError: If there is none.
        """
        if self.assets is None:
            hint = "give the folder of the meshes and images: --assets DIR, or in Python assets='DIR'"
            raise DerivationError(f"the {thing} needs an asset folder", location, hint)
        return self.assets

    @contextmanager
    def _noting(self, path: str, location: Location) -> Iterator[None]:
        """Records a file that is missing or cannot be read, and ends the block.

        Raises:
            DerivationError: If it is outside of the asset folder.
        """
        try:
            yield
        except MissingAssetError:
            self.recorder.add_missing_asset(path, location)
        except UnreadableAssetError as error:
            self.recorder.add_missing_asset(path, location, str(error))
        except AssetError as error:
            raise DerivationError(str(error), location) from error

    def expanded(self, parts: int, shapes: int, location: Location) -> None:
        """Refuse an operation that would make more parts of ``shapes`` shapes than the budget allows.

        Raises:
            BudgetError: If it would, with the operation's place.
        """
        if parts > self.budget.shapes * max(1, min(shapes, self.roots.num)):
            raise BudgetError(
                f"one operation would make {parts} parts of {shapes} shapes, more than the budget of "
                f"{self.budget.shapes} per model",
                location,
                "a size in a repeated split may be far too small; raise the shape budget if this is intended",
            )

    def _evaluate(self, name: str) -> Value:
        attribute = self.attributes[name]
        column = self.lots.attributes.get(name)
        num_models = self.roots.num
        if column is None and (attribute.street_width == "none" or self.lots.footprints.street_width is None):
            return self._from_rules(attribute, np.arange(num_models))
        is_given = np.zeros(num_models, dtype=bool) if column is None else column.is_given
        has_width = has_widths(self.lots, attribute.street_width) & ~is_given
        outside, of_lots = np.flatnonzero(is_given), np.flatnonzero(has_width)
        inside = np.flatnonzero(~(is_given | has_width))
        values: list[tuple[NDArray[np.int64], Value]] = []
        if len(inside) or num_models == 0:
            values.append((inside, self._from_rules(attribute, inside)))
        if column is not None and len(outside):
            values.append((outside, self._from_outside(column.values[outside])))
        if len(of_lots):
            values.append((of_lots, widths_of_models(self.lots, of_lots, attribute.street_width, self.tables)))
        if len(values) == 1:
            return values[0][1]
        try:
            joined = join_values([value for _, value in values], [len(rows) for rows, _ in values], self.strings)
        except DerivationError as error:
            hint = "give every model, or none, a value of another type than the rule file does"
            raise DerivationError(
                f"the value of {name} differs between models: {error}", attribute.location, hint
            ) from error
        return take_value(joined, np.argsort(np.concatenate([rows for rows, _ in values])))

    def _from_rules(self, attribute: CompiledAttribute, rows: NDArray[np.int64]) -> Value:
        """The value in the rule file for the models at these rows."""
        name = attribute.name
        if name in self._evaluating:
            chain = " -> ".join([*self._evaluating[self._evaluating.index(name) :], name])
            raise DerivationError(f"the value of {name} depends on itself: {chain}", attribute.location)
        self._evaluating.append(name)
        try:
            return attribute.code(self.roots if len(rows) == self.roots.num else self.roots.take(rows), self)
        finally:
            self._evaluating.pop()

    def _from_outside(self, values: Values) -> Value:
        """Values [K] from outside in the types of rules; one value if all are the same to the last bit."""
        if values.tobytes() == values[:1].tobytes() * len(values):
            return values[0].item()
        if values.dtype.kind == "U":
            return self.strings.ids(values.tolist())
        return cast("Value", values)
