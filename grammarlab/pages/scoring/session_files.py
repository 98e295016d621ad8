"""Files of a session: export and import of labels, the learned grammar, samples of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.pages.desktop import Answer, Message, Refuse
from grammarlab.pages.scoring.desk import SessionDesk
from grammarlab.pages.workers.tasks import (
    DrawSheet,
    LabelledFactors,
    LearnedFile,
    LearnGrammar,
    ReadLabels,
    WriteLabels,
)
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool

Result = Callable[[Any], tuple[Message, Sequence[bytes]]]
"""JSON of a value in an answer, with its buffers."""
Announce = Callable[[str, str, int, int], None]
"""Tells all windows what is being done, its stage, and how much of that is done."""


class SessionFiles:
    """Files, written and read in a worker process. All methods are for one thread."""

    def __init__(self, desk: SessionDesk, path: Path, makers: WorkerPool, announce: Announce) -> None:
        """Start for a desk; `path` is that of the session file."""
        self._desk, self._path, self._makers, self._announce = desk, path, makers, announce

    def export(self, suffix: str, answer: Answer, refuse: Refuse) -> None:
        """Export all scores as a label file."""
        file = f"{self._path.stem}{suffix}"
        done = partial(answered, answer, refuse, lambda content: ({"file": file}, [content]))
        self._makers.submit(WriteLabels(self._desk.factors, suffix), done)

    def read(self, content: bytes, suffix: str, answer: Answer, refuse: Refuse) -> None:
        """Import the scores of a label file; one undo reverts all of them."""

        def add(outcome: TaskOutcome) -> None:
            try:
                if outcome.value is None:
                    raise UsageError(outcome.error)
                labels: LabelledFactors = outcome.value
                entries = {
                    name: {subject: said.as_json() for subject, said in scores.items()}
                    for name, scores in labels.factors.items()
                }
                self._desk.do("import", {"scores": entries})
                notes: Message = {"notes": list(labels.notes)} if labels.notes else {}
                answer({"added": sum(map(len, labels.factors.values())), **notes}, ())
            except GrammarlabError as error:
                refuse(str(error))

        self._makers.submit(ReadLabels(content, suffix), add)

    def learn_grammar(self, answer: Answer, refuse: Refuse) -> None:
        """Learn a grammar from all scores, into a file beside the session."""

        def result(found: LearnedFile) -> tuple[Message, Sequence[bytes]]:
            numbers = {"js": found.js, "rules_before": found.rules_before, "rules_after": found.rules_after}
            return {"file": found.file, "text": found.text, "notes": list(found.findings), **numbers}, ()

        done = partial(answered, answer, refuse, result)
        task = LearnGrammar(self._desk.factors, self._desk.record.wide)
        self._makers.submit(task, done, on_progress=partial(self._announce, "learn"))

    def sheet(self, num: int, answer: Answer, refuse: Refuse) -> None:
        """Draw samples of the learned grammar."""
        file = f"{self._path.stem}-learned.png"
        done = partial(answered, answer, refuse, lambda content: ({"file": file}, [content]))
        task = DrawSheet(num, self._desk.store.about.seed)
        self._makers.submit(task, done, on_progress=partial(self._announce, "sheet"))

    def close(self) -> None:
        """End the process."""
        self._makers.close()


def answered(answer: Answer, refuse: Refuse, result: Result, outcome: TaskOutcome) -> None:
    """Answer a window with the result of a process, or with the reason of its failure."""
    if outcome.value is None:
        refuse(outcome.error or "cancelled.")
    else:
        answer(*result(outcome.value))
