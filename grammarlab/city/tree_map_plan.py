"""The map of trees of a plan: what the species of its parks and streets are learned from.

```toml
[tree_map]
file = "inventory.geojson"
field = "botanical"
area = "parks.geojson"
[tree_map.species]
oak = ["Quercus", "Platanus"]
birch = ["Betula pendula"]
```
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grammarlab.city.plan_tables import PlanTables
from grammarlab.city.polygon_text import located_polygon
from grammarlab.city.tree_names import MAX_SPECIES, words_of
from grammarlab.errors import shown

SUFFIX = ".trees.json"
"""Suffix of the files of learned intensities (`grammarlab.city.tree_file`)."""
DEFAULT_FIELD = "species"
_MOST_NAMES = 4096
"""Most names on the map for one species."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TreeMapPlan:
    """A map of trees, and which of its names are which species."""

    file: Path
    """Map of points."""
    field: str = DEFAULT_FIELD
    """Field of the map with the name of the species."""
    area: str = ""
    """Where the map has all trees: WKT, or the path of a file, as for zones; empty for what is near its trees."""
    species: Mapping[str, tuple[str, ...]]
    """Names on the map by species, which are shipped ones or the paths of files. A name stands for all longer ones that
    begin with its words. If there are none, the names on the map are those of shipped species."""


def is_tree_file(name: str) -> bool:
    """Whether a grammar of a plan is a file of learned intensities.

    >>> is_tree_file("parks.trees.json"), is_tree_file("oak")
    (True, False)
    """
    return name.lower().endswith(SUFFIX)


def tree_map_plan(tables: PlanTables, folder: Path) -> TreeMapPlan | None:
    """The map of trees of a plan; None if it has none.

    Args:
        tables: tables of the plan, which collect the mistakes.
        folder: folder that paths are relative to.
    """
    keys = ("tree_map",)
    if tables.value(keys) is None:
        return None
    tables.table(keys, ("file", "field", "area", "species"))
    return TreeMapPlan(
        file=folder / tables.text((*keys, "file"), required=True),
        field=tables.text((*keys, "field"), DEFAULT_FIELD) or DEFAULT_FIELD,
        area=located_polygon(tables.text((*keys, "area")), folder),
        species=_species(tables, folder),
    )


def _species(tables: PlanTables, folder: Path) -> Mapping[str, tuple[str, ...]]:
    keys = ("tree_map", "species")
    table = tables.table(keys, None)
    if len(table) > MAX_SPECIES:
        tables.report("too-many", f"expected at most {MAX_SPECIES} species, found {len(table)}", keys)
    species, owner = dict[str, tuple[str, ...]](), dict[tuple[str, ...], str]()
    for name, value in table.items():
        names = value if isinstance(value, list) else [value]
        if not 1 <= len(names) <= _MOST_NAMES or not all(isinstance(each, str) and each.strip() for each in names):
            message = f'expected {name} = ["…"], names on the map, found {shown(value)}'
            tables.report("wrong-type", message, (*keys, name))
            continue
        for each in names:
            other = owner.setdefault(words_of(each), name)
            if other != name:
                message = f"{shown(each)} is a name of {shown(other)} already"
                tables.report("repeated", message, (*keys, name))
        species[str(folder / name) if Path(name).suffix else name] = tuple(names)
    return species
