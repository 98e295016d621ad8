"""A simulated person scores through the page alone, and the session learns what it would have learned without one."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from grammarlab.features.patterns.counts import count
from grammarlab.learning.designs.addresses import Address
from grammarlab.pages.scoring.session import Session
from grammarlab.runs.sample.sources import load_source
from tests.browser.driver import Server
from tests.cases import takes_turns
from tests.pages.scoring.windows import Window, shown_models

SCENARIOS = Path(__file__).parents[3] / "scenarios"
ROUNDS = (16, 16)
"""Scores given before each update."""


class Person:
    """Likes what a scenario says."""

    def __init__(self, scenario: str) -> None:
        self.source = load_source(SCENARIOS / f"{scenario}.toml")

    def scores(self, models: list[str]) -> list[float]:
        """What the person thinks of models, 0 to 100."""
        addresses = {model: Address.parse(model) for model in models}
        different = sorted(set(addresses.values()))
        score = self.source.scenario.score
        values = score.evaluate(count(self.source.space.make(different), score.features)).tolist()
        return [values[different.index(addresses[model])] for model in models]

    def judgement(self, models: list[str]) -> dict[float, list[str]]:
        """The models that get each score, in the order shown."""
        scores = self.scores(models)
        return {
            score: [model for model, own in zip(models, scores, strict=True) if own == score]
            for score in dict.fromkeys(scores)
        }


@pytest.fixture
def person(request):
    return Person(request.param)


def through_the_page(page, person):
    """Clicks what deserves a score, gives it, updates; what the page predicts in the end."""
    for num in ROUNDS:
        models = page.models()
        for score, deserving in person.judgement(models[:num]).items():
            for number, model in enumerate(deserving):
                page.cell(models.index(model)).click(modifiers=["Control"] if number else [])
            page.button(f"{score:g}").click()
            page.expect_saved()
        page.update()
    return page.models(), page.labels(), page.page.locator(".gl-dot title").all_text_contents()


def through_python(session, person):
    """The same choices, given to the session itself."""
    window = Window(session)
    state = window.state(lambda state: True)
    for num in ROUNDS:
        models = shown_models(state)
        for score, deserving in person.judgement(models[:num]).items():
            session.call("score", models=deserving, score=score)
        window.forget()
        session.call("update")
        state = window.state(lambda state, old=models: state["fresh"] and shown_models(state) != old)
    return state


def rounded(share: float) -> float:
    """A share as the page has it: whole percents, or one digit of less than ten."""
    return float(np.floor(share + 0.5) if share >= 10.0 else f"{share:.1g}")


@pytest.mark.parametrize("person", ["tastes/tuning/symmetric_toy"], indirect=True)
@takes_turns
def test_the_page_and_python_reach_the_same_density(person, opened, tmp_path):
    grammar = person.source.scenario.grammar
    server = Server(grammar, tmp_path / "page.db").start()
    try:
        page = opened(server.address)
        models, labels, chart = through_the_page(page, person)
    finally:
        server.kill()
    with closing(Session(grammar, tmp_path / "python.db", jobs=0)) as session:
        state = through_python(session, person)
    assert models == shown_models(state)
    for model, label in zip(models, labels, strict=True):
        known = state["models"][model]
        mean, std = (int(np.floor(known[name] + 0.5)) for name in ("mean", "std"))
        assert label.endswith(f"predicted {mean} ± {std}"), (label, known)
    moved = [float(words.removesuffix(" %").rpartition(" ")[2]) for words in chart]
    assert moved == [rounded(100.0 * point["js"] / np.log(2.0)) for point in state["chart"]]
    assert len(moved) == len(ROUNDS)
