"""The methods that are compared, by name, and how to write one down in a file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, get_args

from grammarlab.errors import UsageError
from grammarlab.evaluation.names import chosen
from grammarlab.learning.settings import FAMILIES, MAX_PATH_LENGTH, FeatureOptions, Settings
from grammarlab.preference.fitting import Method as Fit
from grammarlab.preference.questions.queries import Way

FITS: tuple[Fit, ...] = get_args(Fit)
"""What `grammarlab.preference.fit` offers."""
QUERIES: tuple[Way, ...] = tuple(way for way in get_args(Way) if way != "already ranked")
"""Ways to choose the models of a round (`grammarlab.preference.questions.queries`), but those for people who look
at their own scores again."""
OPTIONS = {"paper": ("noise", "penalty")}
"""Parameters of fits that may be set, by the name of the fit."""
PAPER_FAMILIES = ("paths", "symbols", "draws")
"""The features that the paper begins with (sections 4.5.1 and 4.7), random parameters among them."""
MAX_BATCH = 1024


@dataclass(frozen=True, slots=True)
class Method:
    """One way to learn a preference."""

    name: str
    """What tables and pictures call it."""
    fit: Fit = "blended"
    """One of `FITS`."""
    query: Way = "default"
    """One of `QUERIES`."""
    batch: int = 8
    """Models a round, 1 to `MAX_BATCH`: the fewer, the more each of them is chosen with what the others told."""
    path_length: int = 0
    """Edges of the longest paths to begin with, 1 to `MAX_PATH_LENGTH`; 0 for what the scenario says."""
    grows: bool = True
    """Whether longer paths are taken in when models with equal rows got different scores."""
    factored: bool = True
    """Whether each factor of a scenario has labels of its own; otherwise the person scores the product."""
    families: tuple[str, ...] = FAMILIES
    """Kinds of features that the method looks at; where it is all there are, the default's own, and for baselines those
    that the scenario offers."""
    options: tuple[tuple[str, float], ...] = ()
    """Parameters of the fit by name: those of `OPTIONS`."""

    def as_json(self) -> dict[str, Any]:
        """Everything that decides a curve, without the name."""
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
        """How the method learns.

        Args:
            offered: the features that a scenario offers to baselines; the default learns alike from everybody.
        """
        own = Settings().features if self.fit == "blended" else offered
        families = own.families if self.families == FAMILIES else self.families
        return Settings(
            features=FeatureOptions(self.path_length or own.path_length, families),
            fit=self.fit,
            options=self.options,
            query=self.query,
            grows=self.grows,
            widens=self.query == "default",
            # The default is a function of the scores alone; the paper's process goes on from where it was.
            warm=self.fit in ("paper", "kde", "sklearn", "lightgbm"),
        )


# The baselines follow the paper: two 4x4 grids a round, one of the current density, one of its complement.
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
    """The methods of a comma-separated list.

    Args:
        names: ``default,paper``; each name once.
        batch: models a round, instead of each method's own.

    Raises:
        UsageError: an unknown or repeated name, or none; a batch out of range.
    """
    batches = {} if batch is None else {"batch": batch}
    return tuple(checked(replace(method, **batches)) for method in chosen(names, METHODS, "method"))


def checked(method: Method, where: str = "") -> Method:
    """The method itself, once it is sure that everything in it is in range.

    Args:
        method: what somebody asked for.
        where: the place where it is written down, for the message.

    Raises:
        UsageError: says what is out of range and what is possible.
    """
    place = f"{where}: " if where else ""
    for what, value, known in (("fit", method.fit, FITS), ("query", method.query, QUERIES)):
        if value not in known:
            raise UsageError(f"{place}no {what} is called {value!r}. There are: {', '.join(known)}.")
    for family in method.families:
        if family not in FAMILIES:
            raise UsageError(f"{place}no family of features is called {family!r}. There are: {', '.join(FAMILIES)}.")
    ranges = (("batch", method.batch, 1, MAX_BATCH), ("path_length", method.path_length, 0, MAX_PATH_LENGTH))
    for what, number, least, most in ranges:
        if not least <= number <= most:
            raise UsageError(f"{place}{what} is a number from {least} to {most}, not {number}.")
    known = OPTIONS.get(method.fit, ())
    for name, _ in method.options:
        if name not in known:
            raise UsageError(
                f"{place}fit {method.fit} has no option {name!r}. There are: {', '.join(known) or 'none'}."
            )
    return method
