"""The widget in Python, without a page."""

import time

import pytest

from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.notebook import ScoringSession


@pytest.fixture
def sent(monkeypatch):
    """The messages that are sent to the page."""
    messages = []
    monkeypatch.setattr(ScoringSession, "send", lambda self, message, buffers=(): messages.append(message))
    return messages


@pytest.fixture
def session(sent, tmp_path):
    """A session about toys."""
    session = ScoringSession("toy", tmp_path / "toys.db", size=60, jobs=1)
    yield session
    session.close()


def wait_for(condition):
    deadline = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def first_models(session):
    wait_for(lambda: session.state.get("grids"))
    return [model for grid in session.state["grids"] for model in grid["models"]]


def test_what_python_scores_is_in_the_labels_and_in_the_state(session):
    models = first_models(session)
    session.do("score", models=models[:3], score=70)
    assert session.labels.scores.tolist() == [70, 70, 70]
    wait_for(lambda: session.state["scored"] == 3)


def test_what_the_page_asks_is_answered_to_the_page(session, sent):
    models = first_models(session)
    request = {"id": "k-1", "command": "score", "models": models[:2], "score": 40}
    session._receive(session, request, [])
    wait_for(lambda: any(message.get("id") == "k-1" for message in sent))
    (answer,) = (message for message in sent if message.get("id") == "k-1")
    assert answer["ok"]
    assert len(session.labels) == 2


def test_a_refused_command_says_why(session):
    with pytest.raises(GrammarlabError, match="expected a number from 0 to 100"):
        session.do("score", models=first_models(session)[:1], score=101)


def test_a_misspelt_option_is_refused(tmp_path):
    with pytest.raises(TypeError, match="sead"):
        ScoringSession("toy", tmp_path / "toys.db", sead=1)


def test_the_scores_of_a_closed_session_are_there_when_it_is_opened_again(session, tmp_path):
    session.do("score", models=first_models(session)[:5], score=10)
    session.close()
    again = ScoringSession("toy", tmp_path / "toys.db", jobs=1)
    assert len(again.labels) == 5
    again.close()
    (tmp_path / "toy.cga").write_text("Lot --> extrude(3)")
    with pytest.raises(UsageError, match="another grammar"):
        ScoringSession(str(tmp_path / "toy.cga"), tmp_path / "toys.db")
