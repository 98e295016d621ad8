"""Scenarios: a design space, an exact preference over its designs, and the target of learning it.

A scenario is a TOML file; docs/evaluation/file.md describes it. Those in ``scenarios/`` are the paper's (Table 4.2) and
its limits (section 4.8.1).
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias, cast

from grammarlab.errors import UsageError
from grammarlab.evaluation.scenario_values import SUFFIX, TomlFile, nearest, read
from grammarlab.features.expression import RESERVED, Expression
from grammarlab.features.model_score import Score, ScoreCase
from grammarlab.language.presets import NO_CHOICES, RuleChoices
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.settings import FAMILIES, MAX_PATH_LENGTH, FeatureOptions

DEFAULT_FEATURES = FeatureOptions()
DEFAULT_MODELS = 5000
"""Size of the labelled set, as in the paper."""
MAX_DEFINITIONS = 200
"""Largest number of definitions of a scenario."""
MAX_MODELS = 1_000_000
"""Largest size of the labelled set."""
MAX_FACTORS = 8
"""Largest number of factors."""
MAX_DIVERGENCE = 0.7
"""Largest divergence in nats: ln 2."""

Base: TypeAlias = Literal["grammar", "uniform"]
Draws: TypeAlias = Literal["grammar", "flattened"]
Since: TypeAlias = Literal["start", "first liked"]


@dataclass(frozen=True, slots=True)
class Factor:
    """A named preference with its own labels."""

    name: str
    title: str
    """Description of the liked models."""
    score: Score


@dataclass(frozen=True, slots=True)
class PaperFigures:
    """Results of the paper; None where it has none. Divergences are in nats (Table 4.3)."""

    original: float | None = None
    """Divergence of the original grammar."""
    p_learning: float | None = None
    """Divergence after parameter learning."""
    s_learning: float | None = None
    """Divergence after structure learning."""
    labels: int | None = None
    """Scores until 0.01."""
    kde_labels: int | None = None
    """Scores until 0.01 for the density estimation that the paper compares with."""
    figure: str = ""
    """Number of the paper's figure of the scenario, such as ``4.11b``."""


@dataclass(frozen=True, slots=True)
class ScenarioGoal:
    """Target of learning."""

    js: float = 0.01
    """Jensen-Shannon divergence in nats."""
    labels: int | None = None
    """Largest number of scores to reach it; None without a target."""
    aim: int | None = None
    """A better number of scores."""
    since: Since = "start"
    """Start of counting these scores: the first score, or the round that shows the first liked model
    (`Curve.since_first_liked`)."""
    ask: int | None = None
    """Total number of scores to ask for, so that the target can be reached; None for that of the target."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """A preference of a simulated person over the models of a grammar, and the target of learning it."""

    name: str
    title: str
    """Description of the liked models."""
    grammar: str
    """Name of a shipped grammar or species, or the path of its file."""
    factors: tuple[Factor, ...]
    """At least one; the preference is their product."""
    choices: RuleChoices = NO_CHOICES
    """Style, start rule, values of attributes and library of a rule file."""
    library: str = ""
    """Path of the library of `choices` as the file has it, relative to the folder of the file; empty for none."""
    num_models: int = DEFAULT_MODELS
    """Size of the labelled set on which densities are compared."""
    seed: int = 0
    """Seed of the labelled set, 0 <= seed < 2**64."""
    base: Base = "grammar"
    """Density that the preference multiplies: the grammar's own, or the same for every model."""
    draws: Draws = "grammar"
    """Density of the labelled set: the grammar, or, for models too rare in its samples, the grammar with all
    alternatives of a choice equally likely and importance weights."""
    features: FeatureOptions = DEFAULT_FEATURES
    methods: tuple[str, ...] = ("default",)
    """Names of learning methods to compare."""
    paper: PaperFigures = PaperFigures()
    target: ScenarioGoal = ScenarioGoal()

    @property
    def score(self) -> Score:
        """The whole preference as a score from 0 to 100; several factors are multiplied."""
        return Score.product([factor.score for factor in self.factors])

    @property
    def hash(self) -> str:
        """SHA-256, in hexadecimal, of the preference and its models; the grammar is included by name only."""
        steps = [(factor.name, factor.score.expression.steps) for factor in self.factors]
        values = (self.name, self.grammar, steps, self.num_models, self.seed, self.base, self.draws, self.features)
        # Scenarios without choices keep the hash that they had before there were choices.
        chosen = self.choices
        named = (self.library, chosen.style, chosen.start_rule, tuple(chosen.attributes.items()))
        choices = () if chosen == NO_CHOICES else (named,)
        return hashlib.sha256(repr(values + choices).encode()).hexdigest()

    def check(self, space: AbstractDesignSpace[Any]) -> None:
        """Check that designs have all features of the preference.

        Args:
            space: the designs, such as the models of the grammar.

        Raises:
            UsageError: If the space lacks something; it names this and the nearest existing name.
        """
        try:
            space.check(feature for factor in self.factors for feature in factor.score.features)
        except UsageError as error:
            raise UsageError(f"scenario {self.name} does not fit {self.grammar}:\n{error}") from None


