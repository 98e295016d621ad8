"""Programs that hear Ctrl-C, however the tests were started.

A shell without job control starts what runs in its background with SIGINT ignored, and every child inherits that.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Literal

_LAUNCH = """
import os, signal, sys
signal.signal(signal.SIGINT, getattr(signal, sys.argv[1]))
os.execvp(sys.argv[2], sys.argv[2:])
"""


def with_sigint(handling: Literal["SIG_DFL", "SIG_IGN"], command: Sequence[object]) -> list[str]:
    """A command that begins with SIGINT handled as it says; its process is that of the command itself."""
    return [sys.executable, "-I", "-S", "-c", _LAUNCH, handling, *map(str, command)]
