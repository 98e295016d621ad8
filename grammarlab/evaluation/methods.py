"""Learning methods for comparison, by name, and their definitions in files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, get_args

from grammarlab.errors import UsageError
from grammarlab.evaluation.scenario_values import chosen
from grammarlab.learning.fitting import Method as Fit
from grammarlab.learning.settings import FAMILIES, MAX_PATH_LENGTH, FeatureOptions, Settings
from grammarlab.preference.queries import Way

FITS: tuple[Fit, ...] = get_args(Fit)
"""Methods of `grammarlab.learning.fitting.fit`."""
QUERIES: tuple[Way, ...] = tuple(way for way in get_args(Way) if way != "already ranked")
"""Query strategies (`grammarlab.preference.queries`), except for those that show scored models
again."""
OPTIONS = {"paper": ("noise", "penalty")}
"""Parameters of fits, by the name of the fit."""
PAPER_FAMILIES = ("paths", "symbols", "draws")
"""The initial features of the paper (sections 4.5.1 and 4.7), including random parameters."""
MAX_BATCH = 1024
"""Largest number of models per round."""


@dataclass(frozen=True, slots=True)
class Method:
    """A method of learning a preference."""

    name: str
    """Name in tables and pictures."""
    fit: Fit = "blended"
    """One of `FITS`."""
    query: Way = "default"
    """One of `QUERIES`."""
    batch: int = 8
    """Models per round, 1 to `MAX_BATCH`: with fewer, each choice uses more of the earlier answers."""
    path_length: int = 0
    """Initial number of edges of the longest paths, 1 to `MAX_PATH_LENGTH`; 0 for that of the scenario."""
    grows: bool = True
    """Whether longer paths are added if models with equal rows got different scores."""
    factored: bool = True
    """Whether each factor of a scenario has its own labels; otherwise the person scores the product."""
    families: tuple[str, ...] = FAMILIES
    """Kinds of features of the method; all kinds mean the default's own, and for baselines those
    of the scenario."""
    options: tuple[tuple[str, float], ...] = ()
    """Parameters of the fit by name, from `OPTIONS`."""

    def as_json(self) -> dict[str, Any]:
        """All settings that determine a curve, without the name."""
        return {
            "fit": self.fit,
            "query": self.query,
            "batch": self.batch,
            "path_length": self.path_length,
            "grows": self.grows,
            "factored": self.factored,
            "families": sorted(self.families),
            "options": dict(self.options),
        }

    def settings(self, offered: FeatureOptions) -> Settings:
        """Settings of learning.

        Args:
            offered: the features of a scenario for baselines; the default ignores them.
        """
        features = Settings().features if self.fit == "blended" else offered
        families = features.families if self.families == FAMILIES else self.families
        return Settings(
            features=FeatureOptions(self.path_length or features.path_length, families),
            fit=self.fit,
            options=self.options,
            query=self.query,
            grows=self.grows,
            widens=self.query == "default",
            # The default is a function of the scores only; the paper's process continues from its previous state.
            warm=self.fit in ("paper", "kde", "sklearn", "lightgbm"),
        )


# The baselines follow the paper: two 4x4 grids per round, one of the current density, one of its complement.
METHODS = {
    method.name: method
    for method in (
        Method(name="default"),
        Method(name="paper", fit="paper", query="density", batch=32, families=PAPER_FAMILIES),
        Method(name="kde", fit="kde", query="density", batch=32, families=PAPER_FAMILIES),
        Method(name="sklearn", fit="sklearn", query="density", batch=32, families=PAPER_FAMILIES),
        Method(name="lightgbm", fit="lightgbm", query="density", batch=32, families=PAPER_FAMILIES),
    )
}


def methods_of(names: str, batch: int | None = None) -> tuple[Method, ...]:
    """Methods from a comma-separated list.

    Args:
        names: ``default,paper``; each name once.
        batch: models per round, instead of each method's own.

    Raises:
        UsageError: If a name is unknown, repeated or missing, or the batch is out of range.
    """
    batches = {} if batch is None else {"batch": batch}
    return tuple(checked(replace(method, **batches)) for method in chosen(names, METHODS, "method"))


def checked(method: Method, where: str = "") -> Method:
    """The method, after checking its values.

    Args:
        method: the method.
        where: position of the method's definition, for messages.

    Raises:
        UsageError: If a value is out of range; it names the value and the range.
    """
    prefix = f"{where}: " if where else ""
    for what, value, allowed in (("fit", method.fit, FITS), ("query", method.query, QUERIES)):
        if value not in allowed:
            raise UsageError(f"{prefix}unknown {what} {value!r}. Expected one of {', '.join(allowed)}.")
    for family in method.families:
        if family not in FAMILIES:
            raise UsageError(f"{prefix}unknown family of features {family!r}. Expected one of {', '.join(FAMILIES)}.")
    ranges = (("batch", method.batch, 1, MAX_BATCH), ("path_length", method.path_length, 0, MAX_PATH_LENGTH))
    for what, number, least, most in ranges:
        if not least <= number <= most:
            raise UsageError(f"{prefix}{what} is a number from {least} to {most}, not {number}.")
    allowed = OPTIONS.get(method.fit, ())
    for name, _ in method.options:
        if name not in allowed:
            raise UsageError(
                f"{prefix}fit {method.fit} has no option {name!r}. There are: {', '.join(allowed) or 'none'}."
            )
    return method
