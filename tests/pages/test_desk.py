"""Corrections of an example as a window asks for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from grammarlab.errors import FacadeError
from grammarlab.pages.example_commands import COMMANDS, state_of
from grammarlab.pages.example_desk import ExampleDesk
from grammarlab.pages.requests import run_request
from tests.synthesis.houses import house


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory) -> ExampleDesk:
    folder = tmp_path_factory.mktemp("desk")
    return ExampleDesk.open(house(3, 2, 1, door=1).write(folder / "house.obj"), folder / "example.json")


@pytest.fixture
def desk(analysed: ExampleDesk, tmp_path: Path) -> ExampleDesk:
    return ExampleDesk(analysed.file, tmp_path / "example.json", analysed.analysis)


def ask(desk: ExampleDesk, **message: Any) -> dict[str, Any]:
    answers: list[Any] = []
    run_request(COMMANDS, desk, {"id": 1, **message}, (), lambda answer, _: answers.append(answer))
    return answers[0]


def test_a_split_that_is_joined_again_is_undone_and_every_step_is_an_example(desk: ExampleDesk) -> None:
    wall: Any = {"wall": "front"}
    first = state_of(desk)[0]["state"]["walls"][0]
    for axis, line in (("rows", 1), ("columns", 2)):
        lines = first[axis]
        assert ask(desk, command="split", axis=axis, at=(lines[line - 1] + lines[line]) / 2, **wall)["ok"]
        assert desk.example.main.grid.labels.size > 6  # one row, or one column, more
        assert ask(desk, command="join", axis=axis, line=line, **wall)["ok"]
        assert desk.document == desk.first
    for _ in range(4):
        assert ask(desk, command="undo")["result"]["words"]
    assert ask(desk, command="undo")["result"]["words"] == ""
    assert desk.document is desk.first
    assert desk.is_lost is False


@pytest.mark.parametrize(
    ("message", "told"),
    [
        ({"command": "move", "wall": "front", "axis": "rows", "line": 0, "at": 1e9}, "at least 0.05 m apart"),
        ({"command": "move", "wall": "front", "axis": "rows", "line": 0, "at": float("nan")}, "number"),
        ({"command": "move", "wall": "front", "axis": "depth", "line": 0, "at": 0.0}, "rows or columns"),
        ({"command": "move", "wall": "front", "axis": "rows", "line": 9, "at": 0.0}, "0 to 2"),
        ({"command": "relabel", "wall": "front", "last_row": 2, "label": "x"}, "2 rows and 3 columns"),
        ({"command": "relabel", "wall": "roof", "label": "x"}, "front"),
        ({"command": "merge", "wall": "front", "label": "portal", "into": "door"}, "portal"),
        ({"command": "split", "wall": "front", "axis": "rows", "at": 1e6}, "between"),
        ({"command": "exclude", "wall": "front"}, "main wall"),
        ({"command": "include", "wall": "front"}, "unknown excluded wall"),
        ({"command": "picture", "wall": "roof"}, "unknown wall"),
        ({"command": "synthesize", "rows": 0, "columns": 3}, "rows"),
        ({"command": "nothing"}, "command"),
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(desk: ExampleDesk, message: dict[str, Any], told: str) -> None:
    answer = ask(desk, **message)
    assert not answer["ok"]
    assert told in answer["error"]
    assert desk.document is desk.first


def test_what_is_saved_is_read_again_and_a_file_of_another_example_is_refused(desk: ExampleDesk) -> None:
    ask(desk, command="relabel", wall="front", row=1, column=0, last_row=1, last_column=2, label="attic")
    ask(desk, command="exclude", wall="left")
    assert desk.is_lost
    ask(desk, command="save")
    again = ExampleDesk.open(desk.file, desk.target)
    assert again.document == desk.document
    assert again.is_saved
    ask(again, command="include", wall="left")
    assert [wall["name"] for wall in again.document["walls"]] == [region.name for region in again.analysis.regions]
    desk.target.write_text('{"format": "grammarlab example", "version": 1, "walls": []}')
    with pytest.raises(FacadeError, match="main wall"):
        ExampleDesk.open(desk.file, desk.target)
