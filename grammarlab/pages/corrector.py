"""Session and page that correct an example in several windows."""

from __future__ import annotations

from pathlib import Path

from grammarlab.pages.desktop import Desktop
from grammarlab.pages.example_commands import COMMANDS, state_of
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
        desk = ExampleDesk.open(file, output or Path(f"{file.stem}.example.json"))
        super().__init__(lambda _: desk, COMMANDS, state_of)
