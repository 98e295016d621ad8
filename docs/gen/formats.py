"""Table of the versions of the files that grammarlab writes."""

from __future__ import annotations

from collections.abc import Mapping

from grammarlab.facade.examples.analysis.correction import VERSION as EXAMPLE
from grammarlab.facade.file import VERSION as FACADE
from grammarlab.facade.templates.reading.document import VERSION as ELEMENTS
from grammarlab.runs.disk.derivations import FORMAT as DERIVATIONS
from grammarlab.runs.sampling.manifest import FORMAT as MANIFEST
from grammarlab.scoring.record.store import STEPS

VERSIONS: Mapping[str, tuple[str, int]] = {
    "grammarlab.facade.file": ("Facade", FACADE),
    "grammarlab.facade.examples.analysis.correction": ("Example of a building", EXAMPLE),
    "grammarlab.facade.templates.reading.document": ("Elements of a scan", ELEMENTS),
    "grammarlab.runs.disk.derivations": ("Derivations", DERIVATIONS),
    "grammarlab.runs.sampling.manifest": ("Manifest of a run", MANIFEST),
    "grammarlab.scoring.record.store": ("Scoring session", len(STEPS)),
}
"""Name and version of each file format with a version, by the module that writes it."""


def table() -> str:
    """A table of the versions, with links to the sections of the page."""
    rows = [f"| [{name}](#{_anchor(name)}) | {version} |" for name, version in VERSIONS.values()]
    return "\n".join(["| file | version |", "|---|---|", *rows])


def _anchor(name: str) -> str:
    return name.lower().replace(" ", "-")
