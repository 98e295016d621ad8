"""Which processes a process has started, and whether they have ended."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from tests.waiting import wait_until


def is_running(pid: int) -> bool:
    """Whether there is such a process that has not ended."""
    return (_status(pid) or ["Z"])[0] != "Z"


def descendants(pid: int) -> set[int]:
    """What a process has started, and what that has started."""
    parents = {int(path.name): status for path in Path("/proc").glob("[0-9]*") if (status := _status(int(path.name)))}
    found: set[int] = set()
    new = {pid}
    while new:
        new = {child for child, status in parents.items() if int(status[1]) in new}
        found |= new
    return found


def expect_gone(pids: Iterable[int]) -> None:
    """Waits until processes have ended by themselves."""
    pids = tuple(pids)
    wait_until(lambda: not any(map(is_running, pids)), lambda: [pid for pid in pids if is_running(pid)])


def _status(pid: int) -> list[str]:
    """State, parent and more; nothing where there is no such process."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []
