"""Analyses of example buildings, each made once in a process, however many tests need it."""

from __future__ import annotations

import pickle
from hashlib import sha256

from grammarlab.synthesis.analysis.example import Example, analyse
from grammarlab.synthesis.mesh.building_files import ExampleMesh

_EXAMPLES: dict[str, Example] = {}


def analysed_once(mesh: ExampleMesh, up: str = "") -> Example:
    """What `analyse` makes of a building."""
    key = sha256(pickle.dumps((mesh, up))).hexdigest()
    if key not in _EXAMPLES:
        _EXAMPLES[key] = analyse(mesh, up)
    return _EXAMPLES[key]
