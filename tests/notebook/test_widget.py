"""The widget in Python, without a page."""

import multiprocessing
import subprocess
import sys
from contextlib import closing
from functools import partial
from typing import Any

import pytest

import grammarlab as gl
from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.language.presets import RuleChoices
from grammarlab.notebook import RuleView, ScoringSession
from tests.cases import takes_turns
from tests.waiting import PATIENCE, wait_until


@pytest.fixture
def sent(monkeypatch):
    """The messages that are sent to the page."""
    messages = []
    monkeypatch.setattr(ScoringSession, "send", lambda self, message, buffers=(): messages.append(message))
    return messages


@pytest.fixture
def session(sent, tmp_path):
    """A session about toys."""
    session = ScoringSession("toy", tmp_path / "toys.db", size=60, jobs=0)
    yield session
    session.close()


def first_models(session):
    wait_until(lambda: session.state.get("grids"))
    return [model for grid in session.state["grids"] for model in grid["models"]]


def test_what_python_scores_is_in_the_labels_and_in_the_state(session):
    models = first_models(session)
    session.do("score", models=models[:3], score=70)
    assert session.labels.scores.tolist() == [70, 70, 70]
    wait_until(lambda: session.state["scored"] == 3)


def test_what_the_page_asks_is_answered_to_the_page(session, sent):
    models = first_models(session)
    request = {"id": "k-1", "command": "score", "models": models[:2], "score": 40}
    session._receive(session, request, [])
    wait_until(lambda: any(message.get("id") == "k-1" for message in sent))
    (answer,) = (message for message in sent if message.get("id") == "k-1")
    assert answer["ok"]
    assert len(session.labels) == 2


def test_a_refused_command_says_why(session):
    with pytest.raises(GrammarlabError, match="expected a number from 0 to 100"):
        session.do("score", models=first_models(session)[:1], score=101)


def test_a_misspelt_option_is_refused(tmp_path):
    with pytest.raises(TypeError, match="sead"):
        ScoringSession("toy", tmp_path / "toys.db", sead=1)  # pyright: ignore[reportCallIssue]  # a mistake, meant


def test_the_scores_of_a_closed_session_are_there_when_it_is_opened_again(session, tmp_path):
    session.do("score", models=first_models(session)[:5], score=10)
    session.close()
    again = ScoringSession("toy", tmp_path / "toys.db", jobs=0)
    assert len(again.labels) == 5
    again.close()
    (tmp_path / "toy.cga").write_text("Lot --> extrude(3)")
    with pytest.raises(UsageError, match="another grammar"):
        ScoringSession(str(tmp_path / "toy.cga"), tmp_path / "toys.db")


def test_choices_for_a_rule_file_belong_to_the_session(sent, tmp_path):
    rules = tmp_path / "tower.cga"
    rules.write_text("attr h = 3  Lot --> extrude(h)  House --> extrude(h) B")
    options: dict[str, Any] = {"path": tmp_path / "towers.db", "jobs": 0}
    choices = RuleChoices(start_rule="House", attributes={"h": 5})
    first = ScoringSession(str(rules), choices=choices, **options)
    again = ScoringSession(str(rules), choices=RuleChoices(start_rule="House", attributes={"h": 5}), **options)
    assert again.do("state")["grids"] == first.do("state")["grids"]
    with pytest.raises(UsageError, match="start rule House, now Lot; attribute h = 5, now 3"):
        ScoringSession(str(rules), **options)
    again.close()


def processes():
    """Which work for sessions of this process."""
    return {process.pid for process in multiprocessing.active_children()}


def test_a_cell_that_is_run_again_goes_on_with_the_session_that_is_open(sent, tmp_path, monkeypatch):
    session = ScoringSession("toy", tmp_path / "toys.db", size=60, jobs=1)
    models, workers = first_models(session), processes()
    monkeypatch.chdir(tmp_path)
    again = ScoringSession("toy", "./toys.db", size=60, jobs=1)
    assert processes() == workers != set()
    again.do("score", models=models[:2], score=30)
    for widget in (session, again):
        wait_until(lambda widget=widget: widget.state.get("scored") == 2)
    session.close()
    assert processes() == workers
    assert again.do("score", models=models[:3], score=40)["saved"]
    again.close()
    assert not processes()
    assert again.labels.scores.tolist() == [40, 40, 40]


def test_no_process_is_left_by_cells_that_were_run_many_times(sent, tmp_path):
    widgets = [ScoringSession("toy", tmp_path / "toys.db", size=60, jobs=1) for _ in range(5)]
    models = first_models(widgets[0])
    assert len(processes()) <= 2
    widgets[-1].close()
    assert not processes()
    assert "has been closed" in next(message["message"] for message in sent if message.get("event") == "closed")
    with pytest.raises(GrammarlabError, match="has been closed"):
        widgets[0].do("score", models=models[:1], score=30)
    for widget in widgets:
        widget.close()


