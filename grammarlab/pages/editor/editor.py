"""Editing a facade.

The page that edits a facade, over HTTP and a WebSocket.
"""

from __future__ import annotations

from pathlib import Path

from grammarlab.errors import FacadeError
from grammarlab.facade.file import load_locked
from grammarlab.pages.desktop import Desktop
from grammarlab.pages.editor.commands import run
from grammarlab.pages.editor.desk import EditorDesk, state_of
from grammarlab.pages.editor.exporting import SUFFIX, checked_target, stem_of, unused_path
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
        target = checked_target(output) if output else unused_path(Path(f"{stem_of(file)}.edited.json"), SUFFIX)
        super().__init__(EditorDesk.of(facade, file, target, locks), run, state_of)
