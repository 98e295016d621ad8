"""``grammarlab score``."""

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import urllib.request
from contextlib import closing
from urllib.parse import urlsplit

import pytest
from tornado.websocket import websocket_connect

from grammarlab.cli.sample import choices_of
from grammarlab.errors import LanguageError
from grammarlab.language.grammar import Grammar
from grammarlab.language.presets import RuleChoices
from grammarlab.pages.scoring.session import Session
from tests.cases import takes_turns
from tests.signals import with_sigint
from tests.waiting import PATIENCE

RULES = 'Lot --> 50% : extrude(3) color("#ff0000") Low else : extrude(9) High'


@pytest.fixture
def house(rules):
    return rules(RULES)


def served(*arguments):
    """The command in a process of its own."""
    command = [sys.executable, "-c", "from grammarlab.cli import main; main()", "score", *arguments]
    return subprocess.Popen(
        with_sigint("SIG_DFL", command),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )


@pytest.mark.parametrize("kill", [signal.SIGINT, signal.SIGKILL])
def test_the_page_is_there_and_ctrl_c_ends_it_cleanly(house, tmp_path, kill):
    with served(house, "--session", tmp_path / "a.db", "--no-browser") as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().strip()
            assert address.startswith("http://127.0.0.1:")
            with urllib.request.urlopen(address, timeout=PATIENCE) as response:  # noqa: S310 - just checked
                assert b"page.js?token=" in response.read()
            process.send_signal(kill)
            _, said = process.communicate(timeout=PATIENCE)
        finally:
            process.kill()  # a process that goes on would be waited for without end
    assert process.returncode == (0 if kill == signal.SIGINT else -signal.SIGKILL)
    assert "Traceback" not in said
    assert "a.db" in said
    with closing(Session(str(house), tmp_path / "a.db", jobs=0)) as session:
        assert len(session.call("state")[0]["models"]) == 32


async def see_pictures(address):
    """Asks for pictures of the models that a page would show first, waits for them, and gives the warnings so far."""
    place = urlsplit(address)
    connection = await websocket_connect(f"ws://{place.netloc}/socket?{place.query}", connect_timeout=PATIENCE)
    missing, warnings = None, []
    while missing is None or missing:
        message = await connection.read_message()
        assert message is not None
        said = json.loads(message) if isinstance(message, str) else {}
        warnings = said["state"]["warnings"] if said.get("event") == "state" else warnings
        if said.get("event") == "state" and missing is None:
            missing = {model for grid in said["state"]["grids"] for model in grid["models"]}
            await connection.write_message(
                json.dumps({"id": 2, "command": "pictures", "models": [*missing], "size": 32})
            )
        elif missing is not None:
            missing -= set(said.get("models", ()))
    connection.close()
    while await connection.read_message() is not None:
        pass
    return warnings


@takes_turns
def test_meshes_that_are_not_there_are_told_once(rules, tmp_path):
    path = rules('Lot --> extrude(3) comp(f) { top : i("oak.obj") A | side : i("win" + "dow.glb") i("oak.obj") B }')
    with served(path, "--session", tmp_path / "a.db", "--no-browser") as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().strip()
            *_, warnings = [asyncio.run(see_pictures(address)) for _ in range(2)]
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=PATIENCE)
        finally:
            process.kill()
    for name in ("oak.obj", "window.glb"):
        assert said.count(f'there is no asset "{name}" in the asset folder {tmp_path}; a box stands in its place') == 1
    assert said.count("--assets DIR") == 1
    # The page of the command names its options, too.
    assert [warning.partition("hint: ")[2] for warning in warnings] == 2 * [
        "say where the meshes are with --assets DIR"
    ]


def test_a_port_in_use_is_told(run, house, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        result = run("score", house, "--session", tmp_path / "a.db", "--no-browser", "--port", port, code=2)
    assert f"port {port} cannot be used" in result.stderr


def test_what_is_wrong_with_arguments_is_told(run, house, rules, tmp_path):
    session = ("--session", tmp_path / "a.db", "--no-browser")
    assert "no rule file or species 'missing.cga'" in run("score", "missing.cga", *session, code=2).stderr
    assert "ends in .db" in run("score", house, "--session", tmp_path / "a.csv", code=2).stderr
    assert "no folder" in run("score", house, "--session", tmp_path / "no" / "a.db", code=2).stderr
    assert "a folder or a device" in run("score", house, "--session", folder(tmp_path / "b.db"), code=1).stderr
    assert "seed is" in run("score", house, *session, "--seed", 1 << 64, code=2).stderr
    assert "house.cga:1" in run("score", rules("Lot --> nonsense("), *session, code=1).stderr
    (tmp_path / "c.db").write_bytes(b"scores" * 1000)
    assert "not a session file" in run("score", rules(RULES), "--session", tmp_path / "c.db", code=1).stderr


def folder(path):
    path.mkdir()
    return path


def test_a_changed_grammar_is_refused(run, house, rules, tmp_path):
    Session(str(house), tmp_path / "a.db", jobs=0).close()
    rules(RULES.replace("9", "12"))
    assert "--stored-grammar" in run("score", house, "--session", tmp_path / "a.db", code=2).stderr


def test_choices_need_no_valid_rules_unless_they_have_values_and_read_them_once(rules, monkeypatch, capsys):
    broken = str(rules("// important\nLot --> nonsense( import"))
    assert choices_of(broken, "Lot", None, "", None) == RuleChoices(start_rule="Lot")
    with pytest.raises(LanguageError):
        choices_of(broken, "", ["h=2"], "", None)
    path = str(rules('import Tree : "absent.cga"\nattr h = 1 Lot --> Tree.A'))
    parsed = []
    parse = Grammar.parse
    monkeypatch.setattr(Grammar, "parse", lambda text, *file: parsed.append(text) or parse(text, *file))
    assert choices_of(path, "", ["h=2"], "", None).attributes == {"h": 2.0}
    assert len(parsed) == 2  # to merge the imports, and to read the merged text
    assert "absent.cga" in capsys.readouterr().err


def test_a_session_is_learned_from_like_a_label_file(run, house, tmp_path):
    with closing(Session(str(house), tmp_path / "a.db", seed=4, size=200, jobs=0)) as session:
        models = list(session.call("state")[0]["models"])
        for index, model in enumerate(models):
            session.call("score", models=[model], score=100 * (index % 2))
        session.call("score", models=models, score=100)
    out = tmp_path / "liked.cga"
    result = run("learn", house, "--labels", tmp_path / "a.db", "-o", out, "--json")
    assert json.loads(result.stdout)["labels"] == 32
    assert out.is_file()
    (tmp_path / "broken.db").write_bytes(b"x" * 100)
    assert "not a session file" in run("learn", house, "--labels", tmp_path / "broken.db", code=1).stderr
    assert "no such session" in run("learn", house, "--labels", tmp_path / "missing.db", code=1).stderr
