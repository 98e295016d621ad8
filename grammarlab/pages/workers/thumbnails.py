"""Thumbnails of models as sprite sheets, drawn by several processes and cached within a size limit."""

from __future__ import annotations

import io
import math
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.errors import Finding
from grammarlab.pages.windows import Send
from grammarlab.pages.workers.tasks import DrawModels
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool

SMALLEST, LARGEST = 32, 512
"""Pixels along each side of a picture."""
MAX_PIXELS = 24_000_000
"""Largest size of the cache in pixels."""
SHEET = 25
"""Largest number of pictures on one sheet."""
CHUNK = 4
"""Number of models drawn at a time, so that the first pictures come early."""
MIN_QUICK = 6
"""Smallest number of missing pictures that are drawn quickly before they are drawn well."""
QUICK, GOOD = 1, 2
"""Samples along each side of a pixel."""
QUALITY = 88
"""Quality of JPEGs, 1 to 95."""

Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class _Drawing:
    picture: Picture
    samples: int


@dataclass(frozen=True, slots=True)
class _Request:
    """Latest request of a window."""

    size: int
    models: frozenset[str]
    good: frozenset[str]
    """Those whose pictures are to be good."""

    def of(self, draw: DrawModels) -> list[str]:
        """Models of a drawing that are requested as it draws them."""
        models = self.good if draw.samples >= GOOD else self.models
        return [model for model in draw.models if model in models] if draw.size == self.size else []


@dataclass
class Thumbnails:
    """Pictures requested by windows."""

    pool: WorkerPool
    warn: Callable[[Sequence[Finding]], None]
    """Receives the warnings of all pictures, with repeats."""
    _cache: OrderedDict[tuple[str, int], _Drawing] = field(default_factory=OrderedDict)
    """Cached pictures by model and size, the last used at the end."""
    _pixels: int = 0
    """Pixels of all of them."""
    _requests: dict[Send, _Request] = field(default_factory=dict)
    """Latest request of each window."""
    _pending: set[tuple[str, int, int]] = field(default_factory=set)
    """Models, sizes and samples in progress."""

    @property
    def shows_something(self) -> bool:
        """Whether there are pictures."""
        return bool(self._cache)

    @property
    def is_hurried(self) -> bool:
        """Whether a window waits for first pictures."""
        return any(samples == QUICK for _, _, samples in self._pending)

    def request(self, models: Sequence[str], size: int, send: Send, good: Collection[str] | None = None) -> None:
        """Send pictures when they are finished; earlier requests of this window are dropped.

        Args:
            models: different addresses.
            size: pixels along each side.
            send: receives sprite sheets; a model may be sent twice, the later picture is better.
            good: models whose pictures are to be good, which may have quick ones there already; by default `models`.
        """
        every = list(dict.fromkeys((*models, *(good or ()))))
        request = _Request(size, frozenset(every), frozenset(models if good is None else good))
        self._requests[send] = request
        shown = frozenset(models)
        cached = [model for model in every if (model, size) in self._cache]
        poor = [model for model in cached if model in request.good and self._cache[model, size].samples < GOOD]
        news = [model for model in cached if model in shown or self._cache[model, size].samples >= GOOD]
        for start in range(0, len(news), SHEET):
            part = news[start : start + SHEET]
            _send_sheet(send, size, part, [self._use(model, size) for model in part])
        missing = [model for model in every if (model, size) not in self._cache]
        awaited = [model for model in missing if model in request.good]
        quick = missing if len(awaited) >= MIN_QUICK else [model for model in missing if model not in request.good]
        # The very first picture does not wait for others.
        head = quick[:1] if not self.shows_something else []
        # The last one submitted in front is done first.
        chunks = [
            *_chunks(head, size, QUICK),
            *_chunks(quick[len(head) :], size, QUICK),
            *_chunks([*awaited, *poor], size, GOOD),
        ]
        with self.pool.held():
            for draw in reversed(chunks):
                self._submit(draw)

    def forget(self, send: Send) -> None:
        """Drop the requests of a closed window."""
        self._requests.pop(send, None)

    def _submit(self, draw: DrawModels) -> None:
        keys = [(model, draw.size, draw.samples) for model in draw.models]
        models = tuple(key[0] for key in keys if key not in self._pending)
        if models:
            self._pending.update((model, draw.size, draw.samples) for model in models)
            draw = DrawModels(models, draw.size, draw.samples)
            self.pool.submit(draw, partial(self._drawn, draw), is_wanted=partial(self._is_wanted, draw), first=True)

    def _is_wanted(self, draw: DrawModels) -> bool:
        if any(request.of(draw) for request in self._requests.values()):
            return True
        self._pending.difference_update((model, draw.size, draw.samples) for model in draw.models)
        return False

    def _drawn(self, draw: DrawModels, outcome: TaskOutcome) -> None:
        self._pending.difference_update((model, draw.size, draw.samples) for model in draw.models)
        if outcome.value is None:
            return
        self.warn(outcome.value.warnings)
        for model, picture in zip(draw.models, outcome.value.pictures, strict=True):
            self._store(model, draw.size, _Drawing(picture, draw.samples))
        for send, request in list(self._requests.items()):
            here = request.of(draw)
            _send_sheet(send, draw.size, here, [self._use(model, draw.size) for model in here])

    def _store(self, model: str, size: int, drawing: _Drawing) -> None:
        cached = self._cache.get((model, size))
        if cached is None or cached.samples <= drawing.samples:
            self._cache[model, size] = drawing
            self._pixels += _pixels(drawing) - (_pixels(cached) if cached else 0)
        while self._pixels > MAX_PIXELS and len(self._cache) > CHUNK:
            _, oldest = self._cache.popitem(last=False)
            self._pixels -= _pixels(oldest)

    def _use(self, model: str, size: int) -> _Drawing:
        self._cache.move_to_end((model, size))
        return self._cache[model, size]


def _pixels(drawing: _Drawing) -> int:
    return math.prod(drawing.picture.shape[:2])


def _chunks(models: Sequence[str], size: int, samples: int) -> Iterator[DrawModels]:
    for start in range(0, len(models), CHUNK):
        yield DrawModels(tuple(models[start : start + CHUNK]), size, samples)


def _send_sheet(send: Send, size: int, models: Sequence[str], drawings: Sequence[_Drawing]) -> None:
    if not models:
        return
    columns = math.ceil(math.sqrt(len(models)))
    rows = math.ceil(len(models) / columns)
    layout = {"columns": columns, "rows": rows, "width": size, "height": size}
    good = [drawing.samples >= GOOD for drawing in drawings]
    message = {"event": "pictures", "size": size, "models": list(models), "good": good, **layout}
    send(message, [sprite_sheet([drawing.picture for drawing in drawings], columns)])


def sprite_sheet(pictures: Sequence[Picture], columns: int) -> bytes:
    """Pictures of one size row by row, as a JPEG."""
    height, width, _ = pictures[0].shape
    rows = math.ceil(len(pictures) / columns)
    sheet = np.full((rows * height, columns * width, 3), 255, np.uint8)
    for index, picture in enumerate(pictures):
        row, column = divmod(index, columns)
        sheet[row * height : (row + 1) * height, column * width : (column + 1) * width] = picture
    file = io.BytesIO()
    Image.fromarray(sheet).save(file, "JPEG", quality=QUALITY)
    return file.getvalue()
