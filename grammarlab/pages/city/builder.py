"""Worker of the page of a city: builds parcels again, and learns the grammars of zones."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from grammarlab.files import read_bounded
from grammarlab.pages.workers.worker_pool import Handler, Report
from grammarlab.preference.labels import Labels

Rebuild = Callable[[Path, Path], object]
"""Builds the city of a plan again in its folder; what has not changed costs little."""
_MAX_TILESET_BYTES = 64 << 20


@dataclass(frozen=True, slots=True)
class BuildAgain:
    """Task: build a city again after its pins or its plan have changed."""

    plan: Path
    folder: Path


@dataclass(frozen=True, slots=True)
class LearnZone:
    """Task: learn the grammar of a zone from scores: `LearnedZone`."""

    zone: str
    grammar: str
    """Name or path of its grammar."""
    labels: Labels
    session: str
    """Name of the session file."""
    file: Path
    """The new grammar."""
    seed: int
    """Seed of the pool of models."""


@dataclass(frozen=True, slots=True)
class TellRules:
    """Task: how the building of a parcel was derived: a list of lines."""

    plan: Path
    parcel: str


@dataclass(frozen=True, slots=True)
class LearnedZone:
    """Result of learning."""

    words: str
    """One sentence about what was learned."""


def builder(rebuild: str) -> Handler:
    """Function of the tasks.

    Args:
        rebuild: ``package.module:function`` of the kind `Rebuild`.
    """
    module, _, name = rebuild.partition(":")

    def do(task: BuildAgain | LearnZone | TellRules, report: Report) -> LearnedZone | list[str] | bool:
        if isinstance(task, LearnZone):
            return _learn(task, report)
        if isinstance(task, TellRules):
            # It needs the extra `city`, which seeing does not.
            from grammarlab.pages.city.rule_words import rules_of  # noqa: PLC0415

            return rules_of(task.plan, task.parcel)
        function: Rebuild = getattr(import_module(module), name)
        function(task.plan, task.folder)
        return True

    return do


def build_again(plan: Path, folder: Path) -> None:
    """Build a city again with the same outputs: squares whose parcels have changed cost work, all others are kept.

    Raises:
        GrammarlabError: If the plan or the folder cannot be used.
    """
    # Building needs the extra `city`, which seeing does not.
    from grammarlab.runs.city.build import BUILDINGS, build_city  # noqa: PLC0415

    root = json.loads(read_bounded(folder / "tileset.json", _MAX_TILESET_BYTES))["root"]
    build_city(plan, folder, cityjson=(folder / BUILDINGS).exists(), implicit="implicitTiling" in root)


def _learn(task: LearnZone, report: Report) -> LearnedZone:
    # It loads JAX, which building does not need.
    from grammarlab.runs.learn.from_labels import learn_from_labels  # noqa: PLC0415

    report("learning", 0, 1)
    result = learn_from_labels(task.grammar, task.labels, task.file, labels_from=task.session, seed=task.seed)
    relevant = ", ".join(entry.name for entry in result.relevances[:2])
    about = f": {relevant}" if relevant else ""
    return LearnedZone(f"learned from {result.num_labels} scores{about}")
