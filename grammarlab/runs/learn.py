"""From a scenario to a learned grammar on disk, and how good it is."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from grammarlab import __version__
from grammarlab.density.compile import compile_base, compile_score
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.skeleton import ENOUGH_MODELS
from grammarlab.derivation.derive import derive, derive_chunks
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.evaluation.agreement import agreement
from grammarlab.evaluation.flattening import flattened
from grammarlab.evaluation.preparation import Source, labelled_program
from grammarlab.features.counting import count
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax import String
from grammarlab.language.walking import walk
from grammarlab.runs.atomic import write_text
from grammarlab.runs.evaluate_task import load_source
from grammarlab.runs.examples import find_rules

Floats = NDArray[np.float64]

METHODS = ("compile",)


@dataclass(frozen=True, slots=True)
class LearnResult:
    """A learned grammar and how good it is."""

    learned: LearnedGrammar
    scenario: str
    file: Path
    js: float
    """Divergence from the wanted density on the scenario's labelled set, in nats."""
    js_before: float
    """That of the grammar as it was."""
    correlation: float
    """Of the weights of the two densities on that set."""
    seconds: float
    """From the preference to the text of the grammar."""


def learn_from_scenario(grammar: str, scenario: Path, method: str, file: Path) -> LearnResult:
    """Learns the grammar that samples in proportion to a known preference, and measures it.

    Args:
        grammar: a rule file or the name of a shipped grammar: that of the scenario.
        scenario: a scenario file.
        method: of `METHODS`.
        file: where to write the new rule file; assets that it names are put beside it.

    Raises:
        UsageError: for an unknown method, or a grammar that the scenario is not about.
        GrammarlabError: when the density cannot be made.
    """
    if method not in METHODS:
        raise UsageError(f"no method is called {method!r}; those there are: {', '.join(METHODS)}")
    source = load_source(scenario)
    text = find_rules(grammar).text()
    if Grammar.parse(text).hash != source.grammar.hash:
        raise UsageError(
            f"scenario {source.scenario.name} is about the grammar {source.scenario.grammar}, not about {grammar}"
        )
    found = source.scenario
    source_forest = derive(source.grammar, ENOUGH_MODELS, found.seed, assets=source.assets)
    found.check(source_forest.symbols, source_forest.rules, source_forest.sites)
    begun = perf_counter()
    learned = compile_score(
        source.grammar,
        found.score,
        base=found.base,
        forest=source_forest,
        header=_header(source, method),
        assets=source.assets,
    )
    seconds = perf_counter() - begun
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, learned.text)
    _put_assets_beside(file, source.grammar, source.assets)
    base = compile_base(source.grammar, found.score, found.base, source_forest)
    wanted, weights, ratio = _labelled(source, learned, base)
    after = agreement(wanted, ratio, weights)
    before = agreement(wanted, np.ones(len(wanted)), weights)
    return LearnResult(learned, found.name, file, after.js, before.js, after.correlation, seconds)


def _header(source: Source, method: str) -> list[str]:
    found = source.scenario
    name = Path(found.grammar).name.removesuffix(".cga")
    return [
        f"Learned by grammarlab {__version__} from {name}.cga (SHA-256 {source.grammar.hash[:16]})",
        f"Scenario {found.name}: {found.title}",
        f"Method {method}, base {found.base}",
    ]


def _labelled(source: Source, learned: LearnedGrammar, base: LearnedGrammar) -> tuple[Floats, Floats, Floats]:
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
    source: Source, learned: LearnedGrammar, base: LearnedGrammar, forest: Forest
) -> tuple[Floats, Floats, Floats]:
    score = source.scenario.score
    flat = source.scenario.draws == "flattened"
    log_weights = flattened(source.grammar).log_ratio(forest) if flat else np.zeros(forest.num_models)
    wanted = score.evaluate(count(forest, score.features)) * base.ratio(forest)
    return wanted, log_weights, learned.ratio(forest)


def _labelled_set(source: Source) -> Iterator[Forest]:
    found = source.scenario
    yield from derive_chunks(labelled_program(source), found.num_models, found.seed, assets=source.assets)


def _put_assets_beside(file: Path, grammar: Grammar, assets: Path) -> None:
    """Copies the folders of the assets that a grammar names to where a rule file at this place looks for them."""
    folder = file.parent / "assets"
    if not assets.is_dir() or folder.resolve() == assets.resolve():
        return
    for node in walk(grammar.tree):
        if isinstance(node, String) and "/" in node.value and (assets / node.value).is_file():
            top = Path(node.value).parts[0]
            if not (folder / top).exists():
                shutil.copytree(assets / top, folder / top)
