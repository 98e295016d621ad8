"""Parameter files of Arbaro: XML with one ``<param name="1Curve" value="-40"/>`` per parameter.

Arbaro's parameters are those of Weber and Penn (SIGGRAPH 1995) and a few of its own. It has no ranges: each of its
values is the same for all trees, and so it is here; only spreads vary. What one side lacks is listed in words.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import PurePath
from xml.sax.saxutils import quoteattr

import numpy as np

from grammarlab.errors import Finding, LanguageError, Location, Severity, XmlError, shown
from grammarlab.trees.parameters import COLUMN, COLUMNS, DEFAULTS, IS_INTEGER, NUM_LEVELS, SPREAD
from grammarlab.trees.species import Kind, Species
from grammarlab.trees.species_tables import MOST_FINDINGS, column_value
from grammarlab.xml_text import Node, xml_root

MAX_CHARACTERS = 1 << 20
"""Largest number of characters of a file."""
_MOST_ELEMENTS = 10_000
_MOST_LISTED = 40
"""Parameters without a counterpart that the description of a species lists."""
_LONGEST = 40
"""Characters of foreign names and values that it shows."""
_TYPO = 0.85
"""Similarity, 0 to 1, from which an unknown name is a misspelt one, and not one of another program."""
_OURS = ("z_scale", "wind_speed", "wind_direction", "blossom_rate", "blossom_shape", "blossom_scale")
"""Parameters that Arbaro lacks."""
_NUMBER = re.compile(r"[-+]?(?:[0-9]{1,30}\.?[0-9]{0,30}|\.[0-9]{1,30})(?:[eE][-+]?[0-9]{1,3})?")
_NOT_FINITE = {"nan": np.nan, "inf": np.inf, "infinity": np.inf, "-inf": -np.inf, "-infinity": -np.inf}
_LEAF_SHAPES = {"disc": "0", **{f"disc{triangles}": "0" for triangles in range(10)}, "palm": "2"}
"""Our numbers of Arbaro's leaf shapes: its disc is an oval of some number of triangles, its palm a folded ribbon."""


