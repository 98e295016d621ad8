"""Advice for continuing a run that has stopped."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass


@dataclass
class Unfinished:
    """Progress of a run, recorded by `note` and described by `advice` when the run stops."""

    needs: str = ""
    """Option that makes the command continue; empty if it always does."""
    without: str = ""
    """Option that would make the command start again."""
    _step: tuple[str, int, int] | None = None

    def note(self, what: str, done: int, total: int) -> None:
        """Record the name of the task, the number of finished parts, and the number of all parts."""
        self._step = what, done, total

    def advice(self) -> str:
        """The command that continues the run, with the options of the user; empty before the run has begun."""
        if self._step is None:
            return ""
        what, done, total = self._step
        words = [word for word in sys.argv[1:] if word != self.without]
        if self.needs and self.needs not in words:
            words.insert(words.index("--") if "--" in words else len(words), self.needs)
        return f"stopped with {done:,} of {total:,} {what} done; go on with: {shlex.join(['grammarlab', *words])}"
