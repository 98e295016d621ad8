"""Models in line, and what a person hears of fits: without processes, each task ends when the test says so."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.progress_line import LAST_REPORT
from grammarlab.pages.record.model_grids import PAIRS
from grammarlab.pages.record.store import About, Store
from grammarlab.pages.scoring.display import SessionDisplay
from grammarlab.pages.scoring.learning import WIDER_POOL, Learning
from grammarlab.pages.scoring.next_models import NextModels, fresh_samples
from grammarlab.pages.scoring.session_files import SessionFiles
from grammarlab.pages.scoring.state import state_of
from grammarlab.pages.windows import Answer, Message
from grammarlab.pages.workers.tasks import (
    Choose,
    DrawSheet,
    Features,
    LearnedFile,
    LearnedUpdate,
    LearnGrammar,
    Predictions,
    Prepare,
    Singles,
    Update,
)
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool
from tests.pages.scoring.tower import TOWER

LEFT_OUT = "Nothing is liked yet: score at least one model above 0."


@dataclass
class _Held(WorkerPool):
    """A pool without processes."""

    make: str = ""
    arguments: tuple[Any, ...] = ()
    size: int = 0
    deliver: Callable[[Callable[[], None]], None] = lambda job: job()

    @property
    def requests(self) -> list[Any]:
        return [task.request for task in self._waiting]

    def report(self, kind: type, stage: str, done: int, total: int) -> None:
        """The first task of a kind reports its progress."""
        task = next(task for task in self._waiting if isinstance(task.request, kind))
        assert task.on_progress is not None
        task.on_progress(stage, done, total)

    def end(self, kind: type, value: object) -> Any:
        """End the first task of a kind, and return its request."""
        task = next(task for task in self._waiting if isinstance(task.request, kind))
        self._waiting.remove(task)
        task.then(TaskOutcome(value))
        return task.request


@dataclass
class _Person:
    """A person at a page."""

    display: SessionDisplay
    learners: _Held
    learning: Learning

    @property
    def shown(self) -> tuple[str, ...]:
        return self.display.record.shown_now

    @property
    def titles(self) -> list[str]:
        return [grid.title for grid in self.display.record.grids]

    def score(self, models: Sequence[str], score: float = 90.0) -> None:
        self.display.label("score", {"models": list(models), "score": score}, "", "")

    def rest(self, num: int) -> tuple[str, ...]:
        """Models that were neither shown nor scored, the last ones of the samples."""
        record = self.display.record
        used = {*record.shown_models, *record.labelled_models}
        return tuple(model for model in reversed(self.display.pool.samples) if model not in used)[:num]

    def learn_behind(self, chosen: Sequence[str], mean: float = 0.0, **known: Any) -> Update:
        """A fit behind the person ends."""
        self.score([self.display.pool.names[0]], self.display.record.revision % 100)
        self.learning.learn_behind()
        return self.learners.end(Update, self.learned(chosen, mean, **known))

    def learned(self, chosen: Sequence[str], mean: float, **known: Any) -> LearnedUpdate:
        wide = known.get("wide", False)
        predicted = _predictions(len(self.display.pool.names) * (3 if wide else 1), mean)
        values: dict[str, Any] = {"wide": wide, "left_out": (), "number": self.display.record.revision} | known
        every = {"overall": predicted}
        return LearnedUpdate(
            features=None, elsewhere=(), factors=every, product=predicted, js=0.1, chosen=tuple(chosen), **values
        )


def _state(person: _Person) -> Message:
    # A desk as far as the state of the page needs one.
    desk: Any = SimpleNamespace(display=person.display, learning=person.learning, target=Path("towers.db"))
    return state_of(desk)


def _predictions(num: int, mean: float) -> Predictions:
    values: Singles = np.full(num, mean, dtype=np.float32)
    return Predictions(values, np.ones(num, dtype=np.float32), None, ())


@pytest.fixture
def person(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[_Person]:
    monkeypatch.setattr("grammarlab.pages.scoring.learning.PAUSE_SECONDS", 0.0)
    store = Store.open(tmp_path / "towers.db", About("tower", TOWER, 3, 400))
    display, learners = SessionDisplay(store, lambda: None), _Held()
    display.show("default", NextModels((), fresh_samples(display.pool, display.record, 32)))
    learning = Learning(display, learners, lambda _stage, _done, _total: None)
    learning.prepare()
    rows = np.zeros((400, 1), dtype=np.float32)
    learners.end(Prepare, Features(1, rows, ("one",)))
    yield _Person(display, learners, learning)
    store.close()


@pytest.mark.parametrize("way", ["uniform", "density", "uncertainty", "default"])
def test_models_in_line_are_none_that_are_shown_and_nobody_waits_for_more(person: _Person, way: str):
    person.learn_behind(())
    person.learning.new_models(way)
    if way != "default":
        person.learners.end(Choose, person.rest(32))
    before = person.shown
    choice = person.learners.end(Choose, person.rest(32)).choice
    assert set(choice.without) == set(before)
    line = person.learning.upcoming()
    assert not set(line) & set(before)
    # One of them is scored elsewhere, and a fit begins.
    person.score(line[:1])
    person.learning.learn_behind()
    person.learning.more()
    assert [type(request) for request in person.learners.requests] == [Update]
    assert person.learning.updating is None
    new = set(person.shown) - set(before)
    assert line[0] not in new
    assert len(new & set(line)) >= 30
    # What the fit chose was partly shown meanwhile: others are chosen, and what is left can be shown.
    person.learners.end(Update, person.learned((*tuple(new)[:8], *person.rest(8)), 0.0))
    assert [type(request) for request in person.learners.requests] == [Choose]
    assert not set(person.learning.upcoming()) & set(person.shown)


def test_halves_of_liked_and_disliked_models_stay_halves(person: _Person):
    person.learn_behind(())
    person.learning.new_models("density")
    person.learners.end(Choose, person.rest(32))
    line = person.rest(32)
    person.learners.end(Choose, line)
    person.score(line[3:5])
    person.learning.new_models("density")
    liked, disliked = person.display.record.grids
    assert liked.models == (*line[:3], *line[5:16])
    assert disliked.models == (*line[16:19], *line[21:])


def test_samples_without_a_choice_are_not_said_to_tell_the_most(person: _Person):
    person.learn_behind(())
    learned = person.learned((), 0.0)
    learned.factors["overall"].mean[-8:] = 90.0
    person.score([person.display.pool.names[1]])
    person.learning.learn_behind()
    person.learners.end(Update, learned)
    person.learning.new_models("default")
    assert person.titles == ["may be liked, the best first", "to score"]


def test_once_there_are_no_samples_others_are_chosen(person: _Person):
    person.score(person.display.pool.samples)
    person.learn_behind(())
    person.learning.new_models("default")
    chosen = [name for name in person.display.pool.names if Address.parse(name).flat][:4]
    assert not person.display.message
    person.learners.end(Choose, chosen)
    assert person.shown == tuple(chosen)


def test_both_models_of_the_next_pairs_are_drawn_ahead(person: _Person):
    person.learning.new_models(PAIRS)
    person.learn_behind(line := person.rest(16))
    assert person.learning.upcoming() == list(line)
    assert _state(person)["line"] == list(line[:8])


def test_a_fit_behind_a_person_says_nothing_twice(person: _Person):
    person.learn_behind((), left_out=(LEFT_OUT,), wide=True)
    assert person.display.message == f"{LEFT_OUT} {WIDER_POOL}"
    person.learn_behind((), left_out=(LEFT_OUT,), wide=True)
    assert person.display.message is None
    person.learning.update()
    person.learners.end(Update, person.learned(person.rest(4), 0.0, left_out=(LEFT_OUT,), wide=True))
    assert LEFT_OUT in (person.display.message or "")


def test_a_cancelled_update_leaves_no_fit_behind(person: _Person):
    person.score(person.shown[:4])
    person.learning.learn_behind()
    person.learning.update()
    person.learning.cancel()
    person.learning.learn_behind()
    assert person.learners.requests == []
    assert "cancelled" in (person.display.message or "")


def test_models_on_the_page_have_the_predictions_of_the_latest_fit(person: _Person):
    for mean in (10.0, 70.0):
        person.learn_behind((), mean)
        state = _state(person)
        assert {state["models"][model]["mean"] for model in person.shown} == {mean}


def _files(makers: _Held, path: Path) -> tuple[SessionFiles, list[Message], Answer]:
    """Files of a session, the answers of windows, and what answers one."""
    display = SimpleNamespace(
        factors={}, record=SimpleNamespace(wide=False), store=SimpleNamespace(about=SimpleNamespace(seed=1))
    )
    answers: list[Message] = []

    def answer(message: Message, _buffers: Sequence[bytes]) -> None:
        answers.append(message)

    return SessionFiles(cast("SessionDisplay", display), path, makers, lambda *_: None), answers, answer


def test_a_grammar_whose_file_is_being_written_is_cancelled_no_more(tmp_path: Path):
    makers, refused = _Held(), []
    files, answers, answer = _files(makers, tmp_path / "a.db")
    files.learn_grammar(answer, refused.append)
    makers.report(LearnGrammar, *LAST_REPORT[:1], 0, 0)
    files.cancel()
    assert (makers.requests, refused) == ([], ["cancelled."])
    files.learn_grammar(answer, refused.append)
    makers.report(LearnGrammar, *LAST_REPORT)
    files.cancel()
    makers.end(LearnGrammar, LearnedFile("a-learned.cga", "", 0.0, 1, 1, ()))
    assert [each["file"] for each in answers] == ["a-learned.cga"]
    assert len(refused) == 1


def test_a_grammar_that_another_process_makes_again_can_be_cancelled_again(tmp_path: Path):
    makers, refused = _Held(), []
    files, _, answer = _files(makers, tmp_path / "a.db")
    files.learn_grammar(answer, refused.append)
    makers.report(LearnGrammar, *LAST_REPORT)
    makers.report(LearnGrammar, "learning from the scores", 0, 1)
    files.cancel()
    assert (makers.requests, refused) == ([], ["cancelled."])


def test_a_grammar_and_a_sheet_that_are_made_at_once_are_both_cancelled(tmp_path: Path):
    makers, refused = _Held(), []
    files, answers, answer = _files(makers, tmp_path / "a.db")
    files.sheet(1, answer, refused.append)
    makers.end(DrawSheet, b"")
    files.learn_grammar(answer, refused.append)
    files.sheet(1, answer, refused.append)
    files.cancel()
    assert (makers.requests, refused) == ([], ["cancelled."] * 2)
    files.cancel()
    assert (len(answers), len(refused)) == (1, 2)
