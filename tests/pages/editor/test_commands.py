"""The protocol: what windows may ask for, and what strangers get."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from grammarlab.facade.file import load_facade
from grammarlab.facade.tree import check
from grammarlab.pages.editor import commands
from grammarlab.pages.editor.commands import COMMANDS
from grammarlab.pages.editor.editor import Editor
from tests.cases import bulk
from tests.pages.editor.windows import RefusedError, Window


def test_a_drag_shows_what_a_resize_then_keeps(window: Window):
    width, height = (window.state["drawing"][name] for name in ("width", "height"))
    before = window.state
    shown, (columns,) = window.ask("drag", width=1.5 * width, height=height)
    assert (shown["width"], shown["conflict"]) == (pytest.approx(1.5 * width), "")
    assert window.state == before
    window.ask("resize", width=1.5 * width, height=height)
    assert np.array_equal(window.boxes, np.frombuffer(columns, dtype="<f8").reshape(-1, 4))
    assert window.state["undo"] == f"{1.5 * width:.2f} × {height:.2f} m"
    window.ask("undo")
    assert window.state["drawing"]["width"] == width
    window.ask("redo")
    assert window.state["drawing"]["width"] == pytest.approx(1.5 * width)


def test_a_size_as_it_is_is_no_step(window: Window):
    drawing = window.state["drawing"]
    window.ask("resize", width=drawing["width"], height=drawing["height"])
    assert window.state["undo"] == ""


@pytest.mark.parametrize("width", [0, -1, math.nan, math.inf, -math.inf, 1e9, 10**400, "5", None, True, [5]])
@pytest.mark.parametrize("command", ["drag", "resize"])
def test_widths_that_are_none_are_answered_with_a_message(window: Window, command: str, width: object):
    before = window.state
    with pytest.raises(RefusedError, match=r"expected .*(number|metres|length)"):
        window.ask(command, width=width, height=5.0)
    with pytest.raises(RefusedError, match=r"expected .*(number|metres|length)"):
        window.ask("give", node=1, what="width", value=width)
    assert window.state == before


def test_wishes_that_contradict_each_other_change_nothing(window: Window):
    state = window.state
    node = state["grids"][0]["nodes"][0]
    window.ask("lock", node=node, what="width")
    (lock,) = window.state["locks"]
    assert (lock["node"], lock["what"]) == (node, "width")
    assert "m wide" in lock["words"]
    before = window.boxes
    shown, buffers = window.ask("drag", width=1.0, height=state["drawing"]["height"])
    assert shown["conflict"].startswith("These cannot all be met: the facade is 1 m wide")
    assert not buffers
    with pytest.raises(RefusedError, match="cannot all be met"):
        window.ask("resize", width=1.0, height=state["drawing"]["height"])
    assert np.array_equal(window.boxes, before)
    window.ask("unlock", node=node, what="width")
    window.ask("resize", width=1.0, height=state["drawing"]["height"])
    assert window.state["drawing"]["width"] == pytest.approx(1.0)


def test_a_part_that_is_dragged_is_kept_where_it_was_shown(window: Window):
    node = window.state["grids"][0]["nodes"][1]
    left, bottom = window.boxes[node, :2].tolist()
    shown, (columns,) = window.ask("drag", node=node, left=left + 0.1, bottom=bottom)
    assert shown["conflict"] == ""
    assert not window.state["locks"]
    window.ask("move", node=node, left=left + 0.1, bottom=bottom)
    assert np.array_equal(window.boxes, np.frombuffer(columns, dtype="<f8").reshape(-1, 4))
    assert window.boxes[node, 0] == pytest.approx(left + 0.1)
    assert [lock["what"] for lock in window.state["locks"]] == ["left", "bottom"]
    shown, buffers = window.ask("drag", node=node, left=99.0, bottom=bottom)
    assert "99 m from that of the facade" in shown["conflict"]
    assert not buffers


def test_a_range_of_aspects_holds_while_sides_are_dragged(window: Window):
    node = window.state["grids"][0]["nodes"][1]
    width, height = window.boxes[node, 2:].tolist()
    window.ask("give", node=node, what="aspect", least=0.7 * width / height, most=0.9 * width / height)
    assert [lock["range"] for lock in window.state["locks"]] == [[0.7 * width / height, 0.9 * width / height]]
    assert np.divide(*window.boxes[node, 2:]) == pytest.approx(0.9 * width / height)
    drawing = window.state["drawing"]
    for part in (0.6, 0.8, 1.3):
        shown, (columns,) = window.ask("drag", width=part * drawing["width"], height=drawing["height"])
        assert not shown["conflict"]
        aspect = np.divide(*np.frombuffer(columns, dtype="<f8").reshape(-1, 4)[node, 2:]) * height / width
        assert 0.7 - 1e-6 <= aspect <= 0.9 + 1e-6
    for least, most in ((0.0, 1.0), (2.0, 1.0), (-1.0, -0.5)):
        with pytest.raises(RefusedError, match="expected a range above 0"):
            window.ask("give", node=node, what="aspect", least=least, most=most)
    window.ask("undo")
    assert not window.state["locks"]
    assert window.boxes[node, 2:].tolist() == [width, height]


def test_of_large_facades_contradictions_are_explained_at_the_end(window: Window, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(commands, "MOST_EXPLAINED", 0)
    state = window.state
    height = state["drawing"]["height"]
    window.ask("lock", node=state["grids"][0]["nodes"][0], what="width")
    assert window.ask("drag", width=1.0, height=height)[0]["conflict"] == commands.LATER
    assert window.ask("drag", width=9.0, height=height)[0]["conflict"] == ""
    with pytest.raises(RefusedError, match="the facade is 1 m wide"):
        window.ask("resize", width=1.0, height=height)


def test_variations_are_pictures_of_what_accepting_them_gives(window: Window):
    (grid,) = window.state["grids"]
    for axis, name, change in (("x", "columns", 1), ("x", "columns", -1), ("y", "rows", 1), ("y", "rows", -1)):
        result, buffers = window.ask("vary", axis=axis, change=change)
        assert len(result["variations"]) == len(buffers) > 0
        window.ask("accept", number=0)
        (now,) = window.state["grids"]
        state, (columns, _) = window.states[-1]
        assert now[name] == grid[name] + change
        assert columns == buffers[0]
        drawing = result["variations"][0]
        assert {key: drawing[key] for key in state["drawing"]} == state["drawing"]
        window.ask("undo")


def test_variations_of_a_facade_that_has_changed_are_not_accepted(window: Window):
    with pytest.raises(RefusedError, match="has changed"):
        window.ask("accept", number=0)
    window.ask("vary", axis="x")
    window.ask("resize", width=9.0, height=5.0)
    with pytest.raises(RefusedError, match="has changed"):
        window.ask("accept", number=0)
    window.ask("undo")
    with pytest.raises(RefusedError, match="whole number"):
        window.ask("accept", number=99)
    window.ask("accept", number=0)


def test_grids_come_and_go(window: Window):
    (grid,) = window.state["grids"]
    left, bottom, width, height = window.boxes[grid["nodes"][0]].tolist()
    around = {"left": left - 0.1, "bottom": bottom - 0.1, "right": left + width + 0.1, "top": bottom + height + 0.1}
    name = window.ask("lasso", **around)[0]["grid"]
    assert window.state["active"] == name
    window.ask("press", node=grid["nodes"][1])
    assert window.state["grids"][1]["nodes"] == grid["nodes"][:2]
    window.ask("rename", grid=name, to="mine")
    assert window.state["active"] == "mine"
    window.ask("choose", grid=grid["name"])
    assert window.state["active"] == grid["name"]
    window.ask("delete", grid="mine")
    window.ask("delete", grid=grid["name"])
    assert window.state["active"] == ""
    for command, values in (("press", {"node": 1}), ("vary", {"axis": "x"})):
        with pytest.raises(RefusedError, match="There is no grid"):
            window.ask(command, **values)
    window.ask("propose")
    assert [each["name"] for each in window.state["grids"]] == ["window"]


def test_what_was_saved_is_on_disk_and_said_to_be(window: Window, editor: Editor):
    assert not window.state["lost"]
    window.ask("resize", width=9.0, height=5.0)
    assert window.state["lost"]
    assert not editor.desk.target.exists()
    assert window.ask("save")[0]["file"] == str(editor.desk.target)
    assert (window.state["saved"], window.state["lost"]) == (True, False)
    assert load_facade(editor.desk.target).width == pytest.approx(9.0)
    window.ask("undo")
    assert not window.state["saved"]


@pytest.mark.parametrize("kind", ["json", "svg", "png", "glb", "obj", "cga"])
def test_exports_lie_beside_the_target_and_replace_only_earlier_exports(window: Window, editor: Editor, kind: str):
    suffix = ".facade.json" if kind == "json" else f".{kind}"
    mine = editor.desk.target.with_name(f"edited{suffix}")
    mine.write_text("mine")
    path = Path(window.ask("export", format=kind)[0]["file"])
    assert path == mine.with_name(f"edited-2{suffix}")
    first = path.read_bytes()
    window.ask("resize", width=9.0, height=5.0)
    assert window.ask("export", format=kind)[0]["file"] == str(path)
    assert path.read_bytes() != first
    assert mine.read_text() == "mine"


VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**20), 10**20),
    st.floats(),
    st.text(max_size=5),
    st.sampled_from(["x", "width", "window", "json", ""]),
    st.lists(st.integers(), max_size=2),
)
NAMES = [
    "width",
    "height",
    "node",
    "what",
    "value",
    "bottom",
    "grid",
    "to",
    "axis",
    "change",
    "most",
    "number",
    "left",
    "top",
]


@bulk(150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(command=st.sampled_from([*COMMANDS, "no", 7, None]), values=st.dictionaries(st.sampled_from(NAMES), VALUES))
def test_whatever_a_stranger_asks_is_answered_and_the_facade_stays_one(
    window: Window, editor: Editor, command: object, values: dict[str, object]
):
    message, _ = window.begin(command, **values).result()
    assert message["ok"] or (message["error"] and "unexpected" not in message["error"])
    check(editor.desk.document.facade)
