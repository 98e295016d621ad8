"""Waiting in tests: for a condition, as long as a busy machine may need; never for a fixed time."""

from __future__ import annotations

import time
from collections.abc import Callable

PATIENCE = 600.0
"""Seconds until a test gives up."""


def wait_until(
    holds: Callable[[], object], why: Callable[[], object] = lambda: "what was expected did not come"
) -> None:
    """Returns as soon as something holds; fails with what `why` says when it does not come to hold."""
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end, why()
        time.sleep(0.02)
