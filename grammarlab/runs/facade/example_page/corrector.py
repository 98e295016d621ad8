"""Session for the correction of an example by several windows."""

from __future__ import annotations

from pathlib import Path

from grammarlab.runs.facade.example_page.commands import run, state_of
from grammarlab.runs.facade.example_page.desk import ExampleDesk
from grammarlab.runs.serving.desktop import Desktop


class Corrector(Desktop[ExampleDesk]):
    """An example corrected by several windows; see `grammarlab.runs.facade.example_page.commands`."""

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
