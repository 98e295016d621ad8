"""A session whose processes die goes on as if nothing had happened."""

from __future__ import annotations

import os
import signal
from contextlib import closing
from pathlib import Path

from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.session import Session
from tests.pages.scoring.windows import Window
from tests.runs.processes import expect_gone


def kill_learner(session: Session) -> None:
    for worker in session.desk.learning._learners._workers:
        os.kill(worker.process.pid, signal.SIGKILL)
        expect_gone([worker.process.pid])


def seen(path: Path, rules: str, *, killed: bool) -> tuple:
    """What a person sees of a session in which the learner may die: during an update, and later while it rests."""
    names = ModelPool(3, 200).names
    with closing(Session(rules, path, seed=3, size=200, jobs=0)) as session:
        window = Window(session)
        for turn, models in enumerate((names[:6], names[6:20])):
            for number, model in enumerate(models):
                session.call("score", models=[model], score=100 * (number % 2))
            window.forget()
            session.call("update")
            if turn and killed:
                window.wait(lambda message: message.get("stage", "").startswith("learning"))
                kill_learner(session)
            window.state(lambda state, turn=turn: len(state["chart"]) == turn + 1 and not state["updating"])
        if killed:
            kill_learner(session)
        window.forget()
        session.call("new_models", way="uncertainty")
        state = window.state(lambda state: state["grids"] and not state["updating"])
        return state["grids"], state["chart"], state["message"]


def test_a_session_whose_learner_dies_shows_what_another_one_shows(tmp_path: Path, rules: str):
    killed, unharmed = (seen(tmp_path / f"{killed}.db", rules, killed=killed) for killed in (True, False))
    assert killed == unharmed
