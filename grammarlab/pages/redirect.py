"""A private file that leads a browser to a page.

The address of a page has its token, and arguments of a process are seen by every user of a machine. So a browser is
started with the path of a file that only this user can read.
"""

from __future__ import annotations

import html
import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_CONTENT = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0;url={address}">
<title>grammarlab</title>
</head>
<body><a href="{address}">Open the page</a></body>
</html>
"""
_SNAP_DESKTOP = re.compile(r"([a-z0-9-]+)_[\w.-]+\.desktop")
"""Desktop file of an application of a snap."""
_SECONDS = 5.0
"""Time for the desktop's answer which browser it uses."""


@contextmanager
def redirect(address: str) -> Iterator[Path]:
    """The file, of mode 0600, until the context ends.

    Raises:
        OSError: If the file cannot be written.
    """
    with private_page(_CONTENT.format(address=html.escape(address))) as file:
        yield file


@contextmanager
def private_page(content: str) -> Iterator[Path]:
    """A file with a page, of mode 0600, where the browser may read it, until the context ends.

    Raises:
        OSError: If the file cannot be written.
    """
    handle, name = tempfile.mkstemp(prefix="grammarlab-", suffix=".html", dir=_folder())
    os.close(handle)
    try:
        Path(name).write_text(content, encoding="utf-8")
        yield Path(name)
    finally:
        Path(name).unlink(missing_ok=True)


def _folder() -> Path | None:
    """A folder that the browser may read: the user's runtime folder, or None for the one of temporary files.

    Browsers in snaps read neither of them; each has a folder of its own below ``~/snap``.
    """
    snap = _SNAP_DESKTOP.fullmatch(_default_browser())
    if snap and (common := Path.home() / "snap" / snap[1] / "common").is_dir():
        return common
    runtime = Path(os.environ.get("XDG_RUNTIME_DIR") or "/nowhere")
    return runtime if runtime.is_absolute() and os.access(runtime, os.W_OK | os.X_OK) else None


def _default_browser() -> str:
    """Name of the desktop file of the browser, or empty."""
    try:
        answer = subprocess.run(
            ["xdg-settings", "get", "default-web-browser"],  # noqa: S607
            capture_output=True,
            text=True,
            timeout=_SECONDS,
            check=False,
        )
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return ""
    return answer.stdout.strip()
