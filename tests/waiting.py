"""Waiting in tests: for a condition, as long as a busy machine may need; never for a fixed time."""

from __future__ import annotations

import time
from collections.abc import Callable

_REFERENCE = 0.05
"""Seconds of the loop of `slowness` on an idle machine with Python 3.11."""


def slowness() -> float:
    """How many times longer a loop takes now than on an idle machine of the reference, at least 1 and at most 4."""
    start, total = time.monotonic(), 0
    for number in range(1_000_000):
        total += number * number % 7
    return min(max((time.monotonic() - start) / _REFERENCE, 1.0), 4.0)


PATIENCE = 90.0 * slowness()
"""Seconds until a test gives up: below two minutes, longer on a slow or busy machine, never above six minutes."""


def wait_until(
    holds: Callable[[], object], why: Callable[[], object] = lambda: "what was expected did not come"
) -> None:
    """Returns as soon as something holds; fails with what `why` says when it does not come to hold."""
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end, why()
        time.sleep(0.02)
