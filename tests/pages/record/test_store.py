"""Session files: what is written stays, old ones open, foreign ones are refused in words."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from grammarlab.errors import AssetError, UsageError
from grammarlab.pages.record import store as store_module
from grammarlab.pages.record.judgements import Judgement
from grammarlab.pages.record.store import APPLICATION, STEPS, About, Store

ABOUT = About("toy", "Lot --> extrude(3)", 5, 100)

VERSION_1 = """
CREATE TABLE about (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE events (number INTEGER PRIMARY KEY, time REAL NOT NULL, kind TEXT NOT NULL, body TEXT NOT NULL);
INSERT INTO about VALUES ('title', 'toy');
INSERT INTO about VALUES ('grammar', 'Lot --> extrude(3)');
INSERT INTO about VALUES ('hash', '31d1fbd8d2cd47ae5cb3fbb5f8d60e1dbf2a0a6f1d2a6b4d3a2f45f4c6a2f7d0');
INSERT INTO about VALUES ('seed', '5');
INSERT INTO about VALUES ('size', '100');
INSERT INTO events VALUES
    (1, 1.7e9, 'shown', '{"way":"default","grids":[{"title":"samples","models":["g9-0","g9-1"]}]}');
INSERT INTO events VALUES (2, 1.7e9, 'score', '{"factor":"overall","score":80,"models":["g9-0","g9-1"]}');
INSERT INTO events VALUES (3, 1.7e9, 'score', '{"factor":"overall","score":null,"models":["g9-0"]}');
INSERT INTO events VALUES (4, 1.7e9, 'factor_create', '{"name":"roof"}');
INSERT INTO events VALUES (5, 1.7e9, 'undo', '{}');
INSERT INTO events VALUES (6, 1.7e9, 'layout', '{"grids":1,"rows":2,"columns":3}');
INSERT INTO events VALUES (7, 1.7e9, 'learned', '{"labels":1,"js":0.25}');
PRAGMA application_id = 1816245696;
PRAGMA user_version = 1;
"""
"""A file as the first version wrote it. Never change this: such files are out there."""


def version_1(path: Path) -> Path:
    script = VERSION_1.replace("31d1fbd8d2cd47ae5cb3fbb5f8d60e1dbf2a0a6f1d2a6b4d3a2f45f4c6a2f7d0", ABOUT.hash)
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(script)
    return path


def begun(path: Path, *scores: int) -> Path:
    with closing(Store.open(path, ABOUT)) as store:
        for number, score in enumerate(scores):
            store.append("score", {"factor": "overall", "models": [f"g5-{number}"], "score": score})
    return path


def change(path: Path, *statements: str) -> Path:
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        for statement in statements:
            connection.execute(statement)
    return path


def test_a_session_about_a_file_with_windows_line_ends_is_about_its_text(tmp_path, monkeypatch):
    about, text = About("toy", "Lot --> A\r\n", 5, 100), "Lot --> A\n"
    with monkeypatch.context() as patch:  # as earlier versions did
        patch.setattr(About, "hash", property(lambda about: sha256(about.grammar.encode()).hexdigest()))
        with closing(Store.open(tmp_path / "a.db", about)) as store:
            assert store.about.hash != About("toy", text, 5, 100).hash
    with closing(Store.open(tmp_path / "a.db")) as store:
        assert store.about.hash == About("toy", text, 5, 100).hash


def test_what_was_written_is_read_again(tmp_path: Path):
    path = begun(tmp_path / "s.db", 10, 20)
    with closing(Store.open(path)) as store:
        assert store.about == ABOUT
        assert store.record.factors == {"overall": {"g5-0": Judgement(10.0), "g5-1": Judgement(20.0)}}
        assert store.record.revision == 2


def test_every_commit_goes_to_the_disk(tmp_path: Path):
    with closing(Store.open(tmp_path / "s.db", ABOUT)) as store:
        pragma = store._connection.execute
        assert pragma("PRAGMA journal_mode").fetchone() == ("wal",)
        assert pragma("PRAGMA synchronous").fetchone() == (2,)


def test_two_processes_see_what_the_other_wrote_before_they_write(tmp_path: Path):
    path = begun(tmp_path / "s.db", 10)
    with closing(Store.open(path)) as one, closing(Store.open(path)) as other:
        one.append("factor_create", {"name": "roof"})
        with pytest.raises(UsageError, match="already"):
            other.append("factor_create", {"name": "roof"})
        other.append("undo", {})
        assert not other.poll() or other.record.revision == 3
        assert one.poll()
        assert one.record == other.record
        assert not one.poll()


def test_a_file_of_the_first_version_opens(tmp_path: Path):
    with closing(Store.open(version_1(tmp_path / "s.db"))) as store:
        assert store.about == ABOUT
        assert store.record.factors == {"overall": {"g9-1": Judgement(80.0)}}
        assert store.record.layout.columns == 3
        assert store.record.chart == [(1, 0.25)]
        store.append("redo", {})
        assert list(store.record.factors) == ["overall", "roof"]


def test_older_files_get_newer_tables_all_or_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = version_1(tmp_path / "s.db")
    monkeypatch.setattr(store_module, "STEPS", (*STEPS, "CREATE TABLE extra (a TEXT); nonsense;"))
    with pytest.raises(AssetError, match="syntax error"):
        Store.open(path)
    monkeypatch.setattr(store_module, "STEPS", (*STEPS, "CREATE TABLE extra (a TEXT); DROP TABLE extra;"))
    with closing(Store.open(path)) as store:
        assert store.record.revision == 7
        assert store._schema_version() == 2
    with closing(Store.open(path)) as store:
        store.append("redo", {})
    monkeypatch.setattr(store_module, "STEPS", STEPS)
    with pytest.raises(AssetError, match="newer version of grammarlab"):
        Store.open(path)


def test_a_missing_file_is_begun_only_when_asked_for(tmp_path: Path):
    with pytest.raises(AssetError, match="no such session file"):
        Store.open(tmp_path / "s.db")
    assert not (tmp_path / "s.db").exists()
    with pytest.raises(AssetError, match="cannot be used"):
        Store.open(tmp_path / "missing" / "s.db", ABOUT)


def test_folders_and_other_files_are_no_sessions(tmp_path: Path):
    with pytest.raises(AssetError, match="a folder"):
        Store.open(tmp_path, ABOUT)
    for content in (b"hello", b"SQLite format 3\0" + b"\xff" * 5000, b"\0" * 100_000):
        path = tmp_path / "s.db"
        path.write_bytes(content)
        with pytest.raises(AssetError, match="not a session file"):
            Store.open(path, ABOUT)
        assert path.read_bytes() == content


def test_another_database_is_left_alone(tmp_path: Path):
    path = change(tmp_path / "s.db", "CREATE TABLE precious (a TEXT)", "INSERT INTO precious VALUES ('x')")
    before = path.read_bytes()
    with pytest.raises(AssetError, match="not a session file"):
        Store.open(path, ABOUT)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    "statement",
    [
        "CREATE TRIGGER t AFTER INSERT ON events BEGIN DELETE FROM events; END",
        "CREATE TABLE more (a TEXT)",
        "CREATE VIEW v AS SELECT 1",
        "DROP TABLE about",
        "ALTER TABLE events ADD COLUMN more TEXT",
    ],
)
def test_tables_must_be_those_of_a_session(tmp_path: Path, statement: str):
    path = change(begun(tmp_path / "s.db", 1), statement)
    with pytest.raises(AssetError, match="its tables are not"):
        Store.open(path)


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("UPDATE events SET body = 'x' WHERE number = 2", "event 2: expected JSON"),
        ("UPDATE events SET body = '[' || hex(zeroblob(100000))", "event 1"),
        ("UPDATE events SET body = replace(hex(zeroblob(100000)), '00', '[')", "event 1"),
        ("UPDATE events SET body = zeroblob(20000000)", "event 1"),
        ("UPDATE events SET body = hex(zeroblob(20000000))", "event 1"),
        ("UPDATE events SET body = 'NaN'", "event 1"),
        ("UPDATE events SET body = '5'", "event 1: expected an object"),
        ("UPDATE events SET body = replace(body, '10', '1e400')", "event 1: score"),
        ("UPDATE events SET kind = 'nonsense'", "unknown event 'nonsense'"),
        ("UPDATE events SET kind = zeroblob(5)", "unknown event"),
        ("UPDATE events SET kind = CAST(x'ff' AS TEXT)", "cannot be used"),
        ("DELETE FROM events WHERE number = 1", "event 2: expected 1"),
        ("UPDATE events SET number = 1 << 62 WHERE number = 2", "expected 2"),
        ("UPDATE events SET number = -1 WHERE number = 1", "event 2: expected 1"),
        ("UPDATE events SET kind = 'undo'", "event 1"),
        ("UPDATE about SET value = '../../x' WHERE name = 'title'", "with the title"),
        ("UPDATE about SET value = '' WHERE name = 'title'", "with the title"),
        ("DELETE FROM about", "without title"),
        ("UPDATE about SET value = 'x' WHERE name = 'grammar'", "has changed"),
        ("UPDATE about SET value = zeroblob(5) WHERE name = 'seed'", "without seed"),
        ("UPDATE about SET value = '-5' WHERE name = 'seed'", "seed -1"),
        ("UPDATE about SET value = '99999999999999999999' WHERE name = 'seed'", "seed 9999"),
        ("UPDATE about SET value = '²' WHERE name = 'size'", "-1 models"),
        ("UPDATE about SET value = '1000000' WHERE name = 'size'", "1000000 models"),
        ("UPDATE about SET value = '../x' WHERE name = 'suffix'", "file about '../x' files"),
    ],
)
def test_broken_files_are_refused_in_words(tmp_path: Path, statement: str, expected: str):
    path = change(begun(tmp_path / "s.db", 10, 20, 30), statement)
    with pytest.raises(AssetError, match=expected) as caught:
        Store.open(path)
    assert len(str(caught.value)) < 700


def test_times_do_not_matter(tmp_path: Path):
    path = change(begun(tmp_path / "s.db", 10), "UPDATE events SET time = 'soon'")
    with closing(Store.open(path)) as store:
        assert store.record.num_labels == 1


def test_half_a_file_is_refused(tmp_path: Path):
    path = begun(tmp_path / "s.db", *[1] * 80)
    whole = path.read_bytes()
    refused = 0
    for size in range(512, len(whole), 1777):
        path.write_bytes(whole[:size])
        try:
            Store.open(path).close()
        except AssetError:
            refused += 1
    assert refused > 3


def test_a_locked_file_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(store_module, "LOCK_SECONDS", 0.05)
    path = begun(tmp_path / "s.db", 10)
    with closing(Store.open(path)) as store, closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(AssetError, match=r"locked.*another program"):
            store.append("undo", {})
        assert store.record.num_labels == 1
        other.execute("ROLLBACK")
        store.append("undo", {})
        assert store.record.num_labels == 0


def test_bodies_are_json(tmp_path: Path):
    path = begun(tmp_path / "s.db", 10)
    with closing(sqlite3.connect(path)) as connection:
        rows: list[Any] = connection.execute("SELECT number, kind, body FROM events").fetchall()
        application = connection.execute("PRAGMA application_id").fetchone()
    assert rows[0][:2] == (1, "score")
    assert json.loads(rows[0][2]) == {"factor": "overall", "models": ["g5-0"], "score": 10}
    assert application == (APPLICATION,)
