"""Table of the files that grammarlab writes, with their versions."""

from __future__ import annotations

from collections.abc import Mapping

from grammarlab.city.tree_file import VERSION as TREES
from grammarlab.city.zone_file import VERSION as ZONES
from grammarlab.facade.file import VERSION as FACADE
from grammarlab.matching.scans.element_files import VERSION as ELEMENTS
from grammarlab.pages.record.store import STEPS
from grammarlab.runs.city.parcel_table import FORMAT as PARCELS
from grammarlab.runs.sample.derivations import FORMAT as DERIVATIONS
from grammarlab.runs.sample.manifest import FORMAT as MANIFEST
from grammarlab.runs.sample.model_rows import FORMAT as ROWS
from grammarlab.synthesis.analysis.correction import VERSION as EXAMPLE

VERSIONS: Mapping[str, tuple[str, int]] = {
    "grammarlab.facade.file": ("Facade", FACADE),
    "grammarlab.synthesis.analysis.correction": ("Example of a building", EXAMPLE),
    "grammarlab.matching.scans.element_files": ("Elements of a scan", ELEMENTS),
    "grammarlab.runs.sample.derivations": ("Derivations", DERIVATIONS),
    "grammarlab.runs.sample.manifest": ("Manifest of a run", MANIFEST),
    "grammarlab.runs.sample.model_rows": ("Rows of models", ROWS),
    "grammarlab.pages.record.store": ("Scoring session", len(STEPS)),
    "grammarlab.city.zone_file": ("Learned zones", ZONES),
    "grammarlab.city.tree_file": ("Learned species", TREES),
    "grammarlab.runs.city.parcel_table": ("Table of parcels", PARCELS),
}
"""Name and version of each file format with a version, by the module that writes it."""

FILES: Mapping[str, tuple[str, str]] = {
    "Rule file": ("`.cga`", "grammars/file.md#rule-file"),
    "Model files": ("`.glb`, `.usd`, `.usdz`, `.obj`, `.ply`, `.stl`, `.3mf`", "grammars/file.md#model-files"),
    "Manifest of a run": ("`manifest.json`", "grammars/file.md#manifest-of-a-run"),
    "Derivations": ("`derivations/`, Parquet", "grammars/file.md#derivations"),
    "Rows of models": ("`run.json`, `shards/`, `index.parquet`", "grammars/clusters.md#tables"),
    "Species of trees": ("`.toml`", "trees/file.md#species"),
    "Trees of a run": ("`derivations/`, Parquet", "trees/file.md#trees-of-a-run"),
    "Learned rule file": ("`.cga`", "learning/file.md#acceptance-rule"),
    "Label table": ("`.csv`, `.jsonl`, `.parquet`", "learning/file.md#label-table"),
    "Scoring session": ("`.db`, SQLite", "scoring/file.md#scoring-session"),
    "Scenario": ("`.toml`", "evaluation/file.md"),
    "Results of an evaluation": (
        "`results.parquet` and others",
        "evaluation/file.md#results-of-an-evaluation",
    ),
    "Plan of a city": ("`.toml`", "cities/file.md#the-plan"),
    "Learned zones": ("`.zones.json`", "cities/file.md#learned-zones"),
    "Learned species": ("`.trees.json`", "cities/file.md#learned-species"),
    "Table of parcels": ("`parcels.parquet`", "cities/file.md#parcelsparquet"),
    "Facade": ("`.facade.json`", "facades/file.md"),
    "Design of layers": ("`.toml`", "layers/file.md"),
    "Example of a building": ("`example.json`", "synthesis/file.md#example-of-a-building"),
    "Elements of a scan": ("`.json`, `.npz`", "matching/file.md#elements"),
    "Templates": ("`.template`", "matching/file.md#templates"),
}
"""Suffix of each file, and the part of the documentation that describes it."""


def table() -> str:
    """A table of all files that grammarlab reads and writes, with their versions."""
    versions = dict(VERSIONS.values())
    rows = [f"| [{name}]({place}) | {suffix} | {versions.get(name, '')} |" for name, (suffix, place) in FILES.items()]
    return "\n".join(["| file | suffix | version |", "|---|---|---|", *rows])
