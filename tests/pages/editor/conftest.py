"""An editor of a small facade."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from grammarlab.facade.file import save_facade
from grammarlab.pages.editor.editor import Editor
from tests.facade.samples import windows
from tests.pages.editor.windows import Window


@pytest.fixture
def editor(tmp_path: Path) -> Iterator[Editor]:
    """Of two rows of three windows, one grid."""
    running = Editor(save_facade(windows(2, 3), tmp_path / "wall.json"), tmp_path / "edited.json")
    yield running
    running.close()


@pytest.fixture
def window(editor: Editor) -> Window:
    return Window(editor)
