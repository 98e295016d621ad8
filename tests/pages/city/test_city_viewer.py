"""A city on its page: choices are on disk before they are answered, and what they concern is built again."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from grammarlab.city.parcel_addresses import EXCLUDED, Pin, read_pins
from grammarlab.city.plan import read_plan
from grammarlab.errors import AssetError, GrammarlabError
from grammarlab.pages.city.city_viewer import CityViewer
from grammarlab.pages.record.store import Store
from grammarlab.pages.windows import Message
from tests.pages.city.small_city import write_city
from tests.waiting import wait_until

REBUILD = "tests.pages.city.small_city:rebuild"
SCORE_AND_DIE = """
import os, signal
from pathlib import Path
from grammarlab.pages.city.city_viewer import CityViewer
if __name__ == "__main__":
    CityViewer(Path({folder!r})).call("score", parcel="P-004", score=75, kind="stars")
    os.kill(os.getpid(), signal.SIGKILL)
"""


@dataclass(eq=False)
class Window:
    """What a window hears."""

    states: list[Message] = field(default_factory=list)

    def __call__(self, message: Message, _buffers: Sequence[bytes]) -> None:
        if message.get("event") == "state":
            self.states.append(message["state"])

    @property
    def state(self) -> Message:
        return self.states[-1]

    def wait(self, holds: Callable[[Message], object]) -> Message:
        """The first state, from the last one on, that fulfils a condition."""
        wait_until(lambda: self.states and holds(self.state), lambda: self.states[-1:])
        return self.state


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_city(tmp_path / "city")
    return tmp_path / "city"


@pytest.fixture
def opened(folder: Path) -> Iterator[Callable[[], tuple[CityViewer, Window]]]:
    viewers: list[CityViewer] = []

    def open_city() -> tuple[CityViewer, Window]:
        viewers.append(CityViewer(folder, rebuild=REBUILD))
        window = Window()
        viewers[-1].listen(window)
        window.wait(bool)
        return viewers[-1], window

    yield open_city
    for viewer in viewers:
        viewer.close()


def fact(viewer: CityViewer, parcel: str, name: str) -> Any:
    return dict(viewer.call("parcel", parcel=parcel)[0]["facts"])[name]


def test_what_is_known_of_a_parcel_is_that_of_the_table(opened):
    viewer, window = opened()
    known = viewer.call("parcel", parcel="P-003")[0]
    facts = dict(known["facts"])
    assert (known["status"], known["zone"], known["pin"]) == ("built", "offices", "free")
    assert (facts["seed"], facts["rules"], facts["area"]) == ("7", "toy (000000000000)", "256 m²")
    assert viewer.call("parcel", parcel="P-023")[0]["status"] == "empty"
    assert (window.state["built"], window.state["empty"]) == (23, {"small": 1})
    with pytest.raises(GrammarlabError, match="no parcel 'nothing'"):
        viewer.call("parcel", parcel="nothing")
    with pytest.raises(GrammarlabError, match="has no building"):
        viewer.call("reroll", parcel="P-023")


def test_choices_are_saved_and_built_and_undone(opened, tmp_path: Path):
    viewer, window = opened()
    model = fact(viewer, "P-003", "model")
    viewer.call("reroll", parcel="P-003")
    assert read_pins(tmp_path / "pins.csv").rows == (Pin("P-003", reroll=1),)
    window.wait(lambda state: state["tiles"] == 1 and not state["busy"])
    assert fact(viewer, "P-003", "model") != model
    viewer.call("exclude", parcel="P-004")
    viewer.call("pin", parcel="P-005")
    pins = read_pins(tmp_path / "pins.csv")
    assert pins.get("P-004").zone == EXCLUDED
    model_of_5 = int(fact(viewer, "P-005", "model"))
    assert pins.get("P-005") == Pin("P-005", 7, model_of_5, zone=viewer.call("parcel", parcel="P-005")[0]["zone"])
    window.wait(lambda state: state["empty"] == {"small": 1, "excluded": 1} and not state["busy"])
    assert viewer.call("undo")[0]["words"] == "pin P-005"
    viewer.call("undo")
    viewer.call("undo")
    assert read_pins(tmp_path / "pins.csv").rows == ()
    window.wait(lambda state: state["built"] == 23 and not state["busy"])
    assert fact(viewer, "P-003", "model") == model
    assert viewer.call("redo")[0]["words"] == "reroll P-003"


def test_a_score_outlives_the_process(folder: Path, opened, tmp_path: Path):
    code = SCORE_AND_DIE.format(folder=str(folder))
    script = tmp_path / "script.py"
    script.write_text(code)
    assert subprocess.run([sys.executable, str(script)], check=False, timeout=120).returncode == -9
    viewer, window = opened()
    assert viewer.call("parcel", parcel="P-004")[0]["said"] == {"score": 75.0, "kind": "stars"}
    zones = {zone["name"]: zone for zone in window.state["zones"]}
    assert (zones["offices"]["scored"], zones["homes"]["scored"], zones["offices"]["learnable"]) == (1, 0, True)
    # The zone's session is that of the scoring page.
    store = Store.open(tmp_path / "offices.db")
    assert list(store.record.factors["overall"]) == [f"g7-{fact(viewer, 'P-004', 'model')}"]
    store.close()
    viewer.call("score", parcel="P-004", score=None)
    assert viewer.call("parcel", parcel="P-004")[0]["said"]["score"] is None
    with pytest.raises(GrammarlabError, match="score: expected"):
        viewer.call("score", parcel="P-004", score=101)


def test_a_zone_is_learned_and_built_with_its_new_grammar(opened, tmp_path: Path):
    viewer, window = opened()
    with pytest.raises(GrammarlabError, match="nothing of homes is liked"):
        viewer.call("learn", zone="homes")
    for number, parcel in enumerate(("P-000", "P-001", "P-002", "P-006", "P-007", "P-008")):
        viewer.call("score", parcel=parcel, score=100 if number % 2 else 0)
    viewer.call("learn", zone="homes")
    state = window.wait(lambda state: state["tiles"] == 1 or state["failed"])
    assert not state["failed"]
    plan = read_plan(tmp_path / "town.toml")
    assert [Path(zone.grammar).name for zone in plan.zones] == ["homes-learned.cga", "toy"]
    assert (tmp_path / "homes-learned.cga").is_file()
    assert "# low ones" in (tmp_path / "town.toml").read_text()
    (homes,) = (zone for zone in state["zones"] if zone["name"] == "homes")
    # Buildings of the learned grammar have scores of their own.
    assert (homes["grammar"], homes["scored"]) == ("homes-learned.cga", 0)
    assert "6 scores" in homes["learned"]
    assert viewer.call("undo")[0]["words"] == "learn homes"
    assert read_plan(tmp_path / "town.toml").zones[0].grammar == "toy"


def test_a_city_without_its_plan_is_only_shown(folder: Path):
    (folder / "city.json").write_text('{"plan": "/nowhere/plan.toml"}')
    viewer = CityViewer(folder, rebuild=REBUILD)
    assert viewer.call("parcel", parcel="P-003")[0]["status"] == "built"
    for command in ("reroll", "pin", "exclude", "score"):
        with pytest.raises(GrammarlabError, match="plan of this city is not known"):
            viewer.call(command, parcel="P-003", score=50)
    viewer.close()


def test_a_plan_that_was_changed_elsewhere_is_not_overwritten(opened, tmp_path: Path):
    viewer, window = opened()
    viewer.call("score", parcel="P-000", score=100)
    text = (tmp_path / "town.toml").read_text().replace("seed = 7", "seed = 8")
    (tmp_path / "town.toml").write_text(text)
    viewer.call("learn", zone="homes")
    state = window.wait(lambda state: state["failed"])
    assert "changed on disk" in state["failed"]
    assert (tmp_path / "town.toml").read_text() == text


@pytest.mark.parametrize("name", ["parcels.parquet", "tileset.json"])
def test_a_folder_that_is_no_city_is_refused(folder: Path, name: str):
    (folder / name).write_bytes(b"PAR1 nothing")
    with pytest.raises(AssetError, match=name):
        CityViewer(folder)
    (folder / name).unlink()
    with pytest.raises(AssetError, match=name):
        CityViewer(folder)
