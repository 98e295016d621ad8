"""The state of a session as the page reads it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.runs.scoring.populate import WAYS
from grammarlab.runs.scoring.rounds import Rounds
from grammarlab.runs.scoring.tasks import Predicted, Singles
from grammarlab.runs.serving.windows import Message

PROTOCOL = 1


def state_of(rounds: Rounds) -> Message:
    """Everything that the page shows, but pictures."""
    record, knowledge = rounds.record, rounds.knowledge
    predicted = knowledge.of(rounds.number)
    layout = record.layout
    return {
        "protocol": PROTOCOL,
        "title": rounds.store.about.title,
        "session": rounds.path.name,
        "revision": record.revision,
        "factors": [
            {"id": record.numbers[name], "name": name, "labels": len(scores)} for name, scores in record.factors.items()
        ],
        "active": record.active,
        "view": record.view,
        "layout": {"grids": layout.grids, "rows": layout.rows, "columns": layout.columns},
        "way": record.way,
        "grids": [{"title": grid.title, "models": list(grid.models)} for grid in record.grids],
        "models": _models(rounds, predicted),
        "scored": len(set().union(*record.factors.values())),
        "can_undo": bool(record.done),
        "can_redo": bool(record.undone),
        "chart": [{"labels": labels, "js": js} for labels, js in record.chart],
        "relevance": _relevance(predicted),
        "words": [] if knowledge.learned is None else list(knowledge.learned.words),
        "gain": None if knowledge.learned is None else knowledge.learned.gain,
        "updating": None if rounds.updating is None else rounds.updating.as_json(),
        "fresh": knowledge.judgements == record.judgements,
        "ways": [{"name": name, "says": says} for name, says in WAYS.items()],
        "message": rounds.message,
        "warnings": list(rounds.warnings.values()),
    }


def _models(rounds: Rounds, predicted: Predicted | None) -> dict[str, Message]:
    """What is known about each model that is shown."""
    record = rounds.record
    names = [model for grid in record.grids for model in grid.models]
    index = rounds.knowledge.indices(names, rounds.pool)
    scores, product = record.factors[record.active], rounds.knowledge.of(0)
    columns = zip(
        names,
        _numbers(None if predicted is None else predicted.mean, index),
        _numbers(None if predicted is None else predicted.std, index),
        _numbers(None if product is None else product.mean, index),
        strict=True,
    )
    return {
        name: {
            "score": scores.get(name),
            "mean": mean,
            "std": std,
            "label": rounds.label_of(name),
            "product": of_product,
        }
        for name, mean, std, of_product in columns
    }


def _numbers(values: Singles | None, index: NDArray[np.int64]) -> list[float | None]:
    """The values of some models, to two digits; none for those that have no place."""
    if values is None:
        return [None] * len(index)
    return [round(float(values[i]), 2) if i >= 0 else None for i in index]


def _relevance(predicted: Predicted | None) -> list[Message]:
    if predicted is None:
        return []
    return [{"name": name, "level": level, "share": share} for name, level, share in predicted.relevance]
