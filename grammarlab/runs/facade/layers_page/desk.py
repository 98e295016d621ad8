"""What is on a person's desk: the text of a design with its history, the layouts that are shown, its file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path

from grammarlab.errors import Finding, LanguageError, UsageError
from grammarlab.export.save import save
from grammarlab.facade.layers.designs.design import Design
from grammarlab.facade.layers.designs.file import parse_design
from grammarlab.facade.layers.showing.relief import relief
from grammarlab.facade.layers.solving import Layout
from grammarlab.files import write_text
from grammarlab.runs.facade.editor.exporting import FORMATS, export, unused_path
from grammarlab.runs.facade.editor.exporting import SUFFIX as FACADE_SUFFIX
from grammarlab.runs.facade.editor.history import History
from grammarlab.runs.facade.layers import SolvedLayout
from grammarlab.runs.facade.layers_page.following import Key, followed, key_of, shown
from grammarlab.runs.facade.layers_page.solver import Job, SolverOutcome
from grammarlab.runs.facade.layers_page.text import same_but_canvas, with_canvas

SUFFIX = ".toml"
COUNT = 5
"""Layouts that stand beside each other."""
_KNOWN, _OUTCOMES = 40, 200
"""Layouts that may follow a canvas, and canvases whose layouts are remembered."""
_EDIT = "edit the text"

Canvas = tuple[float, float]
"""Width and height, metres."""


@dataclass(frozen=True, eq=False)
class ShownLayouts:
    """Layouts of a design, best first; at least one."""

    design: Design
    canvas: Canvas
    found: tuple[SolvedLayout, ...]


@dataclass(frozen=True, eq=False)
class Waiting:
    """A canvas that is wished for, and that no known layout follows to."""

    canvas: Canvas
    answer: Callable[[str], None]
    """Gets why it cannot be, or nothing when it has been done."""


@dataclass
class DesignDesk:
    """Where everything lies; commands change it, and count up `revision` when they do."""

    title: str
    target: Path
    """The file that it is saved to."""
    history: History[str]
    """Of texts, each of which is a design."""
    first: str
    """As it was opened."""
    saved: str | None
    """What is in the target; None for what is not ours to say."""
    want: Callable[[Job], None] = lambda _: None
    """Has layouts solved for, the latest wish first; outcomes are given to `solved`."""
    tell_better: Callable[[], None] = lambda: None
    """Says that more is known about a canvas on the way."""
    shown: ShownLayouts | None = None
    """The last good layouts."""
    chosen: Key | None = None
    """The layout that was chosen; None for the best."""
    conflict: str = ""
    """Why the design as it is has no layouts."""
    draft: str | None = None
    """Text with mistakes that a person is at."""
    mistakes: tuple[Finding, ...] = ()
    revision: int = 0
    _design: tuple[str, Design] | None = None
    _known: list[Layout] = field(default_factory=list)
    """Of the design, for any canvas, the latest first."""
    _outcomes: dict[Canvas, SolverOutcome] = field(default_factory=dict)
    """Of the design."""
    _wished: tuple[Canvas, tuple[int, ...]] | None = None
    _waiting: Waiting | None = None
    _exported: dict[str, Path] = field(default_factory=dict)
    """By format."""

    @property
    def text(self) -> str:
        """Of the design as it is now."""
        return self.history.present

    @property
    def design(self) -> Design:
        """As it is now."""
        if self._design is None or self._design[0] != self.text:
            self._design = self.text, parse_design(self.text)
        return self._design[1]

    @property
    def canvas(self) -> Canvas:
        """As it is now."""
        return self.design.width, self.design.height

    @property
    def is_saved(self) -> bool:
        """Whether the target holds the text as it is now."""
        return self.draft is None and self.saved == self.text

    @property
    def is_lost(self) -> bool:
        """Whether no file holds the text as it is now."""
        return not self.is_saved and (self.draft is not None or self.text != self.first)

    @property
    def is_solving(self) -> bool:
        """Whether better layouts may come."""
        return not _is_complete(self._outcomes.get(self.canvas))

    @property
    def current(self) -> SolvedLayout:
        """The layout that is shown large.

        Raises:
            UsageError: when there is none yet.
        """
        if self.shown is None:
            raise UsageError(self.conflict or "There is no layout yet.")
        return self.shown.found[self.chosen_of(self.shown.found)]

    def chosen_of(self, found: Sequence[SolvedLayout]) -> int:
        """Which of some layouts is the chosen one, else the best."""
        keys = [key_of(each.layout) for each in found]
        return keys.index(self.chosen) if self.chosen in keys else 0

    def begin(self) -> None:
        """Solves for the first layouts."""
        self._wish(self.canvas, 1, COUNT)

    def do(self, words: str, text: str) -> None:
        """A step that can be undone.

        Raises:
            LanguageError: for a text that is not a design.
        """
        parse_design(text)
        before = self.design
        self.draft, self.mistakes = None, ()
        past = self.history.past
        if words == _EDIT and past and past[-1][0] == _EDIT and not self.history.future:
            self.history.present = text  # one text after the other is one step
        elif text != self.text:
            self.history.do(words, text)
        self._changed(before)

    def step(self, take: Callable[[], str]) -> str:
        """Undo or redo, and its words."""
        before, words = self.design, take()
        self.draft, self.mistakes = None, ()
        self._changed(before)
        return words

    def edit(self, text: str) -> None:
        """What a person has typed; a text with mistakes changes nothing else."""
        try:
            self.do(_EDIT, text)
        except LanguageError as error:
            self.draft, self.mistakes = text, error.findings
            self.revision += 1

    def drag(self, canvas: Canvas) -> tuple[list[SolvedLayout], str]:
        """The layouts that follow to a canvas best, or why there are none; nothing is kept.

        Better ones are looked for meanwhile.
        """
        if self._waiting is None:
            self._wish(canvas, *((1, COUNT) if canvas == self.canvas else (1,)))
        outcome = self._outcomes.get(canvas)
        found = self._followed(canvas)
        return found, "" if found or outcome is None else outcome.error

    def resize(self, canvas: Canvas, answer: Callable[[str], None]) -> None:
        """Another canvas, at once where a known layout follows to it, else once it is solved."""
        self._drop_waiting()
        found, error = self.drag(canvas)
        if found:
            self._resized(canvas)
        if found or error:
            answer(error)
        else:
            self._waiting = Waiting(canvas, answer)

    def choose(self, number: int) -> None:
        """Shows one of the layouts."""
        if self.shown is None or not 0 <= number < len(self.shown.found):
            raise UsageError("These layouts are gone; choose from the new ones.")
        self.chosen = key_of(self.shown.found[number].layout)
        self.revision += 1

    def solved(self, outcome: SolverOutcome) -> None:
        """Takes what the solver has found; of a design that is gone nothing is kept."""
        job, canvas = outcome.job, (outcome.job.width, outcome.job.height)
        if not same_but_canvas(job.design, self.design):
            return
        self._outcomes.pop(canvas, None)
        self._outcomes = dict(islice({canvas: outcome, **self._outcomes}.items(), _OUTCOMES))
        known = {key_of(each): each for each in (*outcome.layouts, *self._known)}
        self._known = list(islice(known.values(), _KNOWN))
        if self._waiting and self._waiting.canvas == canvas:
            waiting, self._waiting = self._waiting, None
            if outcome.layouts:
                self._resized(canvas)
            waiting.answer(outcome.error)
        elif canvas == self.canvas:
            self._show()
            self.revision += 1
        else:
            self.tell_better()

    def save(self) -> None:
        """On disk when it returns, whole or not at all.

        Raises:
            UsageError: when what was typed last has mistakes: such a file could not be opened again.
        """
        if self.draft is not None:
            raise UsageError(f"Mend the text before it is saved: {self.mistakes[0].message}.")
        text = self.text
        write_text(self.target, text)
        self.saved = text
        self.revision += 1

    def export(self, kind: str) -> Path:
        """The layout that is shown as a file beside the target; only what was exported before is replaced.

        Raises:
            UsageError: for an unknown kind.
        """
        if kind not in FORMATS:
            raise UsageError(f"format: expected one of {', '.join(FORMATS)}, found {kind!r}.")
        current = self.current
        path = self._exported.get(kind) or unused_path(self.target, FACADE_SUFFIX if kind == "json" else f".{kind}")
        if kind in {"glb", "obj"}:
            save(relief(current.design, current.panels), path)
        else:
            export(current.facade, path)
        self._exported[kind] = path
        return path

    def rescue(self) -> Path:
        """Writes what is not saved into a new file beside the target."""
        path = unused_path(self.target, f".unsaved{SUFFIX}")
        write_text(path, self.text if self.draft is None else self.draft)
        return path

    def _resized(self, canvas: Canvas) -> None:
        width, height = canvas
        self.do(f"{width:.2f} × {height:.2f} m", with_canvas(self.text, width, height))

    def _changed(self, before: Design) -> None:
        """Another text: its layouts are shown as far as they are known, and solved for."""
        self._drop_waiting()
        if not same_but_canvas(before, self.design):
            self._known, self._outcomes, self._wished, self.chosen = [], {}, None, None
        self._wish(self.canvas, 1, COUNT)
        self._show()
        self.revision += 1

    def _show(self) -> None:
        """The best that is known of the design as it is; else the last good ones stay."""
        found = self._followed(self.canvas)
        if found:
            self.shown = ShownLayouts(self.design, self.canvas, tuple(found))
        outcome = self._outcomes.get(self.canvas)
        self.conflict = "" if found or outcome is None else outcome.error

    def _followed(self, canvas: Canvas) -> list[SolvedLayout]:
        """Layouts of a canvas: those that were solved for, then the latest others that follow."""
        outcome, design = self._outcomes.get(canvas), self.design
        solved = list(outcome.layouts) if outcome else []
        keys = {key_of(each) for each in solved}
        others = sorted(
            (each for each in self._known if key_of(each) not in keys), key=lambda each: key_of(each) != self.chosen
        )
        if not _is_complete(outcome):
            solved += followed(design, others[: COUNT - len(solved)], *canvas)
        return [shown(design, each, *canvas) for each in solved]

    def _wish(self, canvas: Canvas, *counts: int) -> None:
        outcome = self._outcomes.get(canvas)
        wished = canvas, tuple(each for each in counts if outcome is None or (outcome.layouts and each > outcome.count))
        if wished[1] and wished != self._wished:
            self.want(Job(replace(self.design, width=canvas[0], height=canvas[1]), *canvas, wished[1]))
        self._wished = wished

    def _drop_waiting(self) -> None:
        if self._waiting is not None:
            waiting, self._waiting = self._waiting, None
            waiting.answer("Something else was done meanwhile.")


def _is_complete(outcome: SolverOutcome | None) -> bool:
    """Whether nothing better may come."""
    return outcome is not None and (outcome.count >= COUNT or not outcome.layouts)
