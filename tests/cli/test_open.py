"""``grammarlab facade open``."""

import asyncio
import json
import os
import signal
import subprocess
import sys
from urllib.parse import urlsplit

import pytest
from tornado.websocket import websocket_connect

from grammarlab.facade.file import load_facade, save_facade
from tests.facade.samples import windows
from tests.signals import with_sigint
from tests.waiting import PATIENCE


def started(*arguments, cwd, command=("facade", "open")):
    """The command in a process of its own."""
    command = [sys.executable, "-c", "from grammarlab.cli import main; main()", *command, *arguments]
    return subprocess.Popen(
        with_sigint("SIG_DFL", command),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )


async def ask(address, *requests):
    """Sends requests one after the other, and returns when all have been answered."""
    parts = urlsplit(address)
    connection = await websocket_connect(f"ws://{parts.netloc}/socket?{parts.query}", connect_timeout=PATIENCE)
    for number, request in enumerate(requests):
        await connection.write_message(json.dumps({"id": number, **request}))
    answers = {}
    while len(answers) < len(requests):
        frame = await asyncio.wait_for(connection.read_message(), PATIENCE)
        assert frame is not None
        if isinstance(frame, str) and "id" in (message := json.loads(frame)):
            assert message["ok"], message
            answers[message["id"]] = message
    connection.close()
    while await connection.read_message() is not None:
        pass


@pytest.mark.parametrize("saves", [True, False])
def test_ctrl_c_ends_it_and_what_was_not_saved_is_not_lost(tmp_path, saves):
    file = save_facade(windows(2, 3), tmp_path / "wall.json")
    requests = [{"command": "resize", "width": 9.0, "height": 5.0}] + [{"command": "save"}] * saves
    with started("wall.json", "--no-browser", cwd=tmp_path) as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().strip()
            assert address.startswith("http://127.0.0.1:")
            asyncio.run(ask(address, *requests))
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=PATIENCE)
        finally:
            process.kill()
    assert process.returncode == 0
    assert "Traceback" not in said
    name = "wall.edited.facade.json" if saves else "wall.edited.unsaved.facade.json"
    assert name in said
    assert load_facade(tmp_path / name).width == pytest.approx(9.0)
    assert load_facade(file).width != pytest.approx(9.0)
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (("wall.json", "-o", "wall.png"), 2, ".json"),
        (("wall.json", "-o", "no/wall.json"), 2, "no folder"),
        (("no.json",), 2, "no.json"),
        (("broken.json",), 1, "broken.json"),
    ],
)
def test_what_cannot_be_opened_is_explained(tmp_path, arguments, code, says):
    save_facade(windows(1, 2), tmp_path / "wall.json")
    (tmp_path / "broken.json").write_text("{}")
    with started(*arguments, "--no-browser", cwd=tmp_path) as process:
        out, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == code
    assert out == ""
    assert says in said
    assert "Traceback" not in said
