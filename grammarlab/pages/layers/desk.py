"""State of a design session: text and history, visible layouts, file.

Layouts adapted to a dragged canvas: alignments are kept, only sizes are solved for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path

from grammarlab.errors import Finding, LanguageError, UsageError
from grammarlab.export.save import save
from grammarlab.files import rewrite_text, write_text
from grammarlab.layers.design import Design
from grammarlab.layers.file import parse_design
from grammarlab.layers.panels import flattened, panels_of, relief
from grammarlab.layers.solving import Layout
from grammarlab.layers.symbol_sizes import size_letters
from grammarlab.layers.words import STRETCH
from grammarlab.pages.editor.exporting import FORMATS, export, unused_path
from grammarlab.pages.editor.exporting import SUFFIX as FACADE_SUFFIX
from grammarlab.pages.editor.history import History
from grammarlab.pages.layers.solver import Job, SolverOutcome
from grammarlab.pages.layers.text_edits import same_but_canvas, with_canvas
from grammarlab.runs.facade.layer_files import SolvedLayout

Key = tuple[object, ...]
"""Key of a layout, independent of the canvas."""


def key_of(layout: Layout) -> Key:
    """A key that is equal for layouts of a design that differ only in sizes."""
    return tuple((group, each.words, each.cells) for group, each in layout.alignments.items())


def followed(design: Design, known: Sequence[Layout], width: float, height: float) -> list[Layout]:
    """Known layouts on another canvas, those of least energy first; without those with too much stretching.

    Better layouts are possible, so none is proven.

    Args:
        design: the design of the layouts.
        known: layouts for canvases of any size.
        width: metres.
        height: metres.
    """
    found = []
    for layout in known:
        alignments = [(each, (width, height)[axis]) for (axis, _), each in layout.alignments.items()]
        sizing = size_letters(alignments, gaps=design.overhang)
        if sizing is None or not _close(design, sizing.sizes):
            continue
        paid = sum(each.energy for each, _ in alignments)
        energy = paid + design.weights.sizing * sizing.error
        found.append(replace(layout, sizing=sizing, energy=energy, bound=0.0, proven=False))
    return sorted(found, key=lambda layout: layout.energy)


def shown(design: Design, layout: Layout, width: float, height: float) -> SolvedLayout:
    """A layout with its panels on its canvas."""
    start = time.perf_counter()
    panels = panels_of(design, layout, width, height)
    return SolvedLayout(design, layout, panels, flattened(panels), time.perf_counter() - start)


def _close(design: Design, sizes: Mapping[str, float]) -> bool:
    """Whether no symbol is more than `STRETCH` times larger or smaller than its preferred size."""
    wished = {name: design.symbols[name].size for name in sizes}
    return all(size is None or size / STRETCH <= sizes[name] <= size * STRETCH for name, size in wished.items())


SUFFIX = ".toml"
COUNT = 5
"""Number of layouts side by side."""
_KNOWN, _OUTCOMES = 40, 200
"""Largest number of layouts that are adapted to a canvas, and of canvases whose layouts are cached."""
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
    """A requested canvas to which no known layout can be adapted."""

    canvas: Canvas
    answer: Callable[[str], None]
    """Receives the reason why it is impossible, or an empty text when it is done."""


@dataclass
class DesignDesk:
    """The state; commands change it and then increment `revision`."""

    title: str
    target: Path
    """The file to save to."""
    history: History[str]
    """History of texts, each of which is a valid design."""
    first: str
    """The text when it was opened."""
    saved: str | None
    """Content of the target; None if it is unknown."""
    want: Callable[[Job], None] = lambda _: None
    """Requests layouts, the latest job first; outcomes are given to `solved`."""
    tell_better: Callable[[], None] = lambda: None
    """Notifies windows of more data on a dragged canvas."""
    shown: ShownLayouts | None = None
    """The last valid layouts."""
    chosen: Key | None = None
    """Key of the chosen layout; None for the best."""
    conflict: str = ""
    """Reason why the current design has no layouts."""
    draft: str | None = None
    """Text with mistakes that a person is editing."""
    mistakes: tuple[Finding, ...] = ()
    revision: int = 0
    _design: tuple[str, Design] | None = None
    _known: list[Layout] = field(default_factory=list)
    """Layouts of the design, for any canvas, the latest first."""
    _outcomes: dict[Canvas, SolverOutcome] = field(default_factory=dict)
    """Outcomes for the design, by canvas."""
    _wished: tuple[Canvas, tuple[int, ...]] | None = None
    _waiting: Waiting | None = None
    _exported: dict[str, Path] = field(default_factory=dict)
    """Exported files by format."""

    @property
    def text(self) -> str:
        """Text of the current design."""
        return self.history.present

    @property
    def design(self) -> Design:
        """The current design."""
        if self._design is None or self._design[0] != self.text:
            self._design = self.text, parse_design(self.text)
        return self._design[1]

    @property
    def canvas(self) -> Canvas:
        """The current canvas."""
        return self.design.width, self.design.height

    @property
    def is_saved(self) -> bool:
        """Whether the target holds the current text."""
        return self.draft is None and self.saved == self.text

    @property
    def is_lost(self) -> bool:
        """Whether no file holds the current text."""
        return not self.is_saved and (self.draft is not None or self.text != self.first)

    @property
    def is_solving(self) -> bool:
        """Whether better layouts are possible."""
        return not _is_complete(self._outcomes.get(self.canvas))

    @property
    def current(self) -> SolvedLayout:
        """The layout in the large view.

        Raises:
            UsageError: If there is none yet.
        """
        if self.shown is None:
            raise UsageError(self.conflict or "There is no layout yet.")
        return self.shown.found[self.chosen_of(self.shown.found)]

    def chosen_of(self, found: Sequence[SolvedLayout]) -> int:
        """Index of the chosen layout among some, or of the best one."""
        keys = [key_of(each.layout) for each in found]
        return keys.index(self.chosen) if self.chosen in keys else 0

    def begin(self) -> None:
        """Requests the first layouts."""
        self._wish(self.canvas, 1, COUNT)

    def do(self, words: str, text: str) -> None:
        """Performs a step that can be undone.

        Raises:
            LanguageError: If a text is not a design.
        """
        parse_design(text)
        before = self.design
        self.draft, self.mistakes = None, ()
        past = self.history.past
        if words == _EDIT and past and past[-1][0] == _EDIT and not self.history.future:
            self.history.present = text  # consecutive texts are one step
        elif text != self.text:
            self.history.do(words, text)
        self._changed(before)

    def step(self, take: Callable[[], str]) -> str:
        """Undoes or redoes a step; returns its description."""
        before, words = self.design, take()
        self.draft, self.mistakes = None, ()
        self._changed(before)
        return words

    def edit(self, text: str) -> None:
        """Sets the typed text; a text with mistakes changes nothing else."""
        try:
            self.do(_EDIT, text)
        except LanguageError as error:
            self.draft, self.mistakes = text, error.findings
            self.revision += 1

    def drag(self, canvas: Canvas) -> tuple[list[SolvedLayout], str]:
        """The layouts that are best adapted to a canvas, or the reason why there are none; nothing is stored.

        Better ones are requested at the same time.
        """
        if self._waiting is None:
            self._wish(canvas, *((1, COUNT) if canvas == self.canvas else (1,)))
        outcome = self._outcomes.get(canvas)
        found = self._followed(canvas)
        return found, "" if found or outcome is None else outcome.error

    def resize(self, canvas: Canvas, answer: Callable[[str], None]) -> None:
        """Sets another canvas, at once if a known layout can be adapted to it, otherwise once it is solved."""
        self._drop_waiting()
        found, error = self.drag(canvas)
        if found:
            self._resized(canvas)
        if found or error:
            answer(error)
        else:
            self._waiting = Waiting(canvas, answer)

    def choose(self, number: int) -> None:
        """Selects one of the layouts."""
        if self.shown is None or not 0 <= number < len(self.shown.found):
            raise UsageError("These layouts are out of date; choose from the new ones.")
        self.chosen = key_of(self.shown.found[number].layout)
        self.revision += 1

    def solved(self, outcome: SolverOutcome) -> None:
        """Takes an outcome of the solver; outcomes of earlier designs are dropped."""
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
        """Saves the text atomically.

        Raises:
            UsageError: If the last typed text has mistakes, since such a file could not be opened again.
        """
        if self.draft is not None:
            raise UsageError(f"Correct the text before saving it: {self.mistakes[0].message}.")
        text = self.text
        rewrite_text(self.target, text)
        self.saved = text
        self.revision += 1

    def export(self, kind: str) -> Path:
        """The visible layout as a file beside the target; only previous exports are replaced.

        Raises:
            UsageError: If the kind is unknown.
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
        """Saves unsaved changes to a new file beside the target."""
        path = unused_path(self.target, f".unsaved{SUFFIX}")
        write_text(path, self.text if self.draft is None else self.draft)
        return path

    def _resized(self, canvas: Canvas) -> None:
        width, height = canvas
        self.do(f"{width:.2f} × {height:.2f} m", with_canvas(self.text, width, height))

    def _changed(self, before: Design) -> None:
        """Handles another text: known layouts of it are shown, and new ones requested."""
        self._drop_waiting()
        if not same_but_canvas(before, self.design):
            self._known, self._outcomes, self._wished, self.chosen = [], {}, None, None
        self._wish(self.canvas, 1, COUNT)
        self._show()
        self.revision += 1

    def _show(self) -> None:
        """Shows the best known layouts of the current design; if there are none, the last valid ones stay."""
        found = self._followed(self.canvas)
        if found:
            self.shown = ShownLayouts(self.design, self.canvas, tuple(found))
        outcome = self._outcomes.get(self.canvas)
        self.conflict = "" if found or outcome is None else outcome.error

    def _followed(self, canvas: Canvas) -> list[SolvedLayout]:
        """Layouts of a canvas: solved ones, then the latest others that can be adapted."""
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
            waiting.answer("Another change came first.")


def _is_complete(outcome: SolverOutcome | None) -> bool:
    """Whether no better layouts are possible."""
    return outcome is not None and (outcome.count >= COUNT or not outcome.layouts)
