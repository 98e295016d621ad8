"""Session and page that edit a facade in several windows."""

from __future__ import annotations

from pathlib import Path

from grammarlab.errors import FacadeError
from grammarlab.facade.file import load_locked
from grammarlab.pages.desk import opened_target
from grammarlab.pages.desktop import Desktop
from grammarlab.pages.editor.commands import COMMANDS
from grammarlab.pages.editor.desk import SUFFIX, EditorDesk, state_of
from grammarlab.pages.server import built_page

PAGE = built_page("editor", "grammarlab facade open", max_bytes=64 << 10)
MOST_LEAVES = 20_000
"""Largest number of leaves of a facade on the page."""


class Editor(Desktop[EditorDesk]):
    """A facade edited by several windows; `grammarlab.pages.editor.commands` has their requests."""

    def __init__(self, file: Path, output: Path | None = None) -> None:
        """Opens the file of a facade.

        Args:
            file: read only, unless it is also the output.
            output: file to save to; a new file in the current folder when left out.

        Raises:
            FacadeError: If the file is not a facade, or too large for the page.
            UsageError: If the output is not a valid file name.
        """
        facade, locks = load_locked(file)
        if len(facade.leaves) > MOST_LEAVES:
            raise FacadeError(
                f"{file.name}: {len(facade.leaves):,} leaves; expected at most {MOST_LEAVES:,} on the page. "
                "grammarlab facade edit supports larger ones."
            )
        target, is_target = opened_target(file, output, ".json", SUFFIX)
        desk = EditorDesk(facade, file, target, locks, is_target=is_target)
        super().__init__(lambda _: desk, COMMANDS, state_of)
