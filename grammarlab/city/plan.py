"""Plans: what a city is made from, read from a TOML file.

```toml
parcels = "parcels.gpkg"

[[zones]]
name = "centre"
grammar = "building"
where = "area > 200 and use != 'park'"
attributes = { height = "= 3 * floors" }
```

Paths are relative to the folder of the plan and may lead anywhere: its user writes a plan, as a command line.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

from grammarlab.city.layout_plan import LayoutPlan, layout_plan
from grammarlab.city.plan_fields import check_condition
from grammarlab.city.plan_tables import Keys, PlanTables
from grammarlab.city.polygon_text import located_polygon
from grammarlab.city.tree_map_plan import TreeMapPlan, is_tree_file, tree_map_plan
from grammarlab.errors import AssetError, Finding, LanguageError, Location, TomlError, UsageError, shown
from grammarlab.files import read_bounded
from grammarlab.toml_text import toml_text

SUFFIX = ".toml"
MAX_BYTES = 1 << 20
"""Largest size of a plan in bytes."""
PINS = "pins.csv"
"""Name of the file of pins beside a plan that names none."""
FootprintRule: TypeAlias = Literal["setback", "parcel", "ring"]
"""Ground of a building: the parcel without its setbacks, the whole parcel, or a ring along its outline."""
FOOTPRINT_RULES: tuple[FootprintRule, ...] = ("setback", "parcel", "ring")
PlanValue: TypeAlias = float | bool | str


@dataclass(frozen=True, slots=True)
class Setbacks:
    """Distances in metres between the edges of a parcel and its building, by kind of edge."""

    front: float = 3.0
    """From edges along a street."""
    side: float = 2.0
    """From edges to the left and the right."""
    back: float = 5.0
    """From edges opposite the street."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LotRules:
    """What footprints must be like; parcels without such a footprint stay empty."""

    setbacks: Setbacks = Setbacks()
    least_area: float = 60.0
    """Smallest area of a footprint in square metres."""
    least_side: float = 4.0
    """Smallest width of a footprint in metres, measured across its narrowest bounding box."""
    most_area: float = 5_000.0
    """Largest area of a footprint in square metres."""
    ring_depth: float = 12.0
    """Depth in metres of the buildings of a perimeter ring."""
    least_court: float = 60.0
    """Smallest area of the court of a ring in square metres; smaller courts are built over."""


