"""What is liked turns out to be rare: a session looks for it among many more models, as `grammarlab evaluate` does."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.evaluation import protocol, scenario
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import Source, prepare
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.pages.record.judgements import Judgement
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.learning import WIDER_POOL
from grammarlab.pages.scoring.session import Session
from grammarlab.pages.workers.learner import learner
from grammarlab.pages.workers.tasks import Choose, ModelChoice, Update
from grammarlab.pages.workers.worker_pool import Handler
from grammarlab.preference.liked import MIN_SCORED
from grammarlab.randomness import derived_seed
from tests.cases import some, takes_turns
from tests.pages.scoring.rare import POSTS, SCENARIO, scores_of
from tests.pages.scoring.windows import Window, shown_models

SIZE, BATCH, ROUNDS = 250, 16, 7
NUMBERS = {"overall": 1}


NOTHING_LIKED = dict.fromkeys(ModelPool(0, SIZE).names[: MIN_SCORED + 8], Judgement(0.0))


class Stop:
    """Cancels a task when it has reported some times, as a session does."""

    def __init__(self, after: int = -1) -> None:
        self.left = after

    def __call__(self, _stage: str, _done: int, _total: int) -> None:
        if not self.left:
            raise InterruptedError
        self.left -= 1


report = Stop()


def new_learner(seed: int = 0) -> Handler:
    return learner(".cga", POSTS, "posts", Path(), seed, SIZE, False)


def asked_by_protocol(seed: int) -> list[str]:
    """The models that a simulated person is asked about, round after round, in a pool of the same seed and size."""
    wanted = replace(scenario.parse(SCENARIO), num_models=SIZE, seed=seed)
    material = prepare(
        Source(wanted, GrammarSpace(Grammar.parse(POSTS), Path())), METHODS["default"].settings(wanted.features)
    )
    state, _ = protocol.run(material, BATCH, seed, BATCH * ROUNDS)
    assert state.wide
    return [str(address) for answers in state.answers.values() for address in answers.designs]


def asked_by_session(seed: int) -> list[str]:
    """The models that a session shows, if all of them are scored and then updated, round after round."""
    handler, scores = new_learner(seed), {}

    def choice() -> ModelChoice:
        return ModelChoice("default", "overall", BATCH, derived_seed(seed, len(scores) // BATCH, 0, 0))

    shown = handler(Choose({"overall": {}}, NUMBERS, choice()), report)
    for _ in range(ROUNDS):
        scores |= {model: Judgement(score) for model, score in scores_of(shown).items()}
        found = handler(Update({"overall": scores}, NUMBERS, choice()), report)
        assert found.wide == (len(scores) >= MIN_SCORED)
        shown = found.chosen
    return list(scores)


@pytest.mark.parametrize("seed", some(range(2)))
@takes_turns
def test_a_session_asks_about_the_same_models_as_the_protocol(seed: int):
    asked = asked_by_session(seed)
    assert asked == asked_by_protocol(seed)
    narrow = ModelPool(seed, SIZE).index
    liked = [model for model, score in scores_of(asked).items() if score]
    assert any(model not in narrow for model in liked)


def test_widening_that_is_cancelled_at_any_moment_leaves_everything_as_it_was():
    handler, choice = new_learner(), ModelChoice("uniform", "overall", 12, 5)
    few = Choose({"overall": dict(list(NOTHING_LIKED.items())[:20])}, NUMBERS, choice)
    assert not handler(Update(few.factors, NUMBERS, choice), report).wide
    before = handler(few, report)
    update = Update({"overall": NOTHING_LIKED}, NUMBERS, choice)
    found, cancelled = None, 0
    while found is None:
        try:
            found = handler(update, Stop(cancelled))
        except InterruptedError:
            cancelled += 1
            assert handler(few, report) == before
    assert cancelled >= 4
    assert found.wide
    assert found.chosen == new_learner()(update, report).chosen


def test_scores_alone_do_not_widen_what_is_learned_from_again():
    """As when a session is opened again: what is offered changes when the person updates, and is in the file then."""
    update = Update({"overall": NOTHING_LIKED}, NUMBERS, None)
    assert not new_learner()(update, report).wide
    assert new_learner()(replace(update, wide=True), report).wide
    assert learner(".cga", POSTS, "posts", Path(), 0, SIZE, True)(update, report).wide


@pytest.fixture
def posts(tmp_path: Path) -> str:
    path = tmp_path / "posts.cga"
    path.write_text(POSTS)
    return str(path)


@pytest.fixture
def session(tmp_path: Path, posts: str) -> Iterator[Session]:
    with closing(Session(posts, tmp_path / "posts.db", size=SIZE, jobs=0)) as session:
        yield session


def updated(session: Session, window: Window, models: list[str]) -> dict:
    """The state after some models were found to be worth nothing."""
    session.call("score", models=models, score=0)
    window.forget()
    session.call("update")
    return window.state(lambda state: state["fresh"] and not state["updating"])


def widened(session: Session, window: Window) -> dict:
    """The state after as many as it takes."""
    state = session.call("state")[0]
    for _ in range(MIN_SCORED // 32):
        assert not window.heard or WIDER_POOL not in (state["message"] or "")
        state = updated(session, window, shown_models(state))
    return state


def newly_shown(session: Session, way: str) -> list[str]:
    window = Window(session)
    session.call("new_models", way=way)
    return shown_models(window.state(lambda state: state["way"] == way and not state["updating"]))


@takes_turns
def test_a_person_is_told_once_and_shown_models_of_the_wider_pool(session: Session, tmp_path: Path):
    window = Window(session)
    state = widened(session, window)
    assert WIDER_POOL in state["message"]
    narrow, models = ModelPool(0, SIZE).index, shown_models(state)
    assert any(model not in narrow for model in models)
    assert set(state["models"]) <= set(ModelPool(0, SIZE, wide=True).index)
    assert all(known["mean"] is not None for known in state["models"].values())
    assert all(0.0 <= point["js"] <= np.log(2.0) for point in state["chart"])
    state = updated(session, window, models)
    assert WIDER_POOL not in (state["message"] or "")
    with closing(Store.open(tmp_path / "posts.db")) as store:
        assert store.record.wide


@takes_turns
def test_what_is_undone_later_does_not_take_the_models_away(session: Session):
    window = Window(session)
    models = shown_models(widened(session, window))
    session.call("score", models=models[:1], score=50)
    while session.call("state")[0]["can_undo"]:
        session.call("undo")
    session.call("score", models=models, score=70)
    window.forget()
    session.call("update")
    state = window.state(lambda state: state["fresh"] and not state["updating"])
    offered = ModelPool(0, SIZE, wide=True).index
    assert set(state["models"]) <= set(offered)
    assert all(model in offered for model in shown_models(state))
    assert any(model not in ModelPool(0, SIZE).index for model in newly_shown(session, "uniform"))


@takes_turns
def test_a_session_that_is_opened_again_offers_the_same_models(session: Session, tmp_path: Path, posts: str):
    window = Window(session)
    before = widened(session, window)
    with closing(sqlite3.connect(tmp_path / "posts.db")) as file, closing(sqlite3.connect(tmp_path / "b.db")) as copy:
        file.backup(copy)
    with closing(Session(posts, tmp_path / "b.db", jobs=0)) as again:
        other = Window(again)
        assert again.call("state")[0]["grids"] == before["grids"]
        assert again.call("state")[0]["models"].keys() == before["models"].keys()
        again.handle({"id": 1, "command": "features", "query": "Lot"}, (), other.send)
        after = other.state(lambda state: state["fresh"])
        assert after["models"] == before["models"]
        for way in ("uniform", "default"):
            assert newly_shown(again, way) == newly_shown(session, way)


def test_a_file_of_before_is_widened_once_it_is_learned_from(tmp_path: Path, posts: str):
    with closing(Session(posts, tmp_path / "a.db", size=SIZE, jobs=0)):
        pass
    with closing(Store.open(tmp_path / "a.db")) as store:
        store.append("score", {"factor": "overall", "models": list(NOTHING_LIKED), "score": 0})
        store.append("learned", {"labels": len(NOTHING_LIKED), "js": 0.1})
        assert not store.record.wide
    with closing(Session(posts, tmp_path / "a.db", jobs=0)) as session:
        window = Window(session)
        session.handle({"id": 1, "command": "features", "query": "Lot"}, (), window.send)
        state = window.state(lambda state: state["fresh"])
        assert WIDER_POOL in state["message"]
        # It is in the file before models of the wider pool are shown.
        assert not session.desk.display.record.wide
        session.call("new_models", way="default")
        assert session.desk.display.record.wide
        assert len(session.call("state")[0]["chart"]) == 2
