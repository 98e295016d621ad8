"""Session for the correction of an example by several windows.

The page that corrects an example, over HTTP and a WebSocket.
"""

from __future__ import annotations

from pathlib import Path

from grammarlab.pages.desktop import Desktop
from grammarlab.pages.example_commands import run, state_of
from grammarlab.pages.example_desk import ExampleDesk
from grammarlab.pages.server import built_page

PAGE = built_page("example", "grammarlab facade open", max_bytes=64 << 10)


class Corrector(Desktop[ExampleDesk]):
    """An example corrected by several windows; see `grammarlab.pages.example_commands`."""

    def __init__(self, file: Path, output: Path | None = None) -> None:
        """Opens the mesh of a building.

        Args:
            file: read only.
            output: where corrections are saved; `NAME.example.json` in the current folder when left out. Existing
                corrections are loaded.

        Raises:
            FacadeError: If the file cannot be read or has no units.
        """
        super().__init__(ExampleDesk.of(file, output or Path(f"{file.stem}.example.json")), run, state_of)
