"""The protocol of the page of a design: what windows may ask for, and what strangers get."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from grammarlab.errors import LanguageError, UsageError
from grammarlab.facade.file import load_facade
from grammarlab.layers.file import parse_design
from grammarlab.pages.layers.commands import COMMANDS
from grammarlab.pages.layers.designer import PAGE, Designer
from grammarlab.pages.layers.solver import Job, Solver, SolverOutcome
from grammarlab.runs.facade.layer_files import solve_design
from tests.layers.samples import RESIDENTIAL, residential
from tests.pages.editor.windows import RefusedError, Window
from tests.runs.facade.served import served
from tests.waiting import PATIENCE


@pytest.fixture
def designer(tmp_path: Path) -> Iterator[Designer]:
    (tmp_path / "house.toml").write_text(RESIDENTIAL, encoding="utf-8")
    running = Designer(tmp_path / "house.toml", tmp_path / "mine.toml")
    yield running
    running.close()


@pytest.fixture
def window(designer: Designer) -> Window:
    found = Window(designer)
    settled(found)
    return found


def settled(window: Window) -> dict[str, Any]:
    """The state once nothing better may come."""
    return until(lambda: window.state, lambda state: not state["solving"])


def until(look: Callable[[], Any], holds: Callable[[Any], bool]) -> Any:
    end = time.monotonic() + PATIENCE
    while not holds(found := look()):
        assert time.monotonic() < end, found
        time.sleep(0.01)
    return found


def counters(state: dict[str, Any]) -> dict[str, int]:
    return state["layouts"][state["chosen"]]["counters"]


def test_layouts_are_those_of_the_command_and_a_drag_leads_to_those_of_its_end(window: Window):
    state = settled(window)
    for width in (state["width"], 7.5):
        answer = until(
            lambda w=width: window.ask("drag", width=w, height=4.5)[0], lambda each: each["layouts"][0]["proven"]
        )
        best = solve_design(residential(), width, 4.5)[0]
        assert answer["layouts"][answer["chosen"]]["counters"] == dict(best.layout.candidate.counters)
        assert answer["layouts"][0]["energy"] == pytest.approx(best.layout.energy)
        assert answer["layouts"][0]["width"] == pytest.approx(width)
    assert settled(window)["text"] == RESIDENTIAL
    window.ask("resize", width=7.5, height=4.5)
    state = settled(window)
    assert parse_design(state["text"]).width == 7.5
    expected = solve_design(residential(), 7.5, 4.5, 5)
    assert [each["energy"] for each in state["layouts"]] == pytest.approx([each.layout.energy for each in expected])
    window.ask("undo")
    assert settled(window)["text"] == RESIDENTIAL
    assert counters(settled(window)) == {"k": 2}


def test_a_size_that_cannot_be_met_is_explained_and_changes_nothing(window: Window):
    before = window.state
    with pytest.raises(RefusedError, match=r"no word fits: Cx = 'cec; c := C' over 0\.5 m"):
        window.ask("resize", width=0.5, height=4.5)
    answer, buffers = window.ask("drag", width=0.5, height=4.5)
    assert "no word fits" in answer["conflict"]
    assert (answer["layouts"], buffers) == ([], ())
    assert window.state == before


def test_layers_masks_and_flags_are_switched_in_the_text(window: Window):
    window.ask("switch", layer=1, on=False)
    state = settled(window)
    assert "door" not in state["layouts"][0]["labels"]
    assert [each["on"] for each in state["layers"]] == [True, False, True, True]
    window.ask("mask", layer=2, axis="y", symbol="Q", seen=True)
    assert settled(window)["layers"][2]["axes"][1]["seen"] is None
    window.ask("flag", symbol="B", flag="attached", value=True)
    design = parse_design(settled(window)["text"])
    assert design.symbols["B"].attached
    assert (design.layers[1].on, design.layers[2].masks) == (False, (None, None))
    for _ in range(3):
        window.ask("undo")
    assert settled(window)["text"] == RESIDENTIAL
    assert window.state["redo"] == "switch door"


def test_a_chosen_layout_stays_chosen_while_the_canvas_changes(window: Window):
    assert window.state["chosen"] == 0
    window.ask("choose", number=1)
    chosen = counters(window.state)
    answer, _ = window.ask("drag", width=6.1, height=4.5)
    assert answer["layouts"][answer["chosen"]]["counters"] == chosen
    window.ask("resize", width=6.1, height=4.5)
    assert counters(settled(window)) == chosen
    with pytest.raises(RefusedError, match="out of date"):
        window.ask("choose", number=99)


def test_mistakes_in_the_text_are_told_with_their_place_and_the_last_good_layouts_stay(window: Window):
    before, wrong = window.state, RESIDENTIAL.replace("A(BA)^k", "A(BX)^k")
    window.ask("edit", text=wrong)
    state = window.state
    (mistake,) = state["mistakes"]
    line = RESIDENTIAL.splitlines().index('Bx = "A(BA)^k"') + 1
    assert (mistake["line"], mistake["column"]) == (line, 10)
    assert mistake["shown"].splitlines()[1].index("^") == len('  Bx = "A(B')
    assert (state["text"], state["layouts"], state["lost"]) == (wrong, before["layouts"], True)
    with pytest.raises(RefusedError, match="Correct the text"):
        window.ask("save")
    window.ask("edit", text=RESIDENTIAL.replace("A(BA)^k", "A(BA)^{k + 1}"))
    assert counters(settled(window)) == {"k": 1}
    assert not window.state["mistakes"]
    window.ask("undo")  # all of the typing
    assert settled(window)["text"] == RESIDENTIAL


def test_a_design_without_layouts_is_explained_and_the_last_good_ones_stay(window: Window):
    before = window.state
    window.ask("edit", text=RESIDENTIAL.replace('"cec; c := C"', '"CCCCCCCCCCCCCCCCCCCC"'))
    state = settled(window)
    assert "no word fits: Cx" in state["conflict"]
    assert state["layouts"] == before["layouts"]
    window.ask("undo")
    assert settled(window)["conflict"] == ""


def test_what_is_saved_opens_again_and_exports_are_what_is_shown(designer: Designer, window: Window, tmp_path: Path):
    window.ask("choose", number=1)
    window.ask("resize", width=6.5, height=4.5)
    settled(window)
    assert designer.desk.is_lost
    rescued = designer.desk.rescue()
    window.ask("save")
    assert window.state["saved"]
    assert (tmp_path / "mine.toml").read_text() == rescued.read_text() == window.state["text"]
    assert (tmp_path / "house.toml").read_text() == RESIDENTIAL
    with closing(Designer(tmp_path / "mine.toml", tmp_path / "mine.toml")) as again:
        other = Window(again)
        assert settled(other)["width"] == 6.5
        assert other.state["saved"]
    written = {kind: Path(window.ask("export", format=kind)[0]["file"]) for kind in window.state["formats"]}
    assert all(path.stat().st_size > 100 for path in written.values())
    facade = load_facade(written["json"])
    assert facade.width == pytest.approx(6.5)
    assert len(facade.leaves) == len(window.state["layouts"][window.state["chosen"]]["label"])
    with pytest.raises(UsageError, match=r"ends in \.toml"):
        Designer(tmp_path / "house.toml", tmp_path / "mine.json")
    (tmp_path / "bad.toml").write_text("canvas = 3")
    with pytest.raises(LanguageError, match="expected a table"):
        Designer(tmp_path / "bad.toml")


NONSENSE: list[Any] = [0, -1, math.nan, math.inf, 1e9, 10**400, "5", None, True, [5], {}]


def test_strangers_get_a_message_and_change_nothing(window: Window):
    before = window.state
    names = ("width", "height", "layer", "axis", "symbol", "flag", "text", "number", "format", "on", "seen", "value")
    for command in sorted({*COMMANDS, "nothing"} - {"skip", "undo", "redo", "save"}):
        for value in NONSENSE:
            if [command, value] not in [["choose", 0], ["edit", "5"]]:
                with pytest.raises(RefusedError, match="expected"):
                    window.ask(command, **dict.fromkeys(names, value))
    assert window.state == before


def test_of_what_is_wished_for_the_latest_is_solved():
    begun, goes_on, found = Event(), Event(), list[SolverOutcome]()

    def done(outcome: SolverOutcome) -> None:
        found.append(outcome)
        begun.set()
        goes_on.wait(PATIENCE)

    solver = Solver(done)
    solver.submit(Job(residential(), 6.0, 4.5, (1, 5)))
    begun.wait(PATIENCE)
    for width in (7.0, 8.0, 0.5, 9.0):
        solver.submit(Job(residential(), width, 4.5, (1,)))
    goes_on.set()
    until(lambda: len(found), lambda number: number == 2)
    assert [(each.job.width, each.count) for each in found] == [(6.0, 1), (9.0, 1)]
    solver.close()


async def visit(designer: Designer) -> None:
    async with served(designer, PAGE) as page:
        window = await page.connect()
        await window.hear(lambda message: message.get("event") == "state")
        await window.send({"id": 1, "command": "skip"})
        await window.hear(lambda message: message.get("id") == 1)


def test_the_page_is_served_to_those_who_know_its_address(designer: Designer):
    asyncio.run(visit(designer))
