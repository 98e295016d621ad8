"""Thumbnails of models as sprite sheets, drawn by several processes and cached within a size limit."""

from __future__ import annotations

import io
import math
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.errors import Finding
from grammarlab.pages.desktop import Send
from grammarlab.pages.workers.tasks import DrawModels
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool

SMALLEST, LARGEST = 32, 512
"""Pixels along each side of a picture."""
MAX_PIXELS = 24_000_000
"""Largest size of the cache in bytes."""
SHEET = 25
"""Largest number of pictures on one sheet."""
CHUNK = 4
"""Number of models drawn at a time, so that the first pictures come early."""
MANY = 6
"""Number of missing pictures from which they are drawn quickly before they are drawn well."""
QUICK, GOOD = 1, 2
"""Samples along each side of a pixel."""
QUALITY = 88
"""Of JPEGs."""

Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class _Kept:
    picture: Picture
    samples: int


@dataclass
class Thumbnails:
    """Pictures requested by windows."""

    pool: WorkerPool
    warn: Callable[[Sequence[Finding]], None]
    """Receives the warnings of all pictures, with repeats."""
    _kept: OrderedDict[tuple[str, int], _Kept] = field(default_factory=OrderedDict)
    """Cached pictures by model and size, the last used at the end."""
    _wanted: dict[Send, tuple[int, frozenset[str]]] = field(default_factory=dict)
    """Latest size and models requested by each window."""
    _drawing: set[tuple[str, int, int]] = field(default_factory=set)
    """Models, sizes and samples in progress."""

    @property
    def shows_something(self) -> bool:
        """Whether there are pictures."""
        return bool(self._kept)

    @property
    def is_hurried(self) -> bool:
        """Whether a window waits for first pictures."""
        return any(samples == QUICK for _, _, samples in self._drawing)

    def request(self, models: Sequence[str], size: int, send: Send) -> None:
        """Send pictures when they are finished; earlier requests of this window are dropped.

        Args:
            models: different addresses.
            size: pixels along each side.
            send: receives sprite sheets; a model may be sent twice, the later picture is better.
        """
        self._wanted[send] = (size, frozenset(models))
        known = [model for model in models if (model, size) in self._kept]
        for start in range(0, len(known), SHEET):
            part = known[start : start + SHEET]
            _send_sheet(send, size, part, [self._use(model, size) for model in part])
        missing = [model for model in models if (model, size) not in self._kept]
        poor = [model for model in known if self._kept[model, size].samples < GOOD]
        quick = missing if len(missing) >= MANY else []
        # The last one submitted in front is done first.
        chunks = [*_chunks(quick, size, QUICK), *_chunks([*missing, *poor], size, GOOD)]
        for draw in reversed(chunks):
            self._submit(draw)

    def forget(self, send: Send) -> None:
        """Drop the requests of a closed window."""
        self._wanted.pop(send, None)

    def _submit(self, draw: DrawModels) -> None:
        keys = [(model, draw.size, draw.samples) for model in draw.models]
        models = tuple(key[0] for key in keys if key not in self._drawing)
        if models:
            self._drawing.update((model, draw.size, draw.samples) for model in models)
            draw = DrawModels(models, draw.size, draw.samples)
            self.pool.submit(draw, partial(self._drawn, draw), is_wanted=partial(self._is_wanted, draw), first=True)

    def _is_wanted(self, draw: DrawModels) -> bool:
        if any(size == draw.size and not models.isdisjoint(draw.models) for size, models in self._wanted.values()):
            return True
        self._drawing.difference_update((model, draw.size, draw.samples) for model in draw.models)
        return False

    def _drawn(self, draw: DrawModels, outcome: TaskOutcome) -> None:
        self._drawing.difference_update((model, draw.size, draw.samples) for model in draw.models)
        if outcome.value is None:
            return
        self.warn(outcome.value.warnings)
        for model, picture in zip(draw.models, outcome.value.pictures, strict=True):
            self._keep(model, draw.size, _Kept(picture, draw.samples))
        for send, (size, models) in list(self._wanted.items()):
            here = [model for model in draw.models if size == draw.size and model in models]
            _send_sheet(send, size, here, [self._use(model, size) for model in here])

    def _keep(self, model: str, size: int, kept: _Kept) -> None:
        known = self._kept.get((model, size))
        if known is None or known.samples <= kept.samples:
            self._kept[model, size] = kept
        pixels = sum(found.picture.size // 3 for found in self._kept.values())
        while pixels > MAX_PIXELS and len(self._kept) > CHUNK:
            _, oldest = self._kept.popitem(last=False)
            pixels -= oldest.picture.size // 3

    def _use(self, model: str, size: int) -> Picture:
        self._kept.move_to_end((model, size))
        return self._kept[model, size].picture


def _chunks(models: Sequence[str], size: int, samples: int) -> Iterator[DrawModels]:
    for start in range(0, len(models), CHUNK):
        yield DrawModels(tuple(models[start : start + CHUNK]), size, samples)


def _send_sheet(send: Send, size: int, models: Sequence[str], pictures: Sequence[Picture]) -> None:
    if not models:
        return
    columns = math.ceil(math.sqrt(len(models)))
    rows = math.ceil(len(models) / columns)
    place = {"columns": columns, "rows": rows, "width": size, "height": size}
    message = {"event": "pictures", "size": size, "models": list(models), **place}
    send(message, [sprite_sheet(pictures, columns)])


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
