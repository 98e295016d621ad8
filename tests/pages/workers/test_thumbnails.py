"""Pictures: in what order they are drawn, to whom they are sent, and how many are kept."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from PIL import Image

from grammarlab.errors import Finding, Location
from grammarlab.pages.windows import Message
from grammarlab.pages.workers import thumbnails as module
from grammarlab.pages.workers.tasks import DrawModels, DrawnModels
from grammarlab.pages.workers.thumbnails import CHUNK, GOOD, QUICK, SHEET, Thumbnails, sprite_sheet
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool


class Easel(WorkerPool):
    """Draws when told to: pictures of one grey a model."""

    def __init__(self) -> None:
        super().__init__("", (), 0, lambda _call: None)
        self.tasks: list[tuple[DrawModels, Callable[[TaskOutcome], None], Callable[[], bool]]] = []
        self.drawn: list[DrawModels] = []

    def submit(self, request: Any, then: Any, *, is_wanted: Any = None, first: bool = False, **_: Any) -> int:
        assert first
        self.tasks.insert(0, (request, then, is_wanted))
        return 0

    def draw(self, most: int = 1000) -> None:
        while self.tasks and most:
            draw, then, is_wanted = self.tasks.pop(0)
            if is_wanted():
                most -= 1
                self.drawn.append(draw)
                then(TaskOutcome(DrawnModels(tuple(picture_of(model, draw.size) for model in draw.models), (FINDING,))))


def picture_of(model: str, size: int) -> np.ndarray:
    return np.full((size, size, 3), 10 * int(model.partition("-")[2]) % 256, np.uint8)


class Viewer:
    """Remembers which pictures came."""

    def __init__(self) -> None:
        self.sheets: list[tuple[Message, Sequence[bytes]]] = []

    def send(self, message: Message, buffers: Sequence[bytes]) -> None:
        self.sheets.append((message, buffers))

    @property
    def models(self) -> list[str]:
        return [model for message, _ in self.sheets for model in message["models"]]


FINDING = Finding("warning", "missing-asset", "no lamp", Location())


def ignore(_findings: Sequence[Finding]) -> None:
    """What no test but one looks at."""


MODELS = [f"g1-{index}" for index in range(10)]


def test_many_are_drawn_quickly_first_and_then_well_in_the_order_asked_for():
    easel, viewer = Easel(), Viewer()
    Thumbnails(easel, ignore).request(MODELS, 40, viewer.send)
    easel.draw()
    assert [model for draw in easel.drawn for model in draw.models] == MODELS + MODELS
    # The very first one comes alone.
    sizes = [(draw.samples, len(draw.models)) for draw in easel.drawn]
    assert sizes == [(QUICK, 1), (QUICK, CHUNK), (QUICK, CHUNK), (QUICK, 1), (GOOD, CHUNK), (GOOD, CHUNK), (GOOD, 2)]
    assert viewer.models == MODELS + MODELS


def test_few_are_drawn_well_at_once():
    easel, viewer = Easel(), Viewer()
    Thumbnails(easel, ignore).request(MODELS[:3], 40, viewer.send)
    easel.draw()
    assert [draw.samples for draw in easel.drawn] == [GOOD]


def test_what_nobody_looks_at_is_drawn_quickly_alone_until_somebody_does():
    easel, viewer = Easel(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    thumbnails.request(MODELS, 40, viewer.send, good=MODELS[:2])
    easel.draw()
    drawn = [(model, draw.samples) for draw in easel.drawn for model in draw.models]
    assert sorted(drawn) == sorted([(model, QUICK) for model in MODELS[2:]] + [(model, GOOD) for model in MODELS[:2]])
    quality = {
        name: good
        for message, _ in viewer.sheets
        for name, good in zip(message["models"], message["good"], strict=True)
    }
    assert quality == {model: model in MODELS[:2] for model in MODELS}
    # Quick ones that are there already are not sent again, good ones are.
    thumbnails.request([], 40, (again := Viewer()).send, good=MODELS[:4])
    assert again.models == MODELS[:2]
    easel.draw()
    assert again.models == MODELS[:4]
    assert [model for draw in easel.drawn[-1:] for model in draw.models] == MODELS[2:4]


def test_good_pictures_that_nobody_looks_at_any_more_are_not_drawn():
    easel, viewer = Easel(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    thumbnails.request(MODELS[:4], 40, viewer.send)
    thumbnails.request(MODELS[:4], 40, viewer.send, good=[])
    easel.draw()
    assert {draw.samples for draw in easel.drawn} == {QUICK}
    assert viewer.models == MODELS[:4]


def test_sheets_hold_the_pictures_row_by_row():
    easel, viewer = Easel(), Viewer()
    Thumbnails(easel, ignore).request(MODELS[:3], 40, viewer.send)
    easel.draw()
    message, (content,) = viewer.sheets[0]
    sheet = np.asarray(Image.open(io.BytesIO(content))).astype(int)
    for index, model in enumerate(message["models"]):
        row, column = divmod(index, message["columns"])
        cell = sheet[row * 40 : row * 40 + 40, column * 40 : column * 40 + 40]
        assert np.abs(cell - picture_of(model, 40)).max() <= 3


def test_what_is_kept_is_sent_again_without_drawing():
    easel, viewer = Easel(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    many = [f"g1-{index}" for index in range(60)]
    thumbnails.request(many, 40, viewer.send)
    easel.draw()
    other = Viewer()
    thumbnails.request(many, 40, other.send)
    assert other.models == many
    assert [len(message["models"]) for message, _ in other.sheets] == [SHEET, SHEET, 10]
    assert not easel.tasks
    thumbnails.request(many[:1], 41, other.send)
    assert len(easel.tasks) == 1


def test_windows_get_what_they_asked_for_last():
    easel, one, other = Easel(), Viewer(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    thumbnails.request(MODELS[:4], 40, one.send)
    thumbnails.request(MODELS[4:8], 40, one.send)
    thumbnails.request(MODELS[6:8], 40, other.send)
    easel.draw()
    assert {model for draw in easel.drawn for model in draw.models} == set(MODELS[4:8])
    assert one.models == MODELS[4:8]
    assert other.models == MODELS[6:8]


def test_nothing_is_drawn_for_a_window_that_is_gone_and_it_may_come_back():
    easel, viewer = Easel(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    thumbnails.request(MODELS, 40, viewer.send)
    thumbnails.forget(viewer.send)
    easel.draw()
    assert not easel.drawn
    thumbnails.request(MODELS, 40, viewer.send)
    easel.draw()
    assert viewer.models == MODELS + MODELS


def test_newer_requests_come_before_older_ones():
    easel, one, other = Easel(), Viewer(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    thumbnails.request(MODELS[:4], 40, one.send)
    thumbnails.request(MODELS[4:], 40, other.send)
    easel.draw(2)
    assert other.models == MODELS[4 : 5 + CHUNK]
    assert not one.models


def test_only_so_many_are_kept_those_used_last(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "MAX_PIXELS", 6 * 40 * 40)
    easel, viewer = Easel(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    for model in MODELS[:6]:
        thumbnails.request([model], 40, viewer.send)
        easel.draw()
    thumbnails.request(MODELS[:1], 40, viewer.send)
    thumbnails.request(MODELS[6:8], 40, viewer.send)
    easel.draw()
    easel.drawn.clear()
    thumbnails.request([MODELS[0], *MODELS[3:8]], 40, viewer.send)
    assert not easel.tasks
    thumbnails.request([MODELS[1]], 40, viewer.send)
    assert len(easel.tasks) == 1


def test_a_good_picture_is_not_replaced_by_a_quick_one():
    easel, viewer = Easel(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    thumbnails.request(MODELS, 40, viewer.send)
    quick = [task for task in easel.tasks if task[0].samples == QUICK]
    easel.tasks = [task for task in easel.tasks if task[0].samples == GOOD] + quick
    easel.draw()
    thumbnails.request(MODELS, 40, viewer.send)
    assert not easel.tasks


def test_a_picture_that_could_not_be_drawn_can_be_asked_for_again():
    easel, viewer = Easel(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    thumbnails.request(MODELS[:2], 40, viewer.send)
    easel.tasks.pop()[1](TaskOutcome(error="lost"))
    thumbnails.request(MODELS[:2], 40, viewer.send)
    easel.draw()
    assert viewer.models == MODELS[:2]


@pytest.mark.parametrize("number", [1, 2, 5, 25])
def test_sheets_are_about_square(number: int):
    pictures = [picture_of(f"g1-{index}", 32) for index in range(number)]
    columns = int(np.ceil(np.sqrt(number)))
    picture = Image.open(io.BytesIO(sprite_sheet(pictures, columns)))
    assert picture.width == 32 * columns
    assert picture.height == 32 * -(-number // columns)


def test_warnings_come_with_the_pictures():
    easel, found = Easel(), []
    Thumbnails(easel, found.append).request(MODELS[:3], 40, Viewer().send)
    assert not found
    easel.draw()
    assert found == [(FINDING,)]


class Address(str):
    """An address that counts how often it is compared with one that is not itself."""

    __slots__ = ()
    compared = 0
    __hash__ = str.__hash__

    def __eq__(self, other: object) -> bool:
        Address.compared += 1
        return str.__eq__(self, other)


@pytest.mark.parametrize("good", [None, 150])
def test_no_model_is_compared_with_the_others(good: int | None):
    Address.compared = 0
    models = [Address(f"a-{k}") for k in range(300)]
    easel, viewer = Easel(), Viewer()
    thumbnails = Thumbnails(easel, ignore)
    for _ in range(2):  # with nothing in the cache, and with quick pictures of all
        thumbnails.request(models, 32, viewer.send, None if good is None else models[good:])
        easel.draw(len(models) // CHUNK)
    assert len(easel.drawn) > len(models) // CHUNK
    assert Address.compared == 0
