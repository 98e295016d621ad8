"""Messages from a session to its windows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

Message = dict[str, Any]
Argument: TypeAlias = str | float | bool | Sequence["Argument"] | Mapping[str, "Argument"] | None
"""A value of a request, as JSON has it."""
Send = Callable[[Message, Sequence[bytes]], None]
"""Sends a message and binary buffers to one window. Called on the session's thread; it must not block."""
Answer = Callable[[Message, Sequence[bytes]], None]
"""Send the result of a command."""
Refuse = Callable[[str], None]
"""Send the reason why there is no result."""
PROTOCOL = 1
"""Version of commands and states, which a page compares with its own."""
