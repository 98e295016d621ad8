"""Cache on disk of functions compiled by JAX, so that the next session does not compile them again."""

from __future__ import annotations

import os
import platform

from platformdirs import user_cache_path

_MIN_COMPILE_SECONDS = "0.1"
"""Shortest time of compilation, in seconds, of a function that is cached."""


def keep_compiled() -> None:
    """Set the cache folder of JAX in the environment, before JAX is imported; variables set by the user stay.

    Each machine has its own folder, since code compiled for one processor may not run on another.
    """
    folder = user_cache_path("grammarlab") / "compiled" / (platform.node() or "here")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(folder))
        os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", _MIN_COMPILE_SECONDS)
