"""Species files: TOML with a line per parameter, which a person reads and edits.

```toml
about = "An English oak that stands alone, some forty years old."

[tree]
scale = { value = 13.0, spread = 1.0, range = [10.0, 16.0], unit = "m", why = "height in open ground" }
levels = 3

[level_1]
curve_1 = { value = 40.0, spread = 90.0, spread_range = [60.0, 110.0], unit = "deg", why = "zigzag boughs" }
```

``value`` is the typical value, ``spread`` the model's ±. A tree draws its own value from ``range``, and its own spread
from ``spread_range``; without them it takes ``value`` and ``spread``. ``[[kinds]]`` has ranges instead of those above.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import PurePath

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import Finding, LanguageError, Location, TomlError
from grammarlab.toml_text import toml_table
from grammarlab.trees.contradictions import contradictions
from grammarlab.trees.parameters import COLUMN, COLUMNS, DEFAULTS, IS_INTEGER, PARAMETERS, SPREAD, Parameter
from grammarlab.trees.species import Look, Species
from grammarlab.trees.species_places import Path, Places
from grammarlab.trees.species_tables import SECTIONS, SpeciesTables, TooManyFindings

MAX_CHARACTERS = 1 << 19
"""Largest number of characters of a file."""


def parse(text: str, name: str) -> Species:
    r"""The species of a file.

    Args:
        text: the whole file.
        name: its name, for messages; the species is called as it without folders and suffix.

    Raises:
        LanguageError: With a finding for every mistake.

    >>> import grammarlab as gl
    >>> shrub = gl.parse_species("[tree]\nscale = 2.0\nlevels = 2", "shrub")
    >>> gl.sample(shrub, 3, seed=1).num_trees
    3
    """
    species, findings, _ = _read(text, name)
    if species is None:
        raise LanguageError(findings, text)
    return species


def check(text: str, name: str) -> tuple[Finding, ...]:
    """Findings about a file: its errors or, if it has none, warnings about parameters that contradict each other."""
    species, findings, paths = _read(text, name)
    return findings if species is None else contradictions(species, Places(text, name), paths)


def _read(text: str, name: str) -> tuple[Species | None, tuple[Finding, ...], Mapping[str, Path]]:
    """The species, or None and all errors; and the path of each parameter that the file names."""
    if len(text) > MAX_CHARACTERS:
        message = f"expected a file of at most {MAX_CHARACTERS:,} characters, found {len(text):,}"
        return None, (Finding("error", "too-large", message, Location(file=name)),), {}
    try:
        table = toml_table(text)
    except TomlError as error:
        place = Location(error.line or 1, error.column or 1, 1, name)
        return None, (Finding("error", "syntax", error.message, place),), {}
    tables = SpeciesTables(table, Places(text, name))
    try:
        species = tables.species(PurePath(name).stem)
    except TooManyFindings:
        return None, _in_order(tables.findings), {}
    return (None if tables.findings else species), _in_order(tables.findings), tables.paths


def _in_order(findings: list[Finding]) -> tuple[Finding, ...]:
    """Findings as their places follow each other in the file."""
    return tuple(sorted(findings, key=lambda finding: finding.location))


def write(species: Species) -> str:
    r"""The file of a species, in its canonical form: `parse` reads an equal one from it.

    Parameters with their default value and no reason are left out.

    >>> import grammarlab as gl
    >>> print(gl.write_species(gl.parse_species("[tree]\nscale = 2", "shrub")), end="")
    [tree]
    scale = { value = 2.0, unit = "m" }
    """
    blocks = [_head(species), *_sections(species), *_kinds(species)]
    return "\n\n".join("\n".join(block) for block in blocks if block) + "\n"


def _head(species: Species) -> list[str]:
    lines = [f"{key} = {_text(text)}" for key in ("about", "acceptance") if (text := getattr(species, key))]
    look = [
        f"{key} = {_look_value(getattr(species.look, key))}"
        for key in Look.__dataclass_fields__
        if getattr(species.look, key) != getattr(Look(), key)
    ]
    return [*lines, *([""] if lines and look else []), *(["[look]", *look] if look else [])]


def _look_value(value: str | tuple[float, float, float]) -> str:
    if isinstance(value, str):
        return _text(value)
    octets = [round(share * 255) for share in value]
    if all(octet / 255 == share for octet, share in zip(octets, value, strict=True)):
        return _text("#" + bytes(octets).hex())
    return f"[{', '.join(repr(float(share)) for share in value)}]"


def _sections(species: Species) -> Iterator[list[str]]:
    low, high = _common_ranges(species)
    lines: dict[str, list[str]] = {section: [] for section in SECTIONS}
    for parameter in PARAMETERS.values():
        if line := _line(parameter, species, low, high):
            lines[_section(parameter.name)].append(line)
    for section, rows in lines.items():
        if rows:
            yield [f"[{section}]", *rows]


def _section(name: str) -> str:
    """The heading of a parameter."""
    if name[-2:-1] == "_" and name[-1].isdigit():
        return f"level_{name[-1]}" if name[-1] != "0" else "trunk"
    if name == "base_splits":
        return "trunk"
    return "leaves" if name.startswith(("leaf_", "leaves", "blossom_")) else "tree"


def _common_ranges(species: Species) -> tuple[Floats, Floats]:
    """[P] starts and ends of the ranges that more than half of the kinds have; elsewhere the typical value."""
    low, high = (np.stack([getattr(kind, end) for kind in species.kinds]) for end in ("low", "high"))
    same = (low[:, None] == low) & (high[:, None] == high)
    count = same.sum(axis=1)
    best = count.argmax(axis=0)
    columns = np.arange(len(COLUMNS))
    low, high = (ends[best, columns] for ends in (low, high))
    typical = species.typical
    is_common = (2 * count[best, columns] > len(species.kinds)) & (low <= typical) & (typical <= high)
    return np.where(is_common, low, typical), np.where(is_common, high, typical)


def _line(parameter: Parameter, species: Species, low: Floats, high: Floats) -> str:
    """The line of a parameter; empty if it has its default."""
    name, typical = parameter.name, species.typical
    entries = [f"value = {_number(name, typical[COLUMN[name]])}"]
    spread = name + SPREAD if parameter.spread is not None else ""
    if spread and (typical[COLUMN[spread]] or low[COLUMN[spread]] or high[COLUMN[spread]]):
        entries.append(f"spread = {_number(spread, typical[COLUMN[spread]])}")
    entries += [
        f"{key} = {_range(column, low[COLUMN[column]], high[COLUMN[column]])}"
        for key, column in (("range", name), ("spread_range", spread))
        if column and not low[COLUMN[column]] == high[COLUMN[column]] == typical[COLUMN[column]]
    ]
    reason = species.why.get(name, "")
    if len(entries) == 1 and not reason and typical[COLUMN[name]] == DEFAULTS[COLUMN[name]]:
        return ""
    if parameter.unit:
        entries.append(f'unit = "{parameter.unit}"')
    if reason:
        entries.append(f"why = {_text(reason)}")
    if len(entries) == 1:
        return f"{name} = {_number(name, typical[COLUMN[name]])}"
    return f"{name} = {{ {', '.join(entries)} }}"


def _kinds(species: Species) -> Iterator[list[str]]:
    low, high = _common_ranges(species)
    for kind in species.kinds:
        rows = [
            f"{column} = {_range(column, kind.low[index], kind.high[index])}"
            for index, column in enumerate(COLUMNS)
            if kind.low[index] != low[index] or kind.high[index] != high[index]
        ]
        if len(species.kinds) == 1 and not rows and not kind.means:
            return
        means = [f"means = {_text(kind.means)}"] if kind.means else []
        head = ["[[kinds]]", f"weight = {float(kind.weight)!r}", *means]
        yield [*head, *(["[kinds.ranges]", *rows] if rows else [])]


def _range(column: str, low: float, high: float) -> str:
    return f"[{_number(column, low)}, {_number(column, high)}]"


def _number(column: str, value: float) -> str:
    return str(int(value)) if IS_INTEGER[COLUMN[column]] else repr(float(value))


def _text(text: str) -> str:
    # The escapes of JSON are those of TOML, which in addition has no bare DEL.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
