"""A session on a design of layers, and the page of it."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from grammarlab.layers.file import MOST_BYTES, parse_design, read_design_text
from grammarlab.pages.desk import opened_target
from grammarlab.pages.desktop import DeskHooks, Desktop
from grammarlab.pages.layers.commands import COMMANDS
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
        target, is_target = opened_target(file, output, SUFFIX, SUFFIX)

        def make(desktop: Desktop[DesignDesk]) -> DesignDesk:
            tell_better = partial(desktop.tell, {"event": "better"})
            solver = Solver(partial(_take, desktop))
            return DesignDesk(file, target, text, is_target=is_target, solver=solver, tell_better=tell_better)

        super().__init__(make, COMMANDS, state_of, DeskHooks(close=DesignDesk.close))


def _take(desktop: Desktop[DesignDesk], outcome: SolverOutcome) -> None:
    # The solver may be done before the desk is there, but its outcome is taken later.
    desktop.post(lambda: desktop.desk.take(outcome))
