"""State of a session for the page."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.pages.desktop import StateEvent
from grammarlab.pages.record.judgements import Scores, compared
from grammarlab.pages.record.model_grids import PAIRS
from grammarlab.pages.scoring.desk import SessionDesk
from grammarlab.pages.scoring.display import SessionDisplay
from grammarlab.pages.scoring.next_models import WAYS
from grammarlab.pages.windows import PROTOCOL, Message
from grammarlab.pages.workers.tasks import Predictions, Singles
from grammarlab.preference.labels import Kind
from grammarlab.runs.sample.domains import SPECIES

MAX_RECENT = 48
"""Largest number of scored models beside the grids."""
NUM_NEXT = 8
"""Largest number of models that are shown as next in line; their pictures are drawn in advance."""
_VERDICTS: tuple[tuple[Kind, int, str], ...] = (("rather", 1, "first"), ("rather", -1, "second"), ("tie", 1, "alike"))
"""Messages, each with its order of models."""


def state_event(desk: SessionDesk) -> StateEvent:
    """The event with the state of the page."""
    return {"event": "state", "state": state_of(desk)}, ()


def state_of(desk: SessionDesk) -> Message:
    """State of the page, without pictures."""
    display, updating = desk.display, desk.learning.updating
    record, knowledge = display.record, display.knowledge
    predicted = knowledge.predictions_of(display.number)
    layout, subjects = record.layout, [subject for scores in record.factors.values() for subject in scores]
    return {
        "protocol": PROTOCOL,
        "title": display.store.about.title,
        "learns": "species" if display.store.about.suffix == SPECIES else "grammar",
        "session": desk.target.name,
        "revision": record.revision,
        "factors": [
            {"id": record.numbers[name], "name": name, "labels": len(scores)} for name, scores in record.factors.items()
        ],
        "active": record.active,
        "view": record.view,
        "layout": {"grids": layout.grids, "rows": layout.rows, "columns": layout.columns},
        "way": record.way,
        "grids": [{"title": grid.title, "models": list(grid.models)} for grid in record.grids],
        "line": desk.learning.upcoming()[:NUM_NEXT],
        "models": _models(display, predicted),
        "pairs": _pairs(display) if record.way == PAIRS else None,
        "recent": _recent(display),
        "scored": len({subject for subject in subjects if " " not in subject}),
        "compared": sum(" " in subject for subject in subjects),
        "can_undo": bool(record.done),
        "can_redo": bool(record.undone),
        "chart": [{"labels": labels, "js": js} for labels, js in record.chart],
        "relevance": _relevance(predicted),
        "words": [] if knowledge.learned is None else list(knowledge.learned.words),
        "contrasts": _contrasts(display),
        "explained": knowledge.learned is not None and knowledge.learned.is_explained,
        "gain": None if knowledge.learned is None else knowledge.learned.gain,
        "turn": knowledge.learned.turn if knowledge.learned and knowledge.learned.turn in record.factors else "",
        "updating": None if updating is None else updating.as_json(),
        "fresh": knowledge.label_revision == record.label_revision,
        "ways": [
            {"name": name, "label": words.label, "says": words.says} for name, words in WAYS.items() if name != PAIRS
        ],
        "message": display.said,
        "warnings": list(display.warnings.values()),
    }


def _models(display: SessionDisplay, predicted: Predictions | None) -> dict[str, Message]:
    """Knowledge about each model in a grid or beside the grids."""
    record = display.record
    names = list(dict.fromkeys((*record.shown_now, *_recent(display))))
    index = display.knowledge.indices(names, display.pool)
    scores, product = record.factors[record.active], display.knowledge.predictions_of(0)
    columns = zip(
        names,
        _numbers(None if predicted is None else predicted.mean, index),
        _numbers(None if predicted is None else predicted.std, index),
        _numbers(None if product is None else product.mean, index),
        strict=True,
    )
    return {
        name: {
            "score": None if scores.get(name) is None else scores[name].score,
            "kind": None if scores.get(name) is None else scores[name].kind,
            "mean": mean,
            "std": std,
            "label": display.pool.label_of(name),
            "product": of_product,
        }
        for name, mean, std, of_product in columns
    }


def _recent(display: SessionDisplay) -> list[str]:
    """Models with a score of the active factor, the latest first."""
    scored = [subject for subject in display.record.factors[display.record.active] if " " not in subject]
    return scored[: -MAX_RECENT - 1 : -1]


def _pairs(display: SessionDisplay) -> list[Message]:
    """The shown pairs, with their labels for the active factor."""
    scores = display.record.factors[display.record.active]
    return [
        {"models": list(models), "said": _verdict(models, scores)}
        for models in zip(*(grid.models for grid in display.record.grids), strict=True)
    ]


def _contrasts(display: SessionDisplay) -> list[Message]:
    """The choices on which the scores depend, with the mean predicted scores of models without and with them."""
    learned = display.knowledge.learned
    return [
        {"text": contrast.text, "without": round(contrast.without), "having": round(contrast.having)}
        for contrast in (() if learned is None else learned.contrasts)
        if contrast.models
    ]


def _verdict(models: tuple[str, str], scores: Scores) -> str | None:
    """Which of two models is preferred, ``first`` or ``second``, or ``alike``."""
    for kind, order, word in _VERDICTS:
        subject, label = compared(models[::order], kind)
        if scores.get(subject) == label:
            return word
    return None


def _numbers(values: Singles | None, index: NDArray[np.int64]) -> list[float | None]:
    """The values of some models, to two digits; none for those that have no place."""
    if values is None:
        return [None] * len(index)
    return [round(float(values[i]), 2) if i >= 0 else None for i in index]


def _relevance(predicted: Predictions | None) -> list[Message]:
    if predicted is None:
        return []
    return [{"name": name, "level": level, "share": share} for name, level, share in predicted.relevance]
