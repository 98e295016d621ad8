"""Session files: SQLite databases of append-only events.

Committed events survive the end of the process and of the machine (WAL, synchronous=FULL). Several processes may
have one file open: each reads the events of the others before it writes. A file is not trusted until it has been
checked: another layout of its tables, or an impossible event, is an error.
"""

from __future__ import annotations

import json
import re
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from grammarlab.errors import AssetError, UsageError, shown
from grammarlab.language.grammar import hash_of
from grammarlab.pages.record.events import Event, Record
from grammarlab.pages.record.model_grids import Body
from grammarlab.runs.sample.domains import DEFAULT

SUFFIX = ".db"
APPLICATION = 0x6C41B5C0
"""Application id of the file in SQLite."""
STEPS = (
    """
    CREATE TABLE about (name TEXT PRIMARY KEY, value TEXT NOT NULL);
    CREATE TABLE events (number INTEGER PRIMARY KEY, time REAL NOT NULL, kind TEXT NOT NULL, body TEXT NOT NULL);
    """,
)
"""Migrations from each version of the tables to the next, beginning with an empty file."""
MAX_FILE_BYTES = 1 << 30
"""Largest size of a session file in bytes."""
MAX_TEXT = 8 << 20
"""Largest number of characters of one value in a file."""
MAX_EVENTS = 1_000_000
"""Largest number of events of a session."""
TITLE = re.compile(r"[\w ().-]{1,200}")
KIND = re.compile(r"\.\w{1,32}")
LOCK_SECONDS = 5.0
"""Seconds to wait for another process that is writing."""

_SCHEMA = "SELECT type, name, tbl_name, sql FROM sqlite_master WHERE name NOT LIKE 'sqlite_%' ORDER BY name"
_EXPECTED_ABOUT = ("title", "grammar", "hash", "seed", "size")


@dataclass(frozen=True, slots=True)
class About:
    """Subject of a session."""

    title: str
    """Name of the grammar: letters, digits, spaces and ``().-_``, since file names contain it."""
    grammar: str
    """Text of the file that describes the models."""
    seed: int
    """Seed of the pool, 0 <= seed < 2**64."""
    size: int
    """Size of the pool."""
    suffix: str = DEFAULT
    """Suffix of its domain (`grammarlab.runs.sample.domains`)."""

    @property
    def hash(self) -> str:
        """SHA-256 of the text: `Grammar.hash`."""
        return hash_of(self.grammar)