@dataclass(frozen=True, slots=True)
class FieldFormula:
    """The value of an attribute: an expression over fields of the parcel, ``3 * floors``, or the name of one field."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ZonePlan:
    """A zone: which parcels it has, and what stands on them. A parcel has the first zone whose conditions all hold."""

    name: str
    grammar: str
    """Name of a shipped grammar or species, or the path of a file: rules, a facade grammar, or for parks a species or
    the learned intensities of several ones (NAME.trees.json)."""
    where: str = ""
    """Condition over fields of the parcel; empty for none."""
    match: Mapping[str, tuple[PlanValue, ...]] = field(default_factory=dict)
    """Allowed values of fields; each of these fields must have one of its values."""
    polygon: str = ""
    """WKT, or the path of a file: a point inside the parcel must be in it; empty for none. WKT is in the coordinate
    system of the frame unless it begins with ``SRID=…;``."""
    density: Path | None = None
    """File of learned zones (NAME.zones.json): the parcel must draw the name of this zone."""
    attributes: Mapping[str, PlanValue | FieldFormula] = field(default_factory=dict)
    setbacks: Setbacks | None = None
    """Setbacks instead of those of the plan."""
    footprint: FootprintRule | None = None
    """None for the default: the parcel without setbacks for buildings, the whole parcel for trees."""
    start: str = ""
    """Start rule; empty for the one that fits the parcel (`grammarlab.city.site_making`)."""
    trees_per_hectare: float | None = None
    """Density of trees if the grammar is one species; None for its usual one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StreetTrees:
    """Trees along the streets."""

    species: str
    """Name of a shipped species, or the path of its file; or that of learned intensities of several ones."""
    spacing: float = 10.0
    """Metres between trees along the street."""
    offset: float = 1.5
    """Metres from the edges of parcels towards the street."""
    least_width: float = 8.0
    """Metres; narrower streets have no trees."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldSource:
    """A field of parcels that does not come from their file."""

    name: str
    raster: Path | None = None
    """Raster file: the value at a point inside the parcel."""
    distance: Path | None = None
    """Vector file: metres to its nearest shape."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """All that a city is made from."""

    path: Path
    """File of the plan."""
    parcels: Path | None = None
    """File of parcels; None if there is a layout."""
    layout: LayoutPlan | None = None
    """Area to divide into parcels; None if there is a file of parcels."""
    crs: str | None = None
    """Coordinate system of the file instead of the one that it names; ``local`` for metres at an unknown place."""
    id_field: str | None = None
    """Field with the ids of parcels; None for the one that the reader finds."""
    seed: int = 0
    """0 <= seed < 2**64."""
    streets: Path | None = None
    """File with centre lines of streets."""
    street_width: str | None = None
    """Field of the parcels with the widths of their streets in metres, one or a list by edge, instead of other ones."""
    street_plots: str = ""
    """Condition over fields of the map for parcels that are streets; empty to know them by their shape."""
    terrain: Path | None = None
    """Raster file of heights in metres."""
    geoid_height: float | None = None
    """Height of the geoid above the ellipsoid in metres; None if heights are to be kept as given."""
    pins: Path
    """Table of pins, which need not exist."""
    lots: LotRules = LotRules()
    fields: tuple[FieldSource, ...] = ()
    zones: tuple[ZonePlan, ...]
    """At least one, in the order of their precedence, with different names."""
    street_trees: StreetTrees | None = None
    tree_map: TreeMapPlan | None = None
    """What intensities of species are learned from."""

    @property
    def folder(self) -> Path:
        """Folder of the plan, which paths are relative to."""
        return self.path.parent


def read_plan(path: Path) -> Plan:
    """Read a plan.

    Raises:
        UsageError: If there is no such file, or it is not a text file of a usual size.
        LanguageError: If it has mistakes; with a finding for each, with line and column.
    """
    if not path.is_file():
        raise UsageError(f'no plan {str(path)!r}: expected a TOML file with parcels = "FILE" and [[zones]].')
    try:
        text = toml_text(read_bounded(path, MAX_BYTES))
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from None
    except AssetError as error:
        raise UsageError(f"{error} A plan is a short text file.") from None
    except TomlError as error:
        place = Location(error.line or 1, error.column or 1, 1, str(path))
        raise LanguageError((Finding("error", "syntax", error.message, place),)) from None
    return parse_plan(text, path)


def parse_plan(text: str, path: Path) -> Plan:
    r"""The plan of a text.

    Args:
        text: the whole file.
        path: path of the file; paths in it are relative to its folder.

    Raises:
        LanguageError: If it has mistakes; with a finding for each.

    >>> plan = parse_plan('parcels = "lots.gpkg"\n[[zones]]\nname = "all"\ngrammar = "building"', Path("plan.toml"))
    >>> plan.zones[0].grammar, plan.lots.setbacks.front
    ('building', 3.0)
    """
    return _PlanReader(PlanTables(text, str(path)), path).plan()


_KEYS = (
    *(
        "parcels",
        "layout",
        "crs",
        "id",
        "seed",
        "streets",
        "street_width",
        "street_plots",
        "terrain",
        "geoid_height",
        "pins",
    ),
    *("setbacks", "minimum", "maximum", "ring", "fields", "zones", "street_trees", "tree_map"),
)
_ZONE_KEYS = (
    *("name", "grammar", "where", "match", "polygon", "density", "attributes", "setbacks", "footprint", "start"),
    "trees_per_hectare",
)
_MOST_ZONES = 256
_MOST_FIELDS = 64
_LONGEST = 1_000.0
"""Largest setback, depth, width or side in metres."""
_LARGEST = 1e8
"""Largest area in square metres."""
_ZONE_NAME = re.compile(r"[^\W_][\w .+-]{0,63}")
_FIELD_NAME = re.compile(r"[^\W\d]\w{0,63}")


@dataclass(frozen=True, slots=True)
class _PlanReader:
    """Makes a plan from the tables of a file."""

    tables: PlanTables
    path: Path

    def plan(self) -> Plan:
        tables = self.tables
        tables.table((), _KEYS)
        seed = tables.integer(("seed",), 0, 0, 2**64 - 1)
        parcels, layout = self._ground(seed)
        plan = Plan(
            path=self.path,
            parcels=parcels,
            layout=layout,
            crs=tables.text(("crs",)) or None,
            id_field=tables.text(("id",)) or None,
            seed=seed,
            streets=self._file(("streets",)),
            street_width=tables.text(("street_width",)) or None,
            street_plots=self._condition(("street_plots",)),
            terrain=self._file(("terrain",)),
            geoid_height=tables.optional_number(("geoid_height",), -200.0, 200.0),
            pins=self._file(("pins",)) or self.path.parent / PINS,
            lots=self._lots(),
            fields=tuple(self._field(number) for number in range(tables.tables("fields", _MOST_FIELDS))),
            zones=self._zones(),
            street_trees=self._street_trees(),
            tree_map=tree_map_plan(tables, self.path.parent),
        )
        tables.raise_findings()
        return plan

    def _ground(self, seed: int) -> tuple[Path | None, LayoutPlan | None]:
        """The file of parcels or the layout: one of them."""
        parcels, layout = self._file(("parcels",)), layout_plan(self.tables, self.path.parent, seed)
        both = "parcels" in self.tables.root, "layout" in self.tables.root
        if not any(both):
            hint = 'give parcels = "FILE", or [layout] where there is no map'
            self.tables.report("missing", "expected parcels, found none", (), hint)
        elif all(both):
            self.tables.report("conflict", "expected either parcels or [layout], found both", ("layout",), at_key=True)
        return parcels, layout

    def _file(self, keys: Keys) -> Path | None:
        name = self.tables.text(keys)
        return self.path.parent / name if name else None

    def _lots(self) -> LotRules:
        tables, default = self.tables, LotRules()
        for table, keys in (("minimum", ("area", "side")), ("maximum", ("area",)), ("ring", ("depth", "court"))):
            tables.table((table,), keys)
        return LotRules(
            setbacks=self._setbacks(("setbacks",), default.setbacks),
            least_area=tables.number(("minimum", "area"), default.least_area, 0.0, _LARGEST),
            least_side=tables.number(("minimum", "side"), default.least_side, 0.0, _LONGEST),
            most_area=tables.number(("maximum", "area"), default.most_area, 1.0, _LARGEST),
            ring_depth=tables.number(("ring", "depth"), default.ring_depth, 1.0, _LONGEST),
            least_court=tables.number(("ring", "court"), default.least_court, 0.0, _LARGEST),
        )

    def _setbacks(self, keys: Keys, default: Setbacks) -> Setbacks:
        kinds = ("front", "side", "back")
        self.tables.table(keys, kinds)
        distances = {kind: self.tables.number((*keys, kind), getattr(default, kind), 0.0, _LONGEST) for kind in kinds}
        return Setbacks(**distances)

    def _field(self, number: int) -> FieldSource:
        keys = ("fields", number)
        self.tables.table(keys, ("name", "raster", "distance"))
        name = self.tables.text((*keys, "name"), required=True)
        if name and not _FIELD_NAME.fullmatch(name):
            self.tables.report("wrong-name", f"expected letters, digits and _, found {shown(name)}", (*keys, "name"))
        raster, distance = self._file((*keys, "raster")), self._file((*keys, "distance"))
        if (raster is None) == (distance is None):
            self.tables.report("missing", 'expected either raster = "FILE" or distance = "FILE"', keys)
        return FieldSource(name=name, raster=raster, distance=distance)

    def _zones(self) -> tuple[ZonePlan, ...]:
        zones = tuple(self._zone(number) for number in range(self.tables.tables("zones", _MOST_ZONES)))
        if not zones and not self.tables.findings:
            hint = 'give at least [[zones]] with name = "…" and grammar = "…"'
            self.tables.report("missing", "expected zones, found none", (), hint)
        names = [zone.name for zone in zones]
        for number, name in enumerate(names):
            if name and name in names[:number]:
                self.tables.report("repeated", f"zone {shown(name)} exists already", ("zones", number, "name"))
        return zones

    def _zone(self, number: int) -> ZonePlan:
        tables, keys = self.tables, ("zones", number)
        tables.table(keys, _ZONE_KEYS)
        name = tables.text((*keys, "name"), required=True)
        if name and not _ZONE_NAME.fullmatch(name):
            message = f"expected a name of at most 64 letters, digits, blanks, dots, _, + and -, found {shown(name)}"
            tables.report("wrong-name", message, (*keys, "name"))
        has_setbacks = tables.value((*keys, "setbacks")) is not None
        grammar = self._grammar((*keys, "grammar"))
        if is_tree_file(grammar) and tables.value((*keys, "trees_per_hectare")) is not None:
            message = "expected trees_per_hectare with one species; learned trees have their own density"
            tables.report("conflict", message, (*keys, "trees_per_hectare"), at_key=True)
        return ZonePlan(
            name=name,
            grammar=grammar,
            where=self._condition((*keys, "where")),
            match=self._match((*keys, "match")),
            polygon=located_polygon(tables.text((*keys, "polygon")), self.path.parent),
            density=self._file((*keys, "density")),
            attributes=self._attributes((*keys, "attributes")),
            setbacks=self._setbacks((*keys, "setbacks"), self._lots().setbacks) if has_setbacks else None,
            footprint=tables.choice((*keys, "footprint"), FOOTPRINT_RULES),
            start=tables.text((*keys, "start")),
            trees_per_hectare=tables.optional_number((*keys, "trees_per_hectare"), 0.0, 1e6),
        )

    def _grammar(self, keys: Keys) -> str:
        """A shipped name as it is, or the path of a file, which has a suffix."""
        text = self.tables.text(keys, required=True)
        return str(self.path.parent / text) if Path(text).suffix else text

    def _condition(self, keys: Keys) -> str:
        text = self.tables.text(keys)
        if text:
            self._check(text, keys)
        return text

    def _check(self, text: str, keys: Keys) -> None:
        try:
            check_condition(text)
        except UsageError as error:
            self.tables.report("expression", str(error), keys)

    def _match(self, keys: Keys) -> Mapping[str, tuple[PlanValue, ...]]:
        allowed: dict[str, tuple[PlanValue, ...]] = {}
        for name, value in self.tables.table(keys, None).items():
            values = tuple(value) if isinstance(value, list) else (value,)
            if not values or not all(isinstance(item, int | float | str) for item in values):
                message = f"expected a value or a list of values for {shown(name)}, found {shown(value)}"
                self.tables.report("wrong-type", message, (*keys, name))
            else:
                allowed[name] = values
        return allowed

    def _attributes(self, keys: Keys) -> Mapping[str, PlanValue | FieldFormula]:
        attributes: dict[str, PlanValue | FieldFormula] = {}
        for name, value in self.tables.table(keys, None).items():
            if isinstance(value, str) and value.lstrip().startswith("="):
                formula = value.lstrip()[1:].strip()
                self._check(formula, (*keys, name))
                attributes[name] = FieldFormula(formula)
            elif isinstance(value, int | float | str):
                attributes[name] = float(value) if isinstance(value, int) and not isinstance(value, bool) else value
            else:
                message = f'expected a number, true, false, a text or "= expression", found {shown(value)}'
                self.tables.report("wrong-type", message, (*keys, name))
        return attributes

    def _street_trees(self) -> StreetTrees | None:
        tables = self.tables
        if "street_trees" not in tables.root:
            return None
        names = ("spacing", "offset", "least_width")
        tables.table(("street_trees",), ("species", *names))
        low = {"spacing": 1.0, "offset": -_LONGEST, "least_width": 0.0}
        default = StreetTrees(species="")
        numbers = {
            name: tables.number(("street_trees", name), getattr(default, name), low[name], _LONGEST) for name in names
        }
        return StreetTrees(species=self._grammar(("street_trees", "species")), **numbers)
