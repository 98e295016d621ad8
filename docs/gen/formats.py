"""Table of the versions of the files that grammarlab writes."""

from __future__ import annotations

from collections.abc import Mapping

from grammarlab.facade.file import VERSION as FACADE
from grammarlab.matching.scans.element_files import VERSION as ELEMENTS
from grammarlab.pages.record.store import STEPS
from grammarlab.runs.sample.derivations import FORMAT as DERIVATIONS
from grammarlab.runs.sample.manifest import FORMAT as MANIFEST
from grammarlab.synthesis.analysis.correction import VERSION as EXAMPLE

VERSIONS: Mapping[str, tuple[str, int]] = {
    "grammarlab.facade.file": ("Facade", FACADE),
    "grammarlab.synthesis.analysis.correction": ("Example of a building", EXAMPLE),
    "grammarlab.matching.scans.element_files": ("Elements of a scan", ELEMENTS),
    "grammarlab.runs.sample.derivations": ("Derivations", DERIVATIONS),
    "grammarlab.runs.sample.manifest": ("Manifest of a run", MANIFEST),
    "grammarlab.pages.record.store": ("Scoring session", len(STEPS)),
}
"""Name and version of each file format with a version, by the module that writes it."""


def table() -> str:
    """A table of the versions, with links to the sections of the page."""
    rows = [f"| [{name}](#{_anchor(name)}) | {version} |" for name, version in VERSIONS.values()]
    return "\n".join(["| file | version |", "|---|---|", *rows])


def _anchor(name: str) -> str:
    return name.lower().replace(" ", "-")
