"""How to go on with a run that has stopped."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass


@dataclass
class Unfinished:
    """How far a run has come; `note` is told, and `advice` says so when the run stops."""

    needs: str = ""
    """Option that makes the command go on; empty where it does so by itself."""
    without: str = ""
    """Option that would make it begin anew."""
    _step: tuple[str, int, int] | None = None

    def note(self, what: str, done: int, total: int) -> None:
        """What is being done, how much of it is finished and how much there is."""
        self._step = what, done, total

    def advice(self) -> str:
        """The command that goes on, with the options that the user gave; empty before anything was begun."""
        if self._step is None:
            return ""
        what, done, total = self._step
        words = [word for word in sys.argv[1:] if word != self.without]
        if self.needs and self.needs not in words:
            words.insert(words.index("--") if "--" in words else len(words), self.needs)
        return f"stopped with {done:,} of {total:,} {what} done; go on with: {shlex.join(['grammarlab', *words])}"
