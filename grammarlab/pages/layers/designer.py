"""A session on a design of layers, and the page of it."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from grammarlab.layers.file import MOST_BYTES, parse_design, read_design_text
from grammarlab.pages.desktop import Desktop
from grammarlab.pages.editor.exporting import checked_target, stem_of, unused_path
from grammarlab.pages.editor.history import History
from grammarlab.pages.layers.commands import run
from grammarlab.pages.layers.desk import SUFFIX, DesignDesk
from grammarlab.pages.layers.shown import state_of
from grammarlab.pages.layers.solver import Solver, SolverOutcome
from grammarlab.pages.server import built_page

# JSON may need six characters for one of the text.
PAGE = built_page("layers", "grammarlab facade open", max_bytes=6 * MOST_BYTES)


class Designer(Desktop[DesignDesk]):
    """A design edited by several windows; see `grammarlab.pages.layers.commands`."""

    def __init__(self, file: Path, output: Path | None = None) -> None:
        """Opens a design, and starts to lay it out.

        Args:
            file: read only, unless it is also the output.
            output: file to save to; a new file in the current folder when left out.

        Raises:
            LanguageError: If the design has a mistake; with line and column.
            UsageError: If the output is not a valid file name.
        """
        text = read_design_text(file)
        parse_design(text, file.name)
        target = (
            checked_target(output, SUFFIX) if output else unused_path(Path(f"{stem_of(file)}.edited{SUFFIX}"), SUFFIX)
        )
        is_there = target.exists() and target.samefile(file)
        desk = DesignDesk(
            title=stem_of(file), target=target, history=History(text), first=text, saved=text if is_there else None
        )
        super().__init__(desk, run, state_of)
        self._solver = Solver(self._take)
        desk.want = self._solver.want
        desk.tell_better = partial(self.tell, {"event": "better"})
        self.post(desk.begin)

    def close(self) -> None:
        """Ends it after all previous requests."""
        self._solver.close()
        super().close()

    def _take(self, outcome: SolverOutcome) -> None:
        self.post(partial(self.desk.solved, outcome))
