"""What JAX has compiled is kept on disk: the next session does not wait for it again."""

from __future__ import annotations

import os
import platform

from platformdirs import user_cache_path

_WORTH_KEEPING = "0.1"
"""Seconds of compiling."""


def keep_compiled() -> None:
    """Names the folder to JAX, which reads the environment when it is loaded; what a person has set there stays.

    Each machine has a folder of its own, since what is compiled for one processor may not run on another.
    """
    folder = user_cache_path("grammarlab") / "compiled" / (platform.node() or "here")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(folder))
        os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", _WORTH_KEEPING)