class Store:
    """An open session file with its state. For one thread."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        """Use `Store.open`."""
        self._path = path
        self._connection = connection
        self.about = About("", "", 0, 0)
        self.record = Record()
        self._version = -1

    @classmethod
    def open(cls, path: Path, begin: About | None = None) -> Store:
        """Open a session file.

        Args:
            path: the file.
            begin: subject of a new file if there is none; None if the file must exist.

        Raises:
            AssetError: If the file is not a session, is broken, was written by a newer version, or cannot be
                opened.
        """
        if path.exists() and not path.is_file():
            raise AssetError(f"{path}: expected a session file, found a folder or a device.")
        if begin is None and not path.is_file():
            raise AssetError(f"{path}: no such session file.")
        if path.is_file() and path.stat().st_size > MAX_FILE_BYTES:
            raise AssetError(f"{path}: larger than {MAX_FILE_BYTES >> 20} MiB, so it is not a session file.")
        with _explained(path):
            connection = sqlite3.connect(path, timeout=LOCK_SECONDS, isolation_level=None, check_same_thread=False)
        store = cls(path, connection)
        try:
            store._start(begin)
        except BaseException:
            connection.close()
            raise
        return store

    def append(self, kind: str, body: Body | Callable[[Record], Body]) -> Event:
        """Add an event; it is on disk when this returns.

        Args:
            kind: kind of the event.
            body: body of the event, or a function that makes it from the current record.

        Raises:
            UsageError: If it is not possible now, perhaps because of events of another process.
            AssetError: If it cannot be written; then nothing changes.
        """
        with self._transaction():
            self._read()
            values: Body = body(self.record) if callable(body) else body  # ty: ignore[invalid-assignment]
            self.record.check(kind, values)
            text = json.dumps(values, separators=(",", ":"), allow_nan=False)
            if self.record.revision >= MAX_EVENTS or len(text) > MAX_TEXT:
                raise UsageError(f"{self._path}: too much for one session; export the labels and begin another.")
            event = Event(self.record.revision + 1, time.time(), kind, values)
            self._connection.execute(
                "INSERT INTO events VALUES (?, ?, ?, ?)", (event.number, event.time, event.kind, text)
            )
        self.record.apply(event)
        return event

    def poll(self) -> bool:
        """Read new events of other processes; returns whether there were any.

        Raises:
            AssetError: If the file cannot be read.
        """
        with _explained(self._path):
            version = self._connection.execute("PRAGMA data_version").fetchone()[0]
        if version == self._version:
            return False
        self._version = version
        before = self.record.revision
        self._read()
        return self.record.revision > before

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def _start(self, begin: About | None) -> None:
        with _explained(self._path):
            self._connection.execute("PRAGMA trusted_schema = OFF")
            self._connection.execute("PRAGMA cell_size_check = ON")
            is_new = self._check(allow_new=begin is not None)
            if is_new:
                self._connection.execute("PRAGMA journal_mode = WAL")
            self._connection.execute("PRAGMA synchronous = FULL")
        if is_new or self._schema_version() < len(STEPS):
            self._migrate(begin)
        self.about = self._read_about()
        self._read()

    def _check(self, *, allow_new: bool) -> bool:
        """Whether the file is new; raises an error if it is neither new nor a session."""
        tables = self._connection.execute(_SCHEMA).fetchmany(16)
        application = self._connection.execute("PRAGMA application_id").fetchone()[0]
        if not tables and not application and allow_new:
            return True
        if application != APPLICATION:
            raise AssetError(f"{self._path}: a database, but not a session file; give the name of another file.")
        version = self._schema_version()
        if version > len(STEPS):
            raise AssetError(
                f"{self._path}: written by a newer version of grammarlab (tables of version {version}, known up to "
                f"{len(STEPS)}). Update grammarlab to open it."
            )
        if version < 1 or tables != _tables(version):
            raise AssetError(f"{self._path}: its tables are not those of a session file.")
        return False

    def _schema_version(self) -> int:
        return self._connection.execute("PRAGMA user_version").fetchone()[0]

    def _migrate(self, begin: About | None) -> None:
        """Upgrade the tables in one transaction."""
        with self._transaction():
            # Another process may just have done so.
            version = self._schema_version()
            for step in STEPS[version:]:
                _execute(self._connection, step)
            if version == 0 and begin is not None:
                self._connection.execute(f"PRAGMA application_id = {APPLICATION}")
                values = {"title": begin.title, "grammar": begin.grammar, "hash": begin.hash}
                values |= {"seed": str(begin.seed), "size": str(begin.size), "suffix": begin.suffix}
                self._connection.executemany("INSERT INTO about VALUES (?, ?)", values.items())
            self._connection.execute(f"PRAGMA user_version = {len(STEPS)}")

    def _read_about(self) -> About:
        with _explained(self._path):
            rows = self._connection.execute(
                "SELECT name, value FROM about WHERE typeof(value) = 'text' AND length(value) <= ?", (MAX_TEXT,)
            )
            values: dict[str, str] = dict(rows.fetchmany(64))
        missing = [name for name in _EXPECTED_ABOUT if name not in values]
        if missing:
            raise AssetError(f"{self._path}: a session file without {', '.join(missing)}; it is broken.")
        seed, size = (_whole(values[name]) for name in ("seed", "size"))
        if not 0 <= seed < 1 << 64 or not 1 <= size <= 100_000:
            raise AssetError(f"{self._path}: a session file with seed {seed} and {size} models; it is broken.")
        if not TITLE.fullmatch(values["title"]):
            raise AssetError(f"{self._path}: a session file with the title {shown(values['title'])}; it is broken.")
        suffix = values.get("suffix", DEFAULT)  # earlier versions knew one only
        if not KIND.fullmatch(suffix):
            raise AssetError(f"{self._path}: a session file about {shown(suffix)} files; it is broken.")
        about = About(values["title"], values["grammar"], seed, size, suffix)
        # Earlier versions hashed the text with the line ends of its file.
        verbatim_hash = sha256(about.grammar.encode("utf-8", "surrogatepass")).hexdigest()
        if values["hash"] not in (about.hash, verbatim_hash):
            raise AssetError(f"{self._path}: the grammar in it has changed; the file is broken.")
        return about

    def _read(self) -> None:
        """Read the events that are not known yet."""
        with _explained(self._path):
            rows = self._connection.execute(
                "SELECT number, time, kind, CASE WHEN typeof(body) = 'text' AND length(body) <= ? THEN body END "
                "FROM events WHERE number > ? ORDER BY number LIMIT ?",
                (MAX_TEXT, self.record.revision, MAX_EVENTS + 1),
            )
            for number, when, kind, text in rows:
                self._add(number, when, kind, text)

    def _add(self, number: int, when: object, kind: str, text: str | None) -> None:
        if number != self.record.revision + 1 or number > MAX_EVENTS:
            raise AssetError(f"{self._path}: event {number}: expected {self.record.revision + 1}. The file is broken.")
        try:
            body = json.loads(text or "", parse_constant=_no_constant)
            self.record.apply(Event(number, when if isinstance(when, float) else 0.0, kind, body))
        except (UsageError, ValueError, RecursionError) as error:
            reason = error if isinstance(error, UsageError) else f"expected JSON, found {shown(text)}."
            raise AssetError(f"{self._path}: event {number}: {reason} The file is broken.") from error

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """Exclusive write transaction."""
        with _explained(self._path):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield
                self._connection.execute("COMMIT")
            except BaseException:
                if self._connection.in_transaction:
                    self._connection.execute("ROLLBACK")
                raise


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """SQLite's errors in words."""
    try:
        yield
    except (sqlite3.Error, sqlite3.Warning, OverflowError, UnicodeError) as error:
        text = str(error)
        if "not a database" in text or "malformed" in text:
            raise AssetError(f"{path}: not a session file, or a broken one ({text}).") from error
        hint = " Is another program writing to it?" if "locked" in text else ""
        raise AssetError(f"{path}: cannot be used ({text}).{hint}") from error


def _tables(version: int) -> list[tuple[str, str, str, str]]:
    """The tables of a version, from SQLite's schema."""
    with closing(sqlite3.connect(":memory:")) as connection:
        for step in STEPS[:version]:
            _execute(connection, step)
        return connection.execute(_SCHEMA).fetchall()


def _execute(connection: sqlite3.Connection, step: str) -> None:
    for statement in filter(str.strip, step.split(";")):
        connection.execute(statement.strip())


def _whole(text: str) -> int:
    return int(text) if len(text) <= 20 and text.isascii() and text.isdigit() else -1


def _no_constant(name: str) -> float:
    raise ValueError(name)
