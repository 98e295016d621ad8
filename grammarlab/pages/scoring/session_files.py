"""Files of a session: export and import of labels, the learned grammar, samples of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.learning.progress_line import LAST_REPORT
from grammarlab.pages.scoring.display import SessionDisplay
from grammarlab.pages.windows import Answer, Message, Refuse
from grammarlab.pages.workers.tasks import (
    DrawSheet,
    LabelledFactors,
    LearnedFile,
    LearnGrammar,
    ReadLabels,
    WriteLabels,
)
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool

FORMATS = ("csv", "jsonl", "parquet")
"""Formats of exported label files."""

Result = Callable[[Any], tuple[Message, Sequence[bytes]]]
"""JSON of a value in an answer, with its buffers."""
Announce = Callable[[str, str, int, int], None]
"""Tells all windows what is being done, its stage, and how much of that is done."""


class SessionFiles:
    """Files, written and read in a worker process. All methods are for one thread."""

    def __init__(self, display: SessionDisplay, path: Path, makers: WorkerPool, announce: Announce) -> None:
        """Start with the record of a session; `path` is that of the session file."""
        self._display, self._path, self._makers, self._announce = display, path, makers, announce
        self._tickets: set[int] = set()
        """Tickets of the grammars that are being learned and the sheets that are being drawn."""

    def export(self, suffix: str, answer: Answer, refuse: Refuse) -> None:
        """Export all scores as a label file."""
        file = f"{self._path.stem}{suffix}"
        done = partial(answer_outcome, answer, refuse, lambda content: ({"file": file}, [content]))
        self._makers.submit(WriteLabels(self._display.factors, suffix), done)

    def read(self, content: bytes, suffix: str, answer: Answer, refuse: Refuse) -> None:
        """Import the scores of a label file; one undo reverts all of them."""

        def add(outcome: TaskOutcome) -> None:
            try:
                if outcome.value is None:
                    raise UsageError(outcome.error)
                labels: LabelledFactors = outcome.value
                entries = {
                    name: {subject: label.as_json() for subject, label in scores.items()}
                    for name, scores in labels.factors.items()
                }
                self._display.do("import", {"scores": entries})
                notes: Message = {"notes": list(labels.notes)} if labels.notes else {}
                answer({"added": sum(map(len, labels.factors.values())), **notes}, ())
            except GrammarlabError as error:
                refuse(str(error))

        self._makers.submit(ReadLabels(content, suffix), add)

    def learn_grammar(self, answer: Answer, refuse: Refuse) -> None:
        """Learn a grammar from all scores, into a file beside the session."""

        def result(learned: LearnedFile) -> tuple[Message, Sequence[bytes]]:
            numbers = {"js": learned.js, "rules_before": learned.rules_before, "rules_after": learned.rules_after}
            return {"file": learned.file, "text": learned.text, "notes": list(learned.findings), **numbers}, ()

        task = LearnGrammar(self._display.factors, self._display.record.wide)
        self._begin(task, "learn", partial(answer_outcome, answer, refuse, result))

    def sheet(self, num: int, answer: Answer, refuse: Refuse) -> None:
        """Draw samples of the learned grammar."""
        file = f"{self._path.stem}-learned.png"
        done = partial(answer_outcome, answer, refuse, lambda content: ({"file": file}, [content]))
        task = DrawSheet(num, self._display.store.about.seed)
        self._begin(task, "sheet", done)

    def _begin(self, task: LearnGrammar | DrawSheet, name: str, done: Callable[[TaskOutcome], None]) -> None:
        """Begin a task that can be cancelled."""

        def end(outcome: TaskOutcome) -> None:
            self._tickets.discard(ticket)
            done(outcome)

        def report(stage: str, done: int, total: int) -> None:
            if (stage, done, total) == LAST_REPORT:
                self._tickets.discard(ticket)
            else:  # another process may do the task again, if the first one has ended unasked
                self._tickets.add(ticket)
            self._announce(name, stage, done, total)

        ticket = self._makers.submit(task, end, on_progress=report)
        self._tickets.add(ticket)

    def cancel(self) -> None:
        """Cancel the grammars and sheets that are being made.

        An earlier file stays as it is, as a rule: the process notices a cancellation at its next report, and reports
        before it writes the file. Once this report is heard, the file is made and the window gets it; a cancellation in
        the moment between the report and its arrival may leave the new file.
        """
        for ticket in tuple(self._tickets):
            self._makers.cancel(ticket)

    def close(self) -> None:
        """End the process."""
        self._makers.close()


def answer_outcome(answer: Answer, refuse: Refuse, result: Result, outcome: TaskOutcome) -> None:
    """Answer a window with the result of a process, or with the reason of its failure."""
    if outcome.value is None:
        refuse(outcome.error or "cancelled.")
    else:
        answer(*result(outcome.value))
