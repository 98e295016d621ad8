"""Kinds of files given to commands on facades, and options for the unit and the up axis of meshes and scans.

Errors name the kind of the file and the commands for it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from grammarlab.errors import AssetError, FacadeError, GrammarlabError, UsageError
from grammarlab.files import open_regular

FACADE, DESIGN, RULES, ELEMENTS, MESH, BOXES = "facade", "design", "rules", "elements", "mesh", "boxes"
_WORDS = {
    FACADE: "the file of a facade (.json, as `grammarlab facade read` writes it)",
    DESIGN: "a design of layers (.toml)",
    RULES: "a rule file (.cga)",
    ELEMENTS: "a scan, or a file of elements (.json, .npz)",
    MESH: "a mesh (.obj, .ply, .glb)",
    BOXES: "labelled boxes (.xml, .json, .csv, .tsv, .txt) or CityGML (.gml, .xml)",
}
_COMMANDS = {
    FACADE: ("edit", "grammar", "infer", "show", "open"),
    DESIGN: ("layers", "open"),
    RULES: ("read --face front",),
    ELEMENTS: ("match", "open"),
    MESH: ("synthesize", "match", "open"),
    BOXES: ("read",),
}
_BY_ENDING = {
    ".toml": DESIGN,
    ".cga": RULES,
    **dict.fromkeys((".npz", ".las", ".laz"), ELEMENTS),
    **dict.fromkeys((".obj", ".ply", ".glb", ".gltf", ".stl", ".off"), MESH),
    **dict.fromkeys((".xml", ".gml", ".csv", ".tsv", ".txt"), BOXES),
}
_HEAD_BYTES = 64 * 1024
"""Number of bytes of a JSON file that determine its kind."""


class Up(StrEnum):
    """Up axis of a file."""

    auto = "auto"
    y = "y"
    z = "z"

    @property
    def axis(self) -> str:
        """The axis; empty if it is to be detected."""
        return "" if self is Up.auto else self.value


UpOption = Annotated[Up, typer.Option("--up", help="Up axis of the file.")]


class Unit(StrEnum):
    """Unit of length of a file."""

    m = "m"
    cm = "cm"
    mm = "mm"
    ft = "ft"


UnitOption = Annotated[Unit, typer.Option("--unit", help="Unit of the coordinates of the file.")]


@contextmanager
def expected_kind(file: Path, *kinds: str) -> Iterator[None]:
    """Replaces errors in its block by an error on the kind of the file, if it is of another kind.

    Args:
        file: the given file.
        kinds: expected kinds.

    Raises:
        UsageError: In place of a `UsageError`, if the file is of another kind.
        FacadeError: In place of any other error, if the file is of another kind.
    """
    try:
        yield
    except GrammarlabError as error:
        kind_of_file = kind_of(file)
        if not kind_of_file or kind_of_file in kinds:
            raise
        expected = " or ".join(_WORDS[kind] for kind in kinds)
        commands = ", ".join(f"`grammarlab facade {command}`" for command in _COMMANDS[kind_of_file])
        message = f"{file.name} is {_WORDS[kind_of_file]}; expected {expected}. Commands for it: {commands}."
        raise (UsageError if isinstance(error, UsageError) else FacadeError)(message) from error


def kind_of(file: Path) -> str:
    """The kind of a file by its suffix, and of JSON by its first bytes; empty for an unknown kind."""
    ending = file.suffix.lower()
    if ending != ".json":
        return _BY_ENDING.get(ending, "")
    try:
        with open_regular(file) as opened:
            head = opened.read(_HEAD_BYTES)
    except AssetError:  # a pipe or a device
        return ""
    if match := re.search(rb'"format"\s*:\s*"grammarlab (facade|elements)"', head):
        return match[1].decode()
    return BOXES if re.search(rb'"(annotations|shapes|regions)"\s*:', head) else ""
