"""Versions of the files that grammarlab writes, as a table."""

from __future__ import annotations

from collections.abc import Mapping

from grammarlab.facade import file as facade_file
from grammarlab.facade.examples.analysis import correction
from grammarlab.facade.templates.reading import document
from grammarlab.runs import derivations, manifest
from grammarlab.runs.scoring import store

VERSIONS: Mapping[str, tuple[str, int]] = {
    facade_file.__name__: ("Facade", facade_file.VERSION),
    correction.__name__: ("Example of a building", correction.VERSION),
    document.__name__: ("Elements of a scan", document.VERSION),
    derivations.__name__: ("Derivations", derivations.FORMAT),
    manifest.__name__: ("Manifest of a run", manifest.FORMAT),
    store.__name__: ("Scoring session", len(store.STEPS)),
}
"""Name and version of each file that carries one, by the module that writes it."""


def table() -> str:
    """A table of the versions, with links to the sections of the page."""
    rows = [f"| [{name}](#{_anchor(name)}) | {version} |" for name, version in VERSIONS.values()]
    return "\n".join(["| file | version |", "|---|---|", *rows])


def _anchor(name: str) -> str:
    return name.lower().replace(" ", "-")