def load(path: Path) -> Scenario:
    """Read a scenario file, and the scenario files of its factors.

    Raises:
        UsageError: If a file cannot be read or is not a scenario; it names the expected text and the line.
    """
    return parse(read(path, "scenario"), path)


def parse(text: str, path: Path = Path("<text>")) -> Scenario:
    """Parse the text of a scenario file.

    Args:
        text: the whole file.
        path: path of the file; paths of grammars and factors are relative to it.

    Raises:
        UsageError: If the text is not a scenario.
    """
    file = TomlFile(text, path)
    table = file.table()
    file.check_keys(table, _KEYS)
    name, title = file.string(table, "name"), file.string(table, "title")
    if not re.fullmatch(_NAME, name):
        raise file.wrong(f"expected a name of letters, digits, _ and -, found {name!r:.80}", "name")
    return Scenario(
        name=name,
        title=title,
        grammar=_grammar(file, table),
        factors=_factors(file, table, name, title),
        choices=_choices(file, table),
        library=file.string(table, "library", ""),
        num_models=file.integer(table, "num_models", 1, MAX_MODELS) or DEFAULT_MODELS,
        seed=file.integer(table, "seed", 0, 2**64 - 1) or 0,
        base=cast(Base, file.one_of(table, "base", ("grammar", "uniform"))),
        draws=cast(Draws, file.one_of(table, "draws", ("grammar", "flattened"))),
        features=_features(file, table),
        methods=file.strings(table, "methods", ("default",)),
        paper=_paper(file, table),
        target=_target(file, table),
    )


_KEYS = (
    *(
        "name",
        "title",
        "grammar",
        "start",
        "style",
        "library",
        "attributes",
        "num_models",
        "seed",
        "base",
        "draws",
        "methods",
    ),
    *("definitions", "preference", "factors", "features", "paper", "target"),
)
_NAME = r"[\w-]{1,64}"


def _grammar(file: TomlFile, table: dict[str, Any]) -> str:
    grammar = file.string(table, "grammar")
    # A shipped name has no suffix; a file is beside the scenario, whatever kind of designs it describes.
    return str(file.path.parent / grammar) if Path(grammar).suffix else grammar


def _choices(file: TomlFile, table: dict[str, Any]) -> RuleChoices:
    attributes = table.get("attributes", {})
    if not isinstance(attributes, dict) or len(attributes) > MAX_DEFINITIONS:
        raise file.wrong(f"expected a table [attributes] of at most {MAX_DEFINITIONS} lines", "attributes")
    for name, value in attributes.items():
        if not isinstance(value, int | float | str):
            raise file.wrong(f"attribute {name!r:.60}: expected a number, true, false or a text in quotes", name)
    start, style, library = (file.string(table, key, "") for key in ("start", "style", "library"))
    return RuleChoices(file.path.parent / library if library else None, style, start, attributes)


# What is liked -------------------------------------------------------------------------------------------------------


def _factors(file: TomlFile, table: dict[str, Any], name: str, title: str) -> tuple[Factor, ...]:
    if "factors" not in table:
        return (Factor(name, title, _score(file, table)),)
    for key in ("preference", "definitions"):
        if key in table:
            raise file.wrong(f"expected either factors or {key}: the preference is the product of factors", key)
    names = file.strings(table, "factors", ())
    if not 1 <= len(names) <= MAX_FACTORS or len(set(names)) < len(names):
        raise file.wrong(f"expected 1 to {MAX_FACTORS} different names of scenarios", "factors")
    return tuple(_factor(file, table, factor) for factor in names)


def _factor(file: TomlFile, table: dict[str, Any], name: str) -> Factor:
    """Preference of another scenario file."""
    if not re.fullmatch(_NAME, name):
        raise file.wrong(f"expected the name of a scenario file beside this one, found {name!r:.80}", "factors")
    path = file.path.parent / f"{name}{SUFFIX}"
    text = read(path, "scenario")
    # Checked before it is read, so that files that name each other do not recurse.
    if "factors" in TomlFile(text, path).table():
        raise file.wrong(f"{name} has factors itself; expected scenarios with a preference", "factors")
    scenario = parse(text, path)
    if scenario.grammar != _grammar(file, table):
        raise file.wrong(f"{name} is about the grammar {scenario.grammar!r}, this about another", "factors")
    if scenario.choices != _choices(file, table):
        raise file.wrong(f"{name} has another start rule, style, library or attributes than this file", "factors")
    return scenario.factors[0]


