"""The thread of a page: who hears of what, whatever windows and desks do."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from threading import Event

import pytest

from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.pages.desk import DESK_COMMANDS, AbstractDocumentDesk, Exports
from grammarlab.pages.desktop import CLOSED, DeskHooks, Desktop, StateEvent
from grammarlab.pages.editor.commands import COMMANDS as EDITOR_COMMANDS
from grammarlab.pages.example_commands import COMMANDS as EXAMPLE_COMMANDS
from grammarlab.pages.layers.commands import COMMANDS as LAYERS_COMMANDS
from grammarlab.pages.matcher import COMMANDS as SCAN_COMMANDS
from grammarlab.pages.requests import Request
from grammarlab.pages.scoring.commands import COMMANDS as SCORING_COMMANDS
from grammarlab.pages.windows import Message
from tests.pages.scoring.windows import BrokenWindow
from tests.waiting import PATIENCE


class NumberDesk(AbstractDocumentDesk[int]):
    """A number, at least 0."""

    def accept(self, document: int) -> None:
        if document < 0:
            raise UsageError("number: expected at least 0.")

    def follow(self, previous: int) -> None:
        self.previous = previous

    def write(self, path: Path, document: int, *, is_new: bool) -> None:
        assert not (is_new and path.exists())
        path.write_text(str(document))


def put(desk: NumberDesk, request: Request) -> Message:
    desk.do("put", request.integer("number", -10, 10, 0))
    return desk.done()


def nothing_of_json(_desk: NumberDesk, _request: Request) -> Message:
    return {"number": math.nan}


def fail(*_: object) -> None:
    raise RuntimeError("a bug")


def state_of(desk: NumberDesk) -> StateEvent:
    return {"event": "state", "state": {**desk.summary(), "number": desk.document}}, ()


COMMANDS = {**DESK_COMMANDS, "put": put, "nan": nothing_of_json}


@pytest.fixture
def desktop(tmp_path: Path) -> Iterator[Desktop[NumberDesk]]:
    def write(path: Path) -> None:
        path.write_text(f"number {desk.document}")

    desk = NumberDesk(tmp_path / "number.json", 0, exports=Exports({"txt": ".txt"}, write))
    with closing(Desktop(lambda _: desk, COMMANDS, state_of)) as desktop:
        yield desktop


class Ear:
    """Hears states."""

    def __init__(self) -> None:
        self.numbers: list[int] = []

    def send(self, message: Message, _buffers: Sequence[bytes]) -> None:
        if message.get("event") == "state":
            self.numbers.append(message["state"]["number"])


@pytest.mark.parametrize("answers", range(4))
def test_windows_hear_of_everything_whenever_another_fails(desktop: Desktop[NumberDesk], answers: int):
    first, broken, last = Ear(), BrokenWindow(answers), Ear()
    for window in (first, broken, last):
        desktop.listen(window.send)
    for number in (1, 2, 3):
        desktop.handle({"id": number, "command": "put", "number": number}, (), broken.send)
    desktop.call("skip")
    assert first.numbers == last.numbers == [0, 1, 2, 3]


def test_a_result_that_no_window_can_get_is_refused(desktop: Desktop[NumberDesk]):
    answers = []

    def send(message: Message, _buffers: Sequence[bytes]) -> None:
        answers.append(json.loads(json.dumps(message, allow_nan=False)))

    desktop.listen(send)
    desktop.handle({"id": 5, "command": "nan"}, (), send)
    desktop.call("put", number=1)
    (refusal,) = [message for message in answers if "id" in message]
    assert refusal["id"] == 5
    assert "unexpected ValueError" in refusal["error"]
    assert answers[-1]["state"]["number"] == 1  # the window still hears


def test_bugs_of_a_desk_do_not_end_the_thread(tmp_path: Path):
    polled = Event()

    def poll(_desk: NumberDesk) -> None:
        polled.set()
        raise RuntimeError("a bug")

    hooks = DeskHooks[NumberDesk](idle=fail, poll=poll, poll_seconds=0.01, close=fail)
    desk = NumberDesk(tmp_path / "number.json", 0)
    with closing(Desktop(lambda _: desk, COMMANDS, state_of, hooks)) as desktop:
        desktop.listen(Ear().send)
        desktop.post(fail)
        assert polled.wait(PATIENCE)
        assert desktop.call("put", number=4)[0] == {"revision": 1}


def test_a_closed_page_tells_its_windows_and_answers_that_it_is_closed(desktop: Desktop[NumberDesk]):
    broken, heard = BrokenWindow(1), list[Message]()
    desktop.listen(broken.send)
    desktop.listen(lambda message, _: heard.append(message))
    desktop.close()
    assert heard[-1] == {"event": "closed", "message": CLOSED}
    with pytest.raises(GrammarlabError, match="has been closed"):
        desktop.call("put", number=4)


def test_steps_saves_exports_and_rescues_of_a_document(desktop: Desktop[NumberDesk], tmp_path: Path):
    desk, target = desktop.desk, tmp_path / "number.json"
    for number in (3, 4, 4):  # a step that changes nothing is none
        desktop.call("put", number=number)
    assert desk.is_lost
    assert desktop.call("undo")[0] == {"words": "put", "revision": 4}
    with pytest.raises(GrammarlabError, match="at least 0"):
        desktop.call("put", number=-1)
    assert desktop.call("redo")[0]["words"] == "put"
    assert desktop.call("redo")[0]["words"] == ""
    assert [desk.rescue().name for _ in range(2)] == ["number.unsaved.json", "number-2.unsaved.json"]
    assert desktop.call("save")[0]["file"] == str(target)
    assert (target.read_text(), desk.is_saved, desk.is_lost) == ("4", True, False)
    desktop.call("undo")
    assert (desk.is_saved, desk.is_lost) == (False, True)
    desktop.call("undo")
    assert not desk.is_lost  # the number of the beginning
    (tmp_path / "number.txt").write_text("of another program")
    for number in (5, 6):
        desktop.call("put", number=number)
        assert desktop.call("export", format="txt")[0] == {"file": str(tmp_path / "number-2.txt")}
        assert (tmp_path / "number-2.txt").read_text() == f"number {number}"
    with pytest.raises(GrammarlabError, match="format: expected one of txt, found 'exe'"):
        desktop.call("export", format="exe")


@pytest.mark.parametrize(
    "commands", [EDITOR_COMMANDS, EXAMPLE_COMMANDS, LAYERS_COMMANDS, SCAN_COMMANDS, SCORING_COMMANDS]
)
def test_all_pages_have_the_commands_of_all_pages(commands: dict[str, object]):
    assert commands.items() >= DESK_COMMANDS.items()
