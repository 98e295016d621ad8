"""A score that is saved against a bare SQLite commit, and an open session against the JSON in its file."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from itertools import count

import pytest

from grammarlab.runs.scoring.session import Session
from grammarlab.runs.scoring.store import About, Store

ABOUT = About("toy", "Lot --> extrude(3)", 5, 100)
NUM_EVENTS = 2_000


@pytest.fixture
def file(tmp_path):
    with closing(Store.open(tmp_path / "s.db", ABOUT)) as store:
        store._connection.execute("PRAGMA synchronous = OFF")
        for number in range(NUM_EVENTS):
            store.append("score", {"factor": "overall", "models": [f"g5-{number}"], "score": 50})
    return tmp_path / "s.db"


@pytest.mark.benchmark(group="save a score")
def bench_bare_commit(benchmark, tmp_path):
    with closing(sqlite3.connect(tmp_path / "s.db", isolation_level=None)) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("CREATE TABLE events (number INTEGER PRIMARY KEY, body TEXT)")
        numbers = count(1)
        benchmark(lambda: connection.execute("INSERT INTO events VALUES (?, ?)", (next(numbers), "x" * 80)))


@pytest.mark.benchmark(group="save a score")
def bench_event(benchmark, file):
    with closing(Store.open(file)) as store:
        body = {"factor": "overall", "models": ["g5-1"], "score": 50}
        benchmark(lambda: store.append("score", body))


@pytest.mark.benchmark(group="save a score")
def bench_session(benchmark, tmp_path):
    with closing(Session("toy", tmp_path / "s.db", jobs=0)) as session:
        models = list(session.call("state")[0]["models"])
        benchmark(lambda: session.call("score", models=models[:1], score=50))


@pytest.mark.benchmark(group="100 models in another order")
@pytest.mark.parametrize("by", ["score", "random", "shown"])
def bench_sort(benchmark, tmp_path, by):
    with closing(Session("toy", tmp_path / "s.db", jobs=0)) as session:
        session.call("layout", grids=1, rows=10, columns=10)
        benchmark(lambda: session.call("sort", by=by))


@pytest.mark.benchmark(group=f"read {NUM_EVENTS} events")
def bench_json(benchmark, file):
    def read():
        with closing(sqlite3.connect(file)) as connection:
            return [json.loads(body) for (body,) in connection.execute("SELECT body FROM events")]

    assert len(benchmark(read)) == NUM_EVENTS


@pytest.mark.benchmark(group=f"read {NUM_EVENTS} events")
def bench_open(benchmark, file):
    def read():
        with closing(Store.open(file)) as store:
            return store.record.revision

    assert benchmark(read) == NUM_EVENTS
