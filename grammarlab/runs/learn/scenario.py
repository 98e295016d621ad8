"""From a scenario to a learned grammar on disk, and how good it is."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import cast

import numpy as np
from numpy.typing import NDArray

from grammarlab import __version__
from grammarlab.density import sampled
from grammarlab.density.compile import compile_base, compile_score
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.rejection import RejectionSampler, reject
from grammarlab.density.skeleton import ENOUGH_MODELS
from grammarlab.density.target import Target
from grammarlab.derivation.derive import derive, derive_chunks
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.evaluation.agreement import Agreement, agreement
from grammarlab.evaluation.flattening import flattened
from grammarlab.evaluation.preparation import Source, labelled_program
from grammarlab.features.counting import count
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax import String
from grammarlab.language.walking import walk
from grammarlab.runs.atomic import write_text
from grammarlab.runs.evaluate.task import load_source
from grammarlab.runs.examples import find_rules

Floats = NDArray[np.float64]

METHODS = ("compile", *sampled.METHODS, "rejection")
"""Of these, rejection makes no grammar."""


@dataclass(frozen=True, slots=True)
class LearnResult:
    """A learned grammar and how good it is."""

    learned: LearnedGrammar | RejectionSampler
    scenario: str
    file: Path | None
    """The new rule file; None where the method makes no grammar."""
    js: float
    """Divergence from the wanted density on the scenario's labelled set, in nats."""
    js_before: float
    """That of the grammar as it was."""
    correlation: float
    """Of the weights of the two densities on that set."""
    seconds: float
    """From the preference to the text of the grammar."""


def learn_from_scenario(
    grammar: str, scenario: Path, method: str, file: Path, num_samples: int = sampled.NUM_SAMPLES
) -> LearnResult:
    """Learns the grammar that samples in proportion to a known preference, and measures it.

    Args:
        grammar: a rule file or the name of a shipped grammar: that of the scenario.
        scenario: a scenario file.
        method: of `METHODS`.
        file: where to write the new rule file; assets that it names are put beside it.
        num_samples: models to learn from, for the methods that need them.

    Raises:
        UsageError: for an unknown method, or a grammar that the scenario is not about.
        GrammarlabError: when the density cannot be made.
    """
    if method not in METHODS:
        raise UsageError(f"no method is called {method!r}; those there are: {', '.join(METHODS)}")
    source = scenario_of(scenario, grammar, Grammar.parse(find_rules(grammar).text()))
    found = source.scenario
    source_forest = derive(source.grammar, ENOUGH_MODELS, found.seed, assets=source.assets)
    found.check(source_forest.symbols, source_forest.rules, source_forest.sites)
    begun = perf_counter()
    learned = _learned(source, method, source_forest, num_samples)
    seconds = perf_counter() - begun
    if isinstance(learned, LearnedGrammar):
        file.parent.mkdir(parents=True, exist_ok=True)
        write_text(file, learned.text)
        put_assets_beside(file, source.grammar, source.assets)
    after, before = measure(source, learned, source_forest)
    written = file if isinstance(learned, LearnedGrammar) else None
    return LearnResult(learned, found.name, written, after.js, before.js, after.correlation, seconds)


def scenario_of(scenario: Path, name: str, grammar: Grammar) -> Source:
    """A scenario about a grammar.

    Args:
        scenario: a scenario file.
        name: of the grammar, as the user gave it.
        grammar: the same, read.

    Raises:
        UsageError: when the scenario is about another one.
    """
    source = load_source(scenario)
    if grammar.hash != source.grammar.hash:
        raise UsageError(
            f"scenario {source.scenario.name} is about the grammar {source.scenario.grammar}, not about {name}"
        )
    return source


def measure(source: Source, learned: LearnedGrammar | RejectionSampler, forest: Forest) -> tuple[Agreement, Agreement]:
    """How near a learned density comes to the wanted one on the labelled set of a scenario, and the original one.

    Args:
        source: the scenario with its grammar.
        learned: a density over the trees of the grammar.
        forest: some derivations of the grammar.
    """
    base = compile_base(source.grammar, source.scenario.score, source.scenario.base, forest)
    wanted, weights, ratio = _labelled(source, learned, base)
    return agreement(wanted, ratio, weights), agreement(wanted, np.ones(len(wanted)), weights)


def _learned(source: Source, method: str, forest: Forest, num_samples: int) -> LearnedGrammar | RejectionSampler:
    """What a method makes of a scenario. Samples are others than those of the labelled set."""
    grammar, found, header = source.grammar, source.scenario, _header(source, method)
    if method == "compile":
        options = {"forest": forest, "header": header, "assets": source.assets}
        return compile_score(grammar, found.score, base=found.base, **options)
    target = Target.of_score(grammar, found.score, found.base, source.assets)
    seed = (found.seed + 1) % 2**64
    if method == "rejection":
        return reject(target, num_pilot=num_samples, seed=seed)
    return sampled.learn(target, cast(sampled.Method, method), num_samples=num_samples, seed=seed, header=header)


def _header(source: Source, method: str) -> list[str]:
    found = source.scenario
    name = Path(found.grammar).name.removesuffix(".cga")
    return [
        f"Learned by grammarlab {__version__} from {name}.cga (SHA-256 {source.grammar.hash[:16]})",
        f"Scenario {found.name}: {found.title}",
        f"Method {method}, base {found.base}",
    ]


def _labelled(
    source: Source, learned: LearnedGrammar | RejectionSampler, base: LearnedGrammar
) -> tuple[Floats, Floats, Floats]:
    """Of each labelled model the wanted and the learned density by that of the original, and what it stands for."""
    rows = [_measured(source, learned, base, forest) for forest in _labelled_set(source)]
    wanted, log_weights, ratio = (np.concatenate(column) for column in zip(*rows, strict=True))
    if not wanted.any():
        raise UsageError(
            f"scenario {source.scenario.name}: none of its {len(wanted):,} labelled models has a score above 0, so "
            'there is no density to compare with. Raise num_models, or set draws = "flattened".'
        )
    return wanted, np.exp(log_weights - log_weights.max()), ratio


def _measured(
    source: Source, learned: LearnedGrammar | RejectionSampler, base: LearnedGrammar, forest: Forest
) -> tuple[Floats, Floats, Floats]:
    score = source.scenario.score
    flat = source.scenario.draws == "flattened"
    log_weights = flattened(source.grammar).log_ratio(forest) if flat else np.zeros(forest.num_models)
    wanted = score.evaluate(count(forest, score.features)) * base.ratio(forest)
    return wanted, log_weights, learned.ratio(forest)


def _labelled_set(source: Source) -> Iterator[Forest]:
    found = source.scenario
    yield from derive_chunks(labelled_program(source), found.num_models, found.seed, assets=source.assets)


def put_assets_beside(file: Path, grammar: Grammar, assets: Path) -> None:
    """Copies the folders of the assets that a grammar names to where a rule file at this place looks for them."""
    folder = file.parent / "assets"
    if not assets.is_dir() or folder.resolve() == assets.resolve():
        return
    for node in walk(grammar.tree):
        if isinstance(node, String) and "/" in node.value and (assets / node.value).is_file():
            top = Path(node.value).parts[0]
            if not (folder / top).exists():
                shutil.copytree(assets / top, folder / top)
