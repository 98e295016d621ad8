"""Requests of windows and their answers.

A request is ``{"id": 7, "command": "score", …}`` with binary buffers; the answer has the same id and either
``"ok": true, "result": {…}`` with buffers, or ``"ok": false, "error": "…"``. Requests are foreign: every value is
checked.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, TypeVar

from grammarlab.errors import GrammarlabError, UsageError, shown
from grammarlab.pages.windows import Answer, Message, Refuse, Send

MAX_TEXT = 200
"""Characters of a name or a search."""


@dataclass(frozen=True)
class Request:
    """One request of a window."""

    values: Mapping[str, Any]
    buffers: Sequence[bytes]
    window: Send
    answer: Answer
    refuse: Refuse

    def text(self, name: str, default: str | None = None) -> str:
        """A text argument.

        Raises:
            UsageError: If it has another type.
        """
        value = self.values.get(name, default)
        if not isinstance(value, str) or len(value) > MAX_TEXT:
            raise UsageError(f"{name}: expected a text of at most {MAX_TEXT} characters, found {shown(value)}.")
        return value

    def integer(self, name: str, low: int, high: int, default: int) -> int:
        """A whole number.

        Raises:
            UsageError: If it is not a whole number, or out of range.
        """
        value = self.values.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise UsageError(f"{name}: expected a whole number from {low} to {high}, found {shown(value)}.")
        return value

    def one_of(self, name: str, values: Sequence[str], default: str | None = None) -> str:
        """A text argument with few possible values.

        Raises:
            UsageError: If it has another value, or none and there is no default.
        """
        text = self.text(name, default)
        if text not in values:
            raise UsageError(f"{name}: expected one of {', '.join(values)}, found {shown(text)}.")
        return text

    def number(self, name: str) -> float:
        """A finite number.

        Raises:
            UsageError: If it has another type.
        """
        value = self.values.get(name)
        if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > 1e300 or not isfinite(value):
            raise UsageError(f"{name}: expected a number, found {shown(value)}.")
        return float(value)


Subject = TypeVar("Subject")
"""Subject of commands, such as a session."""


def run_request(
    commands: Mapping[str, Callable[[Subject, Request], Message | None]],
    subject: Subject,
    message: object,
    buffers: Sequence[bytes],
    window: Send,
) -> None:
    """Run a request of a window, and answer, now or later.

    Args:
        commands: commands by name; those without a result send their own answer.
        subject: subject of the commands.
        message: any value.
        buffers: binary buffers of the message.
        window: receives the answer.
    """
    values = message if isinstance(message, dict) else {}
    number = values.get("id") if isinstance(values.get("id"), int | str | None) else None

    def answer(result: Message, answer_buffers: Sequence[bytes] = ()) -> None:
        window({"id": number, "ok": True, "result": result}, answer_buffers)

    def refuse(error: str) -> None:
        window({"id": number, "ok": False, "error": error}, ())

    try:
        result = _command(commands, values)(subject, Request(values, buffers, window, answer, refuse))
        if result is not None:
            answer(result)
    except (GrammarlabError, OSError) as error:
        refuse(str(error))
    except Exception as error:  # a bug must not end the session
        traceback.print_exc()
        refuse(unexpected(error))


def unexpected(error: Exception) -> str:
    """Message about a bug."""
    return f"unexpected {type(error).__name__}: {error}. Please report it."


def _command(
    commands: Mapping[str, Callable[[Subject, Request], Message | None]], values: Mapping[str, Any]
) -> Callable[[Subject, Request], Message | None]:
    name = values.get("command")
    if not isinstance(name, str) or name not in commands:
        raise UsageError(f"command: expected one of {', '.join(commands)}, found {shown(name)}.")
    return commands[name]