def _score(file: TomlFile, table: dict[str, Any]) -> Score:
    definitions = _definitions(file, table)
    preference = table.get("preference")
    cases: list[ScoreCase] = []
    if isinstance(preference, list) and all(isinstance(case, dict) for case in preference):
        cases = [_case(file, case, number, definitions) for number, case in enumerate(preference)]
    elif not isinstance(preference, str):
        raise file.wrong(
            "expected a preference: one or more tables [[preference]], each with score and when, "
            'or preference = "an expression"',
            "preference",
        )
    try:
        return Score.of_text(preference, definitions) if isinstance(preference, str) else Score.of_cases(cases)
    except UsageError as error:
        raise file.wrong(str(error), "preference") from None


def _case(file: TomlFile, case: dict[str, Any], number: int, definitions: Mapping[str, Expression]) -> ScoreCase:
    line = file.line(r"^[ \t]*\[\[[ \t]*preference[ \t]*\]\]", number)
    file.check_keys(case, ("score", "when", "means"), "preference", line)
    value, when, means = file.number(case, "score", 100, line), case.get("when"), case.get("means", "")
    if value is None or not isinstance(when, str) or not isinstance(means, str):
        raise file.wrong("expected score = a number, when = an expression in quotes, means = a text", line=line)
    try:
        return ScoreCase(value, Expression.parse(when, definitions), means)
    except UsageError as error:
        raise file.wrong(f"case {number + 1}: {error}", line=line) from None


def _definitions(file: TomlFile, table: dict[str, Any]) -> dict[str, Expression]:
    texts = table.get("definitions", {})
    if not isinstance(texts, dict) or len(texts) > MAX_DEFINITIONS:
        raise file.wrong(f"expected a table [definitions] of at most {MAX_DEFINITIONS} lines", "definitions")
    definitions: dict[str, Expression] = {}
    for name, text in texts.items():
        if not isinstance(text, str):
            raise file.wrong(f"definition {name!r:.60}: expected an expression in quotes", name)
        if not re.fullmatch(r"[^\W\d]\w{0,63}", name) or name in RESERVED:
            raise file.wrong(f"{name!r:.80} cannot be the name of a definition: a plain word is expected", name)
        try:
            definitions[name] = Expression.parse(text, definitions)
        except UsageError as error:
            later = [
                other for other in texts if other not in definitions and re.search(rf"\b{re.escape(other)}\b", text)
            ]
            hint = f"\n  hint: a definition may use those above it; {later[0]} is not" if later else ""
            raise file.wrong(f"definition {name}: {error}{hint}", name) from None
    return definitions


# How it is measured --------------------------------------------------------------------------------------------------


def _features(file: TomlFile, table: dict[str, Any]) -> FeatureOptions:
    part = file.part(table, "features", ("path_length", "families"))
    families = file.strings(part, "families", FeatureOptions().families)
    for family in families:
        if family not in FAMILIES:
            raise file.wrong(f"unknown family of features {family!r:.60}{nearest(family, FAMILIES)}", "families")
    length = file.integer(part, "path_length", 1, MAX_PATH_LENGTH)
    return FeatureOptions(length or FeatureOptions().path_length, families)


def _paper(file: TomlFile, table: dict[str, Any]) -> PaperFigures:
    divergences = ("original", "p_learning", "s_learning")
    part = file.part(table, "paper", (*divergences, "labels", "kde_labels", "figure"))
    original, p_learning, s_learning = (file.number(part, key, MAX_DIVERGENCE) for key in divergences)
    labels, kde_labels = (file.integer(part, key, 1, MAX_MODELS) for key in ("labels", "kde_labels"))
    return PaperFigures(original, p_learning, s_learning, labels, kde_labels, file.string(part, "figure", ""))


def _target(file: TomlFile, table: dict[str, Any]) -> ScenarioGoal:
    part = file.part(table, "target", ("js", "labels", "aim", "since", "ask"))
    js = file.number(part, "js", MAX_DIVERGENCE)
    labels, aim, ask = (file.integer(part, key, 1, MAX_MODELS) for key in ("labels", "aim", "ask"))
    since = cast(Since, file.one_of(part, "since", ("start", "first liked")))
    if ask is not None and labels is not None and ask < labels:
        raise file.wrong(f"expected to ask for at least the {labels} labels of the target, found ask = {ask}", "ask")
    return ScenarioGoal(ScenarioGoal().js if js is None else js, labels, aim, since, ask)
