"""Durations of stages, in seconds."""

from __future__ import annotations

import time


class Clock:
    """Measures consecutive stages."""

    def __init__(self) -> None:
        self._last = time.perf_counter()
        self.seconds: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        """Ends a stage, which began with the end of the previous one."""
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._last
        self._last = now