def _camel(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


def _label(column: str) -> str:
    """Arbaro's name of a column.

    >>> _label("curve_1_v"), _label("scale_0"), _label("base_splits"), _label("leaf_scale_x"), _label("scale_v")
    ('1CurveV', '0Scale', '0BaseSplits', 'LeafScaleX', 'ScaleV')
    """
    name = column.removesuffix(SPREAD)
    end = "V" if column.endswith(SPREAD) else ""
    if name == "base_splits":
        return "0BaseSplits"
    if name[-1].isdigit():
        return f"{name[-1]}{_camel(name[:-2])}{end}"
    return _camel(name) + end


LABELS = {_label(column): column for column in COLUMNS if column.removesuffix(SPREAD) not in _OURS}
"""Columns by Arbaro's names."""
_DEFAULTS = {
    "Shape": 0.0,
    "Scale": 10.0,
    "BaseSize": 0.25,
    "Ratio": 0.05,
    "RatioPower": 1.0,
    "LeafScaleX": 0.5,
    **{f"{level}Length": 0.5 for level in (1, 2, 3)},
    **{f"{level}DownAngle": 30.0 for level in (1, 2, 3)},
    **{f"{level}Rotate": 120.0 for level in (1, 2, 3)},
    **{f"{level}Branches": 10.0 if level == 1 else 5.0 for level in (1, 2, 3)},
    **{f"{level}CurveRes": 1.0 for level in (2, 3)},
}
"""Arbaro's defaults where they differ from ours."""
_THEIRS = {
    "Smooth": None,
    "LeafDistrib": 4.0,
    "0DownAngle": 0.0,
    "0DownAngleV": 0.0,
    "0Rotate": 0.0,
    "0RotateV": 0.0,
    "0Branches": 1.0,
    "0BranchDist": 0.0,
    **{f"{level}BranchDist": 1.0 for level in range(1, NUM_LEVELS)},
    "ZScale": 1.0,
    "ZScaleV": 0.0,
    "Seed": None,
    "Species": None,
}
"""Parameters of Arbaro without a counterpart, each with the value that says what this model does; None for those that
describe no tree."""


def read_arbaro(text: str, name: str) -> Species:
    """The species of a parameter file of Arbaro, the same values for all its trees.

    Its description, `Species.about`, lists the parameters of the file without a counterpart.

    Args:
        text: the whole file.
        name: its name, for messages; the species is called as it without folders and suffix.

    Raises:
        LanguageError: With a finding for every mistake.
    """
    reader = _Reader(text, name)
    species = reader.species()
    errors = tuple(finding for finding in reader.findings if finding.severity == "error")
    if species is None or errors:
        raise LanguageError(errors, text)
    return species


def check_arbaro(text: str, name: str) -> tuple[Finding, ...]:
    """Findings about a file: errors, and warnings about parameters without a counterpart."""
    reader = _Reader(text, name)
    reader.species()
    return tuple(reader.findings)


class _Reader:
    """A reader of one file."""

    def __init__(self, text: str, name: str) -> None:
        self.findings: list[Finding] = []
        self._text = text
        self._name = name
        self._values: dict[str, float] = {}
        self._ignored: dict[str, str] = {}

    def species(self) -> Species | None:
        """The species; None, with findings, if the file has none."""
        node = self._species_node()
        if node is None:
            return None
        for param, place in zip(node.iter("param"), self._places(), strict=False):
            if len(self.findings) >= MOST_FINDINGS:
                return self._report("too-many", f"reading ends after {MOST_FINDINGS} remarks", place)
            self._read(param, place)
        if not self._values and not self.findings:
            self._report("missing", "expected parameters such as <param name='Levels' value='3'/>, found none")
        typical = DEFAULTS.copy()
        for label, value in {**self._defaults(), **self._values}.items():
            typical[COLUMN[LABELS[label]]] = value
        return Species(
            name=PurePath(self._name).stem,
            kinds=(Kind(1.0, typical, typical),),
            typical=typical,
            about=self._about(node),
        )

    def _defaults(self) -> dict[str, float]:
        """Arbaro's defaults; without ours where they have no effect, so that a written file does not name them."""
        levels = self._values.get("Levels", float(DEFAULTS[COLUMN["levels"]]))
        has_leaves = bool(self._values.get("Leaves"))
        has_effect = {
            # Leaves take their angles from the level after the last.
            label: int(label[0]) < levels + (has_leaves and label[1:] in ("DownAngle", "Rotate"))
            if label[0].isdigit()
            else has_leaves or label != "LeafScaleX"
            for label in _DEFAULTS
        }
        return {label: value for label, value in _DEFAULTS.items() if has_effect[label]}

    def _species_node(self) -> Node | None:
        if len(self._text) > MAX_CHARACTERS:
            message = f"expected a file of at most {MAX_CHARACTERS:,} characters, found {len(self._text):,}"
            return self._report("too-large", message)
        try:
            root = xml_root(self._text, most_elements=_MOST_ELEMENTS)
        except XmlError as error:
            return self._report("syntax", error.message, Location(error.line or 1, error.column or 1, 1, self._name))
        species = root.findall("species")
        if root.tag != "arbaro" or len(species) != 1:
            content = f"<{root.tag}> with {len(species)} species" if root.tag == "arbaro" else f"<{root.tag:.40}>"
            return self._report("wrong-type", f"expected <arbaro> with one <species>, found {content}")
        return species[0]

    def _places(self) -> Iterator[Location]:
        """Places of the elements ``<param``, in the order of the file."""
        text = _without_comments(self._text)
        line, start = 1, 0
        for match in re.finditer(r"<param(?=[\s/>])[^<>]{0,200}", text):
            line += text.count("\n", start, match.start())
            start = match.start()
            yield Location(line, start - text.rfind("\n", 0, start), len(match[0].split("\n")[0]) + 1, self._name)
        while True:  # in a form of writing that the pattern misses
            yield Location(file=self._name)

    def _read(self, param: Node, place: Location) -> None:
        label, text = param.get("name", ""), param.get("value")
        if text is None:
            message = f"expected a value of {shown(label)}"
            self._report("missing", message, place, "such as <param name='Levels' value='3'/>")
        elif label in self._values or label in self._ignored:
            self._report("repeated", f"{label} has a value already", place, "delete one of them")
        elif label in LABELS:
            self._read_value(label, text.strip(), place)
        elif label in _THEIRS:
            self._ignored[label] = text
            if _THEIRS[label] is None or _number(text) != _THEIRS[label]:
                self._ignore(label, text, place)
        elif near := get_close_matches(label[:_LONGEST], (*LABELS, *_THEIRS), n=3, cutoff=_TYPO):
            message = f"Arbaro has no parameter {shown(label)}"
            self._report("unknown-name", message, place, f"did you mean {' or '.join(near)}?")
        else:  # of another version, or another program
            self._ignored[label] = text
            self._ignore(label, text, place)

    def _ignore(self, label: str, text: str, place: Location) -> None:
        message = f"{shown(label)[1:-1]} = {shown(text)} has no counterpart in this model, and is left out"
        self._report("no-counterpart", message, place, severity="warning")

    def _read_value(self, label: str, text: str, place: Location) -> None:
        column = LABELS[label]
        if label == "LeafShape" and _number(text) is None:
            # A name that Arbaro does not know either is drawn as a disc by it.
            shape = _LEAF_SHAPES.get(text.lower())
            if shape is None:
                self._report("no-counterpart", f"LeafShape = {shown(text)} becomes a disc", place, severity="warning")
            text = shape or "0"
        number = _number(text)
        value, fault = column_value(column, text if number is None else number, label)
        if fault:
            self._report(fault.code, fault.message, place, fault.hint)
        self._values[label] = DEFAULTS[COLUMN[column]] if value is None else value

    def _about(self, node: Node) -> str:
        others = [
            f"{label[:_LONGEST]} = {text[:_LONGEST]}"
            for label, text in self._ignored.items()
            if label not in _THEIRS or _THEIRS[label] is None or _THEIRS[label] != _number(text)
        ]
        end = f"; without counterpart here: {', '.join(others[:_MOST_LISTED])}" if others else ""
        return f"{shown(node.get('name', ''))} of an Arbaro file{end}."

    def _report(
        self, code: str, message: str, place: Location | None = None, hint: str = "", severity: Severity = "error"
    ) -> None:
        self.findings.append(Finding(severity, code, message, place or Location(file=self._name), hint))


def _without_comments(text: str) -> str:
    """A text with blanks in place of its comments."""
    parts, end = [], 0
    # Not a regular expression: for a text with many starts and no end of a comment, its time would be quadratic.
    while (start := text.find("<!--", end)) >= 0 and (stop := text.find("-->", start)) >= 0:
        parts += [text[end:start], re.sub(r"[^\n]", " ", text[start:stop])]
        end = stop
    return "".join([*parts, text[end:]])


def _number(text: str) -> float | None:
    """A number, finite or not; None for other texts."""
    text = text.strip()
    if _NUMBER.fullmatch(text):
        return float(text)
    return _NOT_FINITE.get(text.lower())


def write_arbaro(species: Species) -> str:
    """The file for Arbaro with the typical values of a species.

    A comment lists what Arbaro has no parameter for: ranges, and a few parameters.
    """
    values = dict(zip(COLUMNS, species.typical.tolist(), strict=True))
    lines = ["<?xml version='1.0' ?>", "<arbaro>", f"  <species name={quoteattr(species.name)}>"]
    lines += [f"    <!-- without counterpart in Arbaro: {text} -->" for text in _losses(species, values)]
    for label, column in LABELS.items():
        number = str(int(values[column])) if IS_INTEGER[COLUMN[column]] else repr(values[column])
        lines.append(f'    <param name="{label}" value="{number}"/>')
    return "\n".join([*lines, "  </species>", "</arbaro>", ""])


def _losses(species: Species, values: Mapping[str, float]) -> Iterator[str]:
    """What a file for Arbaro lacks."""
    if len(species.kinds) > 1:
        yield f"{len(species.kinds)} kinds"
    low, high = (np.stack([getattr(kind, end) for kind in species.kinds]) for end in ("low", "high"))
    for column, start, stop in zip(COLUMNS, low.min(axis=0), high.max(axis=0), strict=True):
        if start != stop:
            yield f"{column} from {start:g} to {stop:g}"
    for column in COLUMNS:
        if column.removesuffix(SPREAD) in _OURS and values[column] != DEFAULTS[COLUMN[column]]:
            yield f"{column} = {values[column]:g}"
    if species.acceptance:
        yield "an acceptance rule"
