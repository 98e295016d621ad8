"""What kind of file somebody gave: commands on facades say which kind they take instead."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from grammarlab.errors import FacadeError, GrammarlabError, UsageError

FACADE, DESIGN, RULES, ELEMENTS, MESH, BOXES = "facade", "design", "rules", "elements", "mesh", "boxes"

_WORDS = {
    FACADE: "the file of a facade (.json, as `grammarlab facade read` writes it)",
    DESIGN: "a design of layers (.toml)",
    RULES: "a rule file (.cga)",
    ELEMENTS: "a scan, or a file of elements (.json, .npz)",
    MESH: "a mesh (.obj, .ply, .glb)",
    BOXES: "labelled boxes (.xml, .json, .csv) or CityGML (.gml, .xml)",
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
    **dict.fromkeys((".xml", ".gml", ".csv"), BOXES),
}
_HEAD = 64 * 1024
"""Bytes within which a JSON file says what it is."""


@contextmanager
def wanted(file: Path, *kinds: str) -> Iterator[None]:
    """Errors in here say which kinds of files are expected, where the file is of another kind.

    Args:
        file: what was given.
        kinds: of files that are expected.

    Raises:
        UsageError: in place of another one, when the file is of another kind.
        FacadeError: in place of any other error, when the file is of another kind.
    """
    try:
        yield
    except GrammarlabError as error:
        found = kind_of(file)
        if not found or found in kinds:
            raise
        expected = " or ".join(_WORDS[kind] for kind in kinds)
        commands = ", ".join(f"`grammarlab facade {each}`" for each in _COMMANDS[found])
        message = f"{file.name} is {_WORDS[found]}; expected {expected}. Commands for it: {commands}."
        raise (UsageError if isinstance(error, UsageError) else FacadeError)(message) from error


def kind_of(file: Path) -> str:
    """The kind of a file by its ending, and of JSON by its first bytes; empty for what is not known."""
    ending = file.suffix.lower()
    if ending != ".json":
        return _BY_ENDING.get(ending, "")
    with file.open("rb") as opened:
        head = opened.read(_HEAD)
    if found := re.search(rb'"format"\s*:\s*"grammarlab (facade|elements)"', head):
        return found[1].decode()
    return BOXES if re.search(rb'"(annotations|shapes)"\s*:', head) else ""
