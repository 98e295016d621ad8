"""Worker of the page of a city: builds parcels again, and learns the grammars of zones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from grammarlab.pages.workers.worker_pool import Handler, Report
from grammarlab.preference.labels import Labels

Rebuild = Callable[[Path, Sequence[str]], Sequence[str]]
"""Builds parcels of a city again, by its folder and their ids; returns the addresses of the tiles that changed."""


@dataclass(frozen=True, slots=True)
class BuildAgain:
    """Task: build parcels again after their pins or their zones have changed."""

    folder: Path
    """Folder of the city."""
    parcels: tuple[str, ...]
    """Ids."""


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

    def do(task: BuildAgain | LearnZone, report: Report) -> list[str] | LearnedZone:
        if isinstance(task, LearnZone):
            return _learn(task, report)
        report("building", 0, len(task.parcels))
        function: Rebuild = getattr(import_module(module), name)
        return list(function(task.folder, task.parcels))

    return do


def _learn(task: LearnZone, report: Report) -> LearnedZone:
    # It loads JAX, which building does not need.
    from grammarlab.runs.learn.from_labels import learn_from_labels  # noqa: PLC0415

    report("learning", 0, 1)
    result = learn_from_labels(task.grammar, task.labels, task.file, labels_from=task.session, seed=task.seed)
    relevant = ", ".join(entry.name for entry in result.relevances[:2])
    about = f": {relevant}" if relevant else ""
    return LearnedZone(f"learned from {result.num_labels} scores{about}")
