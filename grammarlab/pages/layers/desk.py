"""State of a design session: text and history, visible layouts, file.

Layouts are adapted to a dragged canvas: alignments are kept, only sizes are solved for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
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
from grammarlab.pages.desk import AbstractDocumentDesk, Exports, stem_of
from grammarlab.pages.editor.desk import SUFFIXES, export
from grammarlab.pages.layers.solver import Job, Solver, SolverOutcome
from grammarlab.pages.layers.text_edits import same_but_canvas, with_canvas
from grammarlab.runs.facade.layer_files import SolvedLayout

Canvas = tuple[float, float]
"""Width and height, metres."""
Key = tuple[object, ...]
"""Key of a layout, independent of the canvas."""
SUFFIX = ".toml"
_COUNT = 5
"""Number of layouts side by side."""
_MAX_SOLUTIONS, _MAX_OUTCOMES = 40, 200
"""Largest number of layouts that are adapted to a canvas, and of canvases whose layouts are cached."""
_EDIT = "edit the text"
_parsed = lru_cache(maxsize=8)(parse_design)
"""The design of a text; each text is parsed once, although several steps ask for it."""


class DesignDesk(AbstractDocumentDesk[str]):
    """The text of a design, and its layouts; each text of the history is a valid design."""

    def __init__(
        self,
        file: Path,
        target: Path,
        text: str,
        *,
        is_target: bool = False,
        solver: Solver,
        tell_better: Callable[[], None],
    ) -> None:
        """Request the first layouts of a text.

        Args:
            file: file of the text.
            target: the file to save to.
            text: a valid design.
            is_target: whether the target is that file.
            solver: solves for layouts, the latest job first; its outcomes are given to `take`.
            tell_better: notifies windows of more data on a dragged canvas.
        """
        exports = Exports(SUFFIXES, self._export)
        super().__init__(target, text, saved=text if is_target else None, suffix=SUFFIX, exports=exports)
        self.title, self._solver, self._tell_better = stem_of(file), solver, tell_better
        self.layouts: ShownLayouts | None = None
        """The last valid layouts."""
        self.chosen: Key | None = None
        """Key of the chosen layout; None for the best."""
        self.conflict = ""
        """Reason why the current design has no layouts."""
        self.mistakes: tuple[Finding, ...] = ()
        """Mistakes of the draft."""
        self._solutions: list[Layout] = []
        """Layouts of the design, for any canvas, the latest first."""
        self._outcomes: dict[Canvas, SolverOutcome] = {}
        """Outcomes for the design, by canvas."""
        self._request: tuple[Canvas, tuple[int, ...]] | None = None
        """Canvas and numbers of layouts of the last job."""
        self._waiting: _Waiting | None = None
        self._solve(self.canvas, 1, _COUNT)

    def accept(self, document: str) -> None:
        """Check that a text is a design.

        Raises:
            LanguageError: If it is not.
        """
        _parsed(document)

    def follow(self, previous: str) -> None:
        """Show known layouts of another text, and request new ones."""
        self.mistakes = ()
        self._drop_waiting()
        if not same_but_canvas(_parsed(previous), self.design):
            self._solutions, self._outcomes, self._request, self.chosen = [], {}, None, None
        self._solve(self.canvas, 1, _COUNT)
        self._show()

    def write(self, path: Path, document: str, *, is_new: bool) -> None:
        """Write a text.

        Raises:
            UsageError: If the last typed text has mistakes, since such a file could not be opened again. A new file is
                written in any case.
        """
        if is_new:
            write_text(path, document)
        elif self.draft is not None:
            raise UsageError(f"Correct the text before saving it: {self.mistakes[0].message}.")
        else:
            rewrite_text(path, document)

    def _export(self, path: Path) -> None:
        """Write the layout in the large view."""
        current = self.current
        if path.suffix in {".glb", ".obj"}:
            save(relief(current.design, current.panels), path)
        else:
            export(current.facade, path)

    def close(self) -> None:
        """End the solver."""
        self._solver.close()

    @property
    def design(self) -> Design:
        """The current design."""
        return _parsed(self.document)

    @property
    def canvas(self) -> Canvas:
        """The current canvas."""
        return self.design.width, self.design.height

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
        if self.layouts is None:
            raise UsageError(self.conflict or "There is no layout yet.")
        return self.layouts.solved[self.chosen_of(self.layouts.solved)]

    def chosen_of(self, solved: Sequence[SolvedLayout]) -> int:
        """Index of the chosen layout among some, or of the best one."""
        keys = [_key_of(candidate.layout) for candidate in solved]
        return keys.index(self.chosen) if self.chosen in keys else 0

    def edit(self, text: str) -> None:
        """Sets the typed text; a text with mistakes changes nothing else."""
        try:
            self.do(_EDIT, text, joins=True)
        except LanguageError as error:
            self.draft, self.mistakes = text, error.findings
            self.notify()

    def drag(self, canvas: Canvas) -> tuple[list[SolvedLayout], str]:
        """The layouts that are best adapted to a canvas, or the reason why there are none; nothing is stored.

        Better ones are requested at the same time.
        """
        if self._waiting is None:
            self._solve(canvas, *((1, _COUNT) if canvas == self.canvas else (1,)))
        outcome = self._outcomes.get(canvas)
        solved = self._layouts_on(canvas)
        return solved, "" if solved or outcome is None else outcome.error

    def resize(self, canvas: Canvas, answer: Callable[[str], None]) -> None:
        """Sets another canvas, at once if a known layout can be adapted to it, otherwise once it is solved."""
        self._drop_waiting()
        solved, error = self.drag(canvas)
        if solved:
            self._set_canvas(canvas)
        if solved or error:
            answer(error)
        else:
            self._waiting = _Waiting(canvas, answer)

    def choose(self, number: int) -> None:
        """Selects one of the layouts."""
        if self.layouts is None or not 0 <= number < len(self.layouts.solved):
            raise UsageError("These layouts are out of date; choose from the new ones.")
        self.chosen = _key_of(self.layouts.solved[number].layout)
        self.notify()

    def take(self, outcome: SolverOutcome) -> None:
        """Takes an outcome of the solver; outcomes of earlier designs are dropped."""
        job, canvas = outcome.job, (outcome.job.width, outcome.job.height)
        if not same_but_canvas(job.design, self.design):
            return
        self._outcomes.pop(canvas, None)
        self._outcomes = dict(islice({canvas: outcome, **self._outcomes}.items(), _MAX_OUTCOMES))
        solutions = {_key_of(layout): layout for layout in (*outcome.layouts, *self._solutions)}
        self._solutions = list(islice(solutions.values(), _MAX_SOLUTIONS))
        if self._waiting and self._waiting.canvas == canvas:
            waiting, self._waiting = self._waiting, None
            if outcome.layouts:
                self._set_canvas(canvas)
            waiting.answer(outcome.error)
        elif canvas == self.canvas:
            self._show()
            self.notify()
        else:
            self._tell_better()

    def _set_canvas(self, canvas: Canvas) -> None:
        width, height = canvas
        self.do(f"{width:.2f} × {height:.2f} m", with_canvas(self.document, width, height))

    def _show(self) -> None:
        """Shows the best known layouts of the current design; if there are none, the last valid ones stay."""
        solved = self._layouts_on(self.canvas)
        if solved:
            self.layouts = ShownLayouts(self.design, self.canvas, tuple(solved))
        outcome = self._outcomes.get(self.canvas)
        self.conflict = "" if solved or outcome is None else outcome.error

    def _layouts_on(self, canvas: Canvas) -> list[SolvedLayout]:
        """Layouts of a canvas: solved ones, then the latest others that can be adapted."""
        outcome, design = self._outcomes.get(canvas), self.design
        layouts = list(outcome.layouts) if outcome else []
        keys = {_key_of(layout) for layout in layouts}
        others = [layout for layout in self._solutions if _key_of(layout) not in keys]
        others.sort(key=lambda layout: _key_of(layout) != self.chosen)
        if not _is_complete(outcome):
            layouts += _adapted(design, others[: _COUNT - len(layouts)], *canvas)
        return [_with_panels(design, layout, *canvas) for layout in layouts]

    def _solve(self, canvas: Canvas, *counts: int) -> None:
        """Request layouts, unless they are known or requested already."""
        outcome = self._outcomes.get(canvas)
        unsolved = tuple(count for count in counts if outcome is None or (outcome.layouts and count > outcome.count))
        if unsolved and (canvas, unsolved) != self._request:
            self._solver.submit(Job(replace(self.design, width=canvas[0], height=canvas[1]), *canvas, unsolved))
        self._request = canvas, unsolved

    def _drop_waiting(self) -> None:
        if self._waiting is not None:
            waiting, self._waiting = self._waiting, None
            waiting.answer("Another change came first.")


@dataclass(frozen=True, eq=False)
class ShownLayouts:
    """Layouts of a design, best first; at least one."""

    design: Design
    canvas: Canvas
    solved: tuple[SolvedLayout, ...]


@dataclass(frozen=True, eq=False)
class _Waiting:
    """A requested canvas to which no known layout can be adapted."""

    canvas: Canvas
    answer: Callable[[str], None]
    """Receives the reason why it is impossible, or an empty text when it is done."""


def _is_complete(outcome: SolverOutcome | None) -> bool:
    """Whether no better layouts are possible."""
    return outcome is not None and (outcome.count >= _COUNT or not outcome.layouts)


def _key_of(layout: Layout) -> Key:
    """A key that is equal for layouts of a design that differ only in sizes."""
    return tuple((group, alignment.words, alignment.cells) for group, alignment in layout.alignments.items())


def _adapted(design: Design, layouts: Sequence[Layout], width: float, height: float) -> list[Layout]:
    """Known layouts on another canvas, those of least energy first; without those with too much stretching.

    Better layouts are possible, so none is proven.

    Args:
        design: the design of the layouts.
        layouts: layouts for canvases of any size.
        width: metres.
        height: metres.
    """
    fitting = []
    for layout in layouts:
        alignments = [(alignment, (width, height)[axis]) for (axis, _), alignment in layout.alignments.items()]
        sizing = size_letters(alignments, gaps=design.overhang)
        if sizing is None or not _is_close(design, sizing.sizes):
            continue
        alignment_energy = sum(alignment.energy for alignment, _ in alignments)
        energy = alignment_energy + design.weights.sizing * sizing.error
        fitting.append(replace(layout, sizing=sizing, energy=energy, bound=0.0, proven=False))
    return sorted(fitting, key=lambda layout: layout.energy)


def _is_close(design: Design, sizes: Mapping[str, float]) -> bool:
    """Whether no symbol is more than `STRETCH` times larger or smaller than its preferred size."""
    preferred = {name: design.symbols[name].size for name in sizes}
    return all(size is None or size / STRETCH <= sizes[name] <= size * STRETCH for name, size in preferred.items())


def _with_panels(design: Design, layout: Layout, width: float, height: float) -> SolvedLayout:
    """A layout with its panels on its canvas."""
    start = time.perf_counter()
    panels = panels_of(design, layout, width, height)
    return SolvedLayout(design, layout, panels, flattened(panels), time.perf_counter() - start)
