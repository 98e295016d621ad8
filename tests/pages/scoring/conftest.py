"""What tests of sessions share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from grammarlab.pages.scoring.session import Session
from tests.pages.scoring.tower import TOWER


@pytest.fixture
def rules(tmp_path: Path) -> str:
    path = tmp_path / "tower.cga"
    path.write_text(TOWER)
    return str(path)


@pytest.fixture
def session(tmp_path: Path, rules: str) -> Iterator[Session]:
    with closing(Session(rules, tmp_path / "towers.db", seed=3, size=200, jobs=0)) as session:
        yield session
