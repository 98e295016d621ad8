"""One thread, many windows, files."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path
from threading import Event

import pytest

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.file import load_facade, load_locked, save_facade
from grammarlab.pages.editor import editor as module
from grammarlab.pages.editor.editor import Editor
from tests.facade.samples import built, leaf, windows
from tests.pages.editor.windows import Window
from tests.pages.scoring.windows import BrokenWindow


def test_of_sizes_on_the_way_only_the_latest_is_solved_for(editor: Editor, window: Window):
    height, goes_on = window.state["drawing"]["height"], Event()

    def wait(*_: object) -> None:
        goes_on.wait()

    leave = editor.listen(wait)  # the editor's thread rests here
    waiting = [window.begin("drag", width=5.0 + number / 10, height=height) for number in range(30)]
    other = Window(editor)
    last = other.begin("drag", width=9.0, height=height)
    goes_on.set()
    answers = [each.result() for each in waiting]
    assert [message["result"].get("skipped", False) for message, _ in answers] == [True] * 29 + [False]
    assert answers[-1][0]["result"]["width"] == pytest.approx(7.9)
    assert last.result()[0]["result"]["width"] == pytest.approx(9.0)
    leave()


def test_all_windows_see_what_one_does(editor: Editor, window: Window):
    other = Window(editor)
    window.ask("resize", width=9.0, height=5.0)
    assert other.state == window.state
    other.close()
    window.ask("undo")
    assert len(other.states) < len(window.states) + 1
    assert other.states[-1][0] != window.state


def test_a_window_that_fails_keeps_no_other_from_hearing(editor: Editor):
    broken = BrokenWindow(answers=2)
    editor.listen(broken.send)
    window = Window(editor)
    height = window.state["drawing"]["height"]
    for number in range(3):
        editor.handle({"id": number, "command": "resize", "width": 8.0 + number, "height": height}, (), broken.send)
    assert window.state["drawing"]["width"] == pytest.approx(10.0)
    window.ask("undo")
    assert window.state["drawing"]["width"] == pytest.approx(9.0)
    assert "state" not in [message.get("event") for message in broken.heard[3:]]


def test_without_an_output_a_new_file_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    file = save_facade(windows(1, 2), tmp_path / "in" / "house.facade.json")
    for name in ("house.edited.facade.json", "house.edited-2.facade.json"):
        with closing(Editor(file)) as running:
            window = Window(running)
            window.ask("resize", width=9.0, height=5.0)
            window.ask("save")
        assert load_facade(tmp_path / name).width == pytest.approx(9.0)
    assert load_facade(file).width != pytest.approx(9.0)


def test_the_file_itself_is_saved_to_when_it_is_the_output(tmp_path: Path):
    file = save_facade(windows(1, 2), tmp_path / "house.json")
    with closing(Editor(file, file)) as running:
        window = Window(running)
        assert window.state["saved"]
        window.ask("resize", width=9.0, height=5.0)
        assert load_facade(file).width != pytest.approx(9.0)
        window.ask("save")
    assert load_facade(file).width == pytest.approx(9.0)


def test_locks_survive_in_the_file(tmp_path: Path):
    facade = windows(1, 2)
    node, file = int(facade.leaves[2]), save_facade(facade, tmp_path / "house.facade.json")
    for name in ("one", "two"):
        with closing(Editor(file, tmp_path / f"{name}.json")) as running:
            window = Window(running)
            if name == "one":
                window.ask("lock", node=node, what="width")
                window.ask("lock", node=node, what="aspect")
            assert [lock["what"] for lock in window.state["locks"]] == ["width", "aspect"]
            window.ask("resize", width=9.0, height=5.0)
            window.ask("save")
        file = tmp_path / f"{name}.json"
        facade, locks = load_locked(file)
        assert {lock.node for lock in locks} == {node}
        assert facade.size[node, 0] == pytest.approx(1.0)


def test_what_was_not_saved_is_rescued_under_a_new_name(editor: Editor, window: Window):
    assert not editor.desk.is_lost
    window.ask("resize", width=9.0, height=5.0)
    assert window.state["lost"]
    assert editor.desk.is_lost
    paths = [editor.desk.rescue(), editor.desk.rescue()]
    assert [path.name for path in paths] == ["edited.unsaved.facade.json", "edited-2.unsaved.facade.json"]
    assert load_facade(paths[1]).width == pytest.approx(9.0)


def test_outputs_that_are_none_are_refused(tmp_path: Path):
    file = save_facade(windows(1, 2), tmp_path / "house.json")
    for output in (tmp_path / "house.png", tmp_path / "no" / "house.json"):
        with pytest.raises(UsageError, match=r"expected the name|no folder"):
            Editor(file, output)


def test_what_is_too_large_for_hands_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "MOST_LEAVES", 5)
    with pytest.raises(FacadeError, match="at most 5 on the page"):
        Editor(save_facade(windows(2, 3), tmp_path / "house.json"))


def test_a_facade_of_one_leaf_can_be_resized_and_has_no_grid(tmp_path: Path):
    facade = built(leaf("wall", 3.0, 2.0))
    with closing(Editor(save_facade(replace(facade), tmp_path / "one.json"), tmp_path / "two.json")) as running:
        window = Window(running)
        assert (window.state["active"], window.state["grids"]) == ("", [])
        window.ask("resize", width=4.0, height=1.0)
        assert window.boxes.tolist() == [[0.0, 0.0, 4.0, 1.0]]
        window.ask("save")
        window.ask("export", format="cga")