def test_a_cell_that_is_run_again_with_other_arguments_opens_the_session_anew(sent, tmp_path):
    rules = tmp_path / "tower.cga"
    rules.write_text("Lot --> 50% : extrude(3) else : extrude(5)")
    first = ScoringSession(str(rules), tmp_path / "towers.db", size=60, jobs=1)
    models = first_models(first)
    first.do("score", models=models[:2], score=30)
    other = ScoringSession(str(rules), tmp_path / "towers.db", size=60, jobs=0)
    with pytest.raises(GrammarlabError, match="has been closed"):
        first.do("score", models=models[:1], score=30)
    rules.write_text("Lot --> extrude(3)")
    with pytest.raises(UsageError, match="another grammar"):
        ScoringSession(str(rules), tmp_path / "towers.db", size=60, jobs=0)
    assert other.do("score", models=models[:3], score=60)["saved"]
    stored = ScoringSession(str(rules), tmp_path / "towers.db", jobs=0, stored_grammar=True)
    assert stored.labels.scores.tolist() == [60, 60, 60]
    stored.close()
    assert not processes()


def test_a_session_whose_file_was_deleted_is_begun_anew(sent, tmp_path):
    before = ScoringSession("toy", tmp_path / "toys.db", size=60, jobs=0)
    before.do("score", models=first_models(before)[:2], score=30)
    (tmp_path / "toys.db").unlink()
    after = ScoringSession("toy", tmp_path / "toys.db", size=60, jobs=0)
    assert not len(after.labels)
    after.do("score", models=first_models(after)[:1], score=70)
    after.close()
    again = ScoringSession("toy", tmp_path / "toys.db", size=60, jobs=0)
    assert again.labels.scores.tolist() == [70]
    again.close()


def test_meshes_that_are_not_there_are_logged_once(sent, tmp_path, caplog):
    rules = tmp_path / "house.cga"
    rules.write_text('Lot --> i("oak.obj") A')
    widgets = [ScoringSession(str(rules), tmp_path / "a.db", size=40, jobs=1) for _ in range(2)]
    models = first_models(widgets[0])
    for widget in widgets:
        sent.clear()
        widget._receive(widget, {"id": 1, "command": "pictures", "models": models[:2], "size": 32}, [])
        wait_until(lambda: any(message.get("event") == "pictures" for message in sent))
        wait_until(lambda widget=widget: widget.state["warnings"])
    widgets[1].close()
    (logged,) = caplog.records
    assert logged.levelname == "WARNING"
    assert 'there is no asset "oak.obj"' in logged.message
    assert widgets[0].state["warnings"] == [logged.message]


def said_by_script(tmp_path, *lines):
    """Standard error of a script that has no guard, run as a person runs it."""
    script = tmp_path / "script.py"
    script.write_text("\n".join(["import grammarlab as gl", *lines]))
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=PATIENCE
    )
    return done.stderr


@takes_turns
def test_a_script_without_a_guard_is_told_to_have_one(tmp_path):
    said = said_by_script(tmp_path, 'gl.ScoringSession("toy", "toys.db", jobs=2)')
    assert "GrammarlabError: worker processes import the script that starts them" in said
    assert 'if __name__ == "__main__":' in said
    assert said.count("Traceback") == 1
    assert not (tmp_path / "toys.db").exists()


def test_workers_of_a_script_without_a_guard_repeat_nothing_that_it_scores(tmp_path):
    score = 'session.do("score", models=session.do("state")["grids"][0]["models"][:3], score=80)'
    said = said_by_script(
        tmp_path,
        "import time",
        'session = gl.ScoringSession("toy", "toys.db", jobs=0)',
        score,
        'session.do("update")',
        'while not (message := session.do("state")["message"]): time.sleep(0.1)',
        "raise SystemExit(message)",
    )
    assert said.startswith("worker processes import the script that starts them")
    session = ScoringSession("toy", tmp_path / "toys.db", jobs=0)
    assert session.labels.scores.tolist() == [80, 80, 80]
    session.close()


def test_pages_are_of_rule_files_not_of_parsed_grammars(tmp_path):
    grammar: Any = gl.load("toy")
    for show in (gl.view, partial(ScoringSession, path=tmp_path / "toys.db")):
        with pytest.raises(UsageError, match=r"grammar: expected str or Path such as 'house\.cga', found Grammar\."):
            show(grammar)


def test_a_rule_file_in_a_notebook_is_answered_as_in_the_browser(monkeypatch, tmp_path):
    sent = []
    monkeypatch.setattr(RuleView, "send", lambda self, message, buffers=(): sent.append((message, buffers)))
    (tmp_path / "house.cga").write_text("Lot --> extrude(3) comp(f) { all : Wall }")
    with closing(RuleView(str(tmp_path / "house.cga"))) as page:
        wait_until(lambda: page.state.get("version") == 1)
        page._receive(page, {"id": "k-1", "command": "model"}, [])
        wait_until(lambda: any(message.get("id") == "k-1" for message, _ in sent))
        message, (glb,) = next(entry for entry in sent if entry[0].get("id") == "k-1")
        assert (glb[:4], [row[1] for row in message["result"]["tree"]]) == (b"glTF", ["Lot", "Wall"])
