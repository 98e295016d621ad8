"""The same scores mean the same, whoever gives them: the page, a label file, a Python function, a simulated person."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.targets.accepted import AcceptedGrammar
from grammarlab.evaluation import protocol, scenario
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import Source, prepare
from grammarlab.features.patterns.counts import count
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.learn import learn
from grammarlab.learning.progress_line import LAST_REPORT
from grammarlab.pages.record.judgements import Judgement
from grammarlab.pages.workers.learner import learner
from grammarlab.pages.workers.maker import maker
from grammarlab.pages.workers.tasks import LearnGrammar, Update
from grammarlab.preference.label_files import save_labels
from grammarlab.preference.labels import OVERALL, Labels
from tests.cases import some
from tests.command_line import invoke

RULES = """
attr floors = 50% : 2 else : 5
attr width = rand(4, 12)
Lot --> s(width, 0, 8) extrude(floors * 3) comp(f) { top : Top | side : Side }
Top --> 40% : Flat else : roofGable(30) Gable
Side --> 50% : color("#ff0000") Red else : color("#0000ff") Blue
"""
TASTES = {
    "a choice": "100 * {Flat}",
    "a bound on a draw": "100 * ($width < 7)",
    "several levels": "40 * {Flat} + 20 * ({Red} > 1)",
}
SEED, LABELS = 3, 24


def nothing(_stage: str, _done: int, _total: int) -> None:
    pass


def rules_of(text: str) -> str:
    """A learned file without the comment about where it comes from."""
    return "\n".join(line for line in text.splitlines() if not line.startswith("//"))


@pytest.mark.parametrize("taste", some(list(TASTES)))
def test_all_ways_to_answer_give_the_same_predictions_and_the_same_grammar(taste: str, tmp_path: Path):
    (tmp_path / "house.cga").write_text(RULES)
    text = f"""
name = "taste"
title = "A taste"
grammar = "house.cga"
seed = {SEED}
preference = "{TASTES[taste]}"
[features]
path_length = 2
families = ["paths", "symbols", "draws"]
"""
    wanted, grammar = scenario.parse(text, tmp_path / "taste.toml"), Grammar.parse(RULES)

    # A simulated person.
    settings = METHODS["default"].settings(wanted.features)
    material = prepare(Source(wanted, GrammarSpace(grammar, tmp_path)), settings)
    state, _ = protocol.run(material, 8, SEED, LABELS)
    assert state.product is not None
    predicted = state.product.predict(material.study.table(state).rows).mean

    # The page: the same scores, in an order of their own.
    (answers,) = state.answers.values()
    scores = dict(zip(map(str, answers.designs), answers.scores.tolist(), strict=True))
    place, size = ("house", tmp_path), len(material.study.pool)
    handler = learner(".cga", RULES, *place, SEED, size, False)
    shuffled = {name: Judgement(scores[name]) for name in sorted(scores, key=lambda name: name[::-1])}
    found = handler(Update({OVERALL: shuffled}, {OVERALL: 1}, None), nothing)
    assert np.array_equal(found.product.mean, predicted.astype(np.float32))
    make = maker(".cga", RULES, *place, str(tmp_path / "session.db"), SEED, size)
    reports: list[tuple[str, int, int]] = []
    pages = make(LearnGrammar({OVERALL: shuffled}, found.wide), lambda *report: reports.append(report)).text
    assert reports[-1] == LAST_REPORT

    # A label file.
    hashes = material.study.space.hashes
    rows = [design.label(OVERALL, scores[str(design)], hashes) for design in answers.designs]
    save_labels(Labels(tuple(rows)), tmp_path / "labels.csv")
    command = ["learn", str(tmp_path / "house.cga"), "--labels", str(tmp_path / "labels.csv"), "--seed", str(SEED)]
    ran = invoke(*command, "-o", tmp_path / "learned.cga")
    assert ran.exit_code == 0, ran.output

    # A function.
    def score(forest):
        return wanted.score.evaluate(count(forest, wanted.score.features))

    density = learn(grammar, score, LABELS, pool=Pool(SEED), seed=SEED)
    assert isinstance(density.learned, LearnedGrammar | AcceptedGrammar)
    texts = {rules_of(pages), rules_of((tmp_path / "learned.cga").read_text()), rules_of(density.learned.text)}
    assert len(texts) == 1
