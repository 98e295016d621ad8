"""Worker of the page of a city: builds parcels again, and learns the grammars of zones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from grammarlab.errors import GrammarlabError
from grammarlab.pages.city.site_labels import SiteLabels
from grammarlab.pages.workers.worker_pool import Handler, Report

Rebuild = Callable[[Path, Sequence[str]], Sequence[str]]
"""Builds parcels of a city again by its folder and their ids; returns the addresses of the changed tiles."""


@dataclass(frozen=True, slots=True)
class BuildAgain:
    """Task: build parcels again after their pins or their plan have changed; the addresses of changed tiles."""

    folder: Path
    """Folder of the city."""
    parcels: tuple[str, ...]
    """Ids of the parcels."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LearnZone:
    """Task: learn the grammar of a zone from scores: `LearnedZone`."""

    zone: str
    grammar: str
    """Name or path of its grammar."""
    labels: SiteLabels
    plan: Path
    """Plan of the city."""
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

    def do(task: BuildAgain | LearnZone | TellRules, report: Report) -> LearnedZone | list[str]:
        if isinstance(task, LearnZone):
            return _learn(task, report)
        if isinstance(task, TellRules):
            # It needs the extra `city`, which seeing does not.
            from grammarlab.pages.city.rule_words import rules_of  # noqa: PLC0415

            return rules_of(task.plan, task.parcel)
        function: Rebuild = getattr(import_module(module), name)
        return list(function(task.folder, task.parcels))

    return do


def _learn(task: LearnZone, report: Report) -> LearnedZone:
    # It loads JAX, which building does not need.
    # It needs the extra `city`, which seeing does not.
    from grammarlab.pages.city.site_values import with_site_values  # noqa: PLC0415
    from grammarlab.runs.learn.from_labels import learn_from_labels  # noqa: PLC0415

    report("learning", 0, 1)
    missing = ""
    try:
        labels = with_site_values(task.labels, task.plan)
    except GrammarlabError as error:  # a map that has moved: outlines and scores are enough to learn something
        labels, missing = task.labels.labels, f" (without the attributes of parcels: {error})"
    result = learn_from_labels(task.grammar, labels, task.file, labels_from=task.session, seed=task.seed)
    relevant = ", ".join(entry.name for entry in result.relevances[:2])
    about = f": {relevant}" if relevant else ""
    return LearnedZone(f"learned from {result.num_labels} scores{about}{missing}")
