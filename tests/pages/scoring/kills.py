"""Scores that were acknowledged before a process was killed, and what is in the file then."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path
from typing import Any

from grammarlab.pages.record.judgements import Judgement, Scores, compared
from grammarlab.pages.record.store import Store

MANY = int(os.environ.get("GRAMMARLAB_KILLS", "0"))
"""How often to kill, where that is to be more often than in all tests: each time takes a second or two."""


class Acknowledged:
    """Scores of a session that is killed again and again; the number of a score says what it is."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.saved: Scores = {}
        self.revision = self.number = 0

    def next(self) -> dict[str, object]:
        """What a page would ask for next."""
        self.number += 1
        return {"id": self.number, **_request(self.number)}

    def acknowledge(self, number: int, revision: int) -> None:
        """Somebody was told that a score is saved."""
        self.saved |= _entries(number)
        self.revision = max(self.revision, revision)

    def check(self, under_way: int) -> None:
        """Every acknowledged score is in the file, and at most those beyond that were on their way."""
        with closing(Store.open(self.path)) as store:
            scores = store.record.factors["overall"]
            assert store.record.revision >= self.revision
        assert {model: scores.get(model) for model in self.saved} == self.saved
        assert len(scores) <= len(self.saved) + 2 * under_way
        self.saved = dict(scores)


def _request(number: int) -> dict[str, object]:
    models = [f"g7-{number}", f"g7-{number + 1_000_000}"]
    match number % 4:
        case 0:
            return {"command": "compare", "models": models, "kind": "rather"}
        case 1:
            return {"command": "score", "models": models, "score": 25.0 * (number % 5), "kind": "stars"}
        case _:
            return {"command": "score", "models": models, "score": number % 101}


def _entries(number: int) -> Scores:
    """What a request leaves in the file."""
    request: Any = _request(number)
    if request["command"] == "compare":
        return dict([compared(request["models"], request["kind"])])
    return dict.fromkeys(request["models"], Judgement(float(request["score"]), request.get("kind", "score")))
