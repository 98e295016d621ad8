"""scenarios/tastes/: they fit their grammars, leave something to learn, and mean what plain Python and the page say."""

import tomllib
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from grammarlab.asset_roots import AssetRoot
from grammarlab.derivation import Forest, derive
from grammarlab.evaluation import preparation
from grammarlab.evaluation.preparation import Source, labelled_set, prepare
from grammarlab.evaluation.scenario import load
from grammarlab.features.patterns.counts import count
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.flattening import flattened
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.settings import Settings
from grammarlab.runs.evaluate.request import named_scenarios, shipped_scenarios
from grammarlab.runs.sample.shipped import find_rules
from tests.cases import some
from tests.evaluation.scenarios.fresh_truth import FRESH_TRUTH
from tests.evaluation.scenarios.invented_truth import INVENTED_TRUTH
from tests.evaluation.scenarios.kinds_truth import KINDS_TRUTH
from tests.evaluation.scenarios.professions_truth import PROFESSIONS_TRUTH
from tests.evaluation.scenarios.sums_truth import SUMS_TRUTH
from tests.evaluation.scenarios.taste_truth import TASTE_TRUTH
from tests.evaluation.scenarios.truth import Model
from tests.evaluation.scenarios.truth import models as plain
from tests.evaluation.scenarios.unforeseen_truth import UNFORESEEN_TRUTH

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "scenarios" / "tastes"
PATHS = sorted(FOLDER.glob("*/*.toml"))
FOLDERS = ("tuning", "measured", "once", "later", "kinds", "invented", "unforeseen", "sums", "fresh", "professions")
TRUTH = TASTE_TRUTH | KINDS_TRUTH | INVENTED_TRUTH | UNFORESEEN_TRUTH | SUMS_TRUTH | FRESH_TRUTH | PROFESSIONS_TRUTH
LEAST = 0.1
"""Divergence in nats of the grammar as it is."""


def rows(folder: str) -> dict[str, tuple[str, ...]]:
    """The table of a folder in the page: kind, grammar, what is liked, original JS and share of models by name."""
    _, text = (FOLDER / "README.md").read_text().split(f"\n## {folder}\n")
    cells = [line.strip("| ").split(" | ") for line in text.split("\n## ")[0].splitlines() if line.startswith("| `")]
    return {name.strip("`"): tuple(rest) for name, *rest in cells}


TABLES = {folder: rows(folder) for folder in FOLDERS}


@cache
def grammar_of(named: str) -> tuple[Grammar, AssetRoot]:
    """The grammar that a scenario names, by name or by path, and its assets."""
    rules = find_rules(named)
    return Grammar.parse(rules.text()), rules.assets


@cache
def rules_file(named: str) -> str:
    """The file of the grammar that a scenario names: one path, whichever folder a scenario names it from."""
    return str(find_rules(named).path.resolve())


def shown(named: str) -> str:
    """The grammar that a scenario names, as the page shows it."""
    return Path(rules_file(named)).relative_to(ROOT / "grammars").with_suffix("").as_posix()


@cache
def models(grammar: str, draws: str, num_models: int, seed: int):
    """The labelled set that all tastes about a grammar share."""
    path = next(p for p in PATHS if rules_file((s := load(p)).grammar) == grammar and s.draws == draws)
    source = Source(load(path), GrammarSpace(*grammar_of(grammar)))
    assert (source.scenario.num_models, source.scenario.seed) == (num_models, seed)
    return labelled_set(source)


@pytest.mark.parametrize("path", some(PATHS), ids=lambda path: path.stem)
def test_a_taste_fits_its_grammar_and_has_something_to_learn(path, monkeypatch):
    scenario = load(path)
    assert (scenario.name, 10 < len(scenario.title) < 100) == (path.stem, True)
    assert path.read_text().startswith("# ")
    assert not {"features", "paper", "target", "methods"} & tomllib.loads(path.read_text()).keys()
    monkeypatch.setattr(
        preparation,
        "labelled_set",
        lambda _: models(rules_file(scenario.grammar), scenario.draws, scenario.num_models, scenario.seed),
    )
    source = Source(scenario, GrammarSpace(*grammar_of(scenario.grammar)))
    material = prepare(source, Settings())
    assert material.js_original >= LEAST
    liked = np.average(material.target > 0, weights=material.weights)
    _, grammar, title, js, share = TABLES[path.parent.name][path.stem]
    assert (grammar, title) == (shown(scenario.grammar), scenario.title)
    assert js == f"{material.js_original:.3f}"
    assert share == (f"{liked:.0%}" if liked > 0.005 else f"{liked:.0e}".replace("e-0", "e-"))


def test_the_folders_hold_every_kind_on_several_grammars():
    assert sorted(p.relative_to(FOLDER).parts for p in PATHS) == sorted(
        (folder, f"{name}.toml") for folder in FOLDERS for name in TABLES[folder]
    )
    assert len(PATHS) >= 24
    pairs = {folder: [(kind, grammar) for kind, grammar, *_ in TABLES[folder].values()] for folder in FOLDERS}
    for folder in FOLDERS:
        kinds, grammars = zip(*pairs[folder], strict=True)
        assert len(set(kinds)) == len(kinds)
        assert len(set(grammars)) >= 5
    tuning, measured, once, later, *_ = (dict(pairs[folder]).keys() for folder in FOLDERS)
    assert tuning == measured >= once >= later
    twice = [pair for pair, number in Counter(pair for own in pairs.values() for pair in own).items() if number > 1]
    # equal_skyscraper is about the colour of windows, equal_skyscraper_frames about frames.
    assert twice == [("all equal", "skyscraper")]


def test_no_two_shipped_scenarios_have_one_name():
    shipped = shipped_scenarios()
    assert set(named_scenarios()) == set(shipped) | {path.stem for path in PATHS}
    assert len(named_scenarios()) == len(shipped) + len(PATHS)
    hashes = [load(path).hash for path in named_scenarios().values()]
    assert len(set(hashes)) == len(hashes)


@cache
def few(grammar: str) -> tuple[tuple[Forest, ...], list[Model]]:
    """200 models, half of them with equally likely alternatives so that rare ones are among them."""
    rules, assets = grammar_of(grammar)
    forests = derive(rules, 100, 7, assets=assets), derive(flattened(rules).program, 100, 8, assets=assets)
    return forests, [model for forest in forests for model in plain(forest)]


@pytest.mark.parametrize("path", some(PATHS), ids=lambda path: path.stem)
def test_models_get_the_score_that_plain_python_gives_them(path):
    scenario = load(path)
    forests, trees = few(rules_file(scenario.grammar))
    scores = np.concatenate([scenario.score.evaluate(count(forest, scenario.score.features)) for forest in forests])
    assert len(np.unique(scores)) > 1
    assert np.allclose(scores, [TRUTH[path.stem](tree) for tree in trees], rtol=0, atol=1e-9)
