"""Choice of the renderer: the requested one, or the best one that works on this machine."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from grammarlab.errors import UsageError

if TYPE_CHECKING:  # runs without pictures need no renderer
    from grammarlab.rendering.renderer import AbstractRenderer

RendererName = Literal["auto", "cast", "gl"]
"""``cast`` is ray casting, ``gl`` is OpenGL, ``auto`` is OpenGL if it works, otherwise ray casting."""

PLATFORMS = ("egl", "osmesa")
"""Ways to use OpenGL without a window, best first."""
TRIAL_SECONDS = 40.0
"""Default timeout of the test of OpenGL, in seconds."""


@dataclass(frozen=True, slots=True)
class RendererChoice:
    """A renderer that works on this machine; it can be sent to other processes."""

    name: Literal["cast", "gl"]
    platform: str = ""
    """Platform for ``gl``: the one of `PLATFORMS` that works."""
    driver: str = ""
    """Name and version of the driver for ``gl``."""

    def make(self) -> AbstractRenderer:
        """The renderer."""
        if self.name == "gl":
            from grammarlab.rendering.rasterize import OpenGLRenderer  # noqa: PLC0415

            return OpenGLRenderer(self.platform)
        from grammarlab.rendering.raycast import RaycastRenderer  # noqa: PLC0415

        return RaycastRenderer()


def choose(name: RendererName, timeout: float = TRIAL_SECONDS) -> RendererChoice:
    """Renderer by name. OpenGL is tested in another process first, which takes a second or two.

    Args:
        name: name of the renderer, see `RendererName`.
        timeout: timeout of the test of OpenGL, in seconds.

    Raises:
        UsageError: If OpenGL was requested and does not work here.
    """
    if name == "cast":
        return RendererChoice("cast")
    end = time.monotonic() + timeout
    reasons = []
    for platform in PLATFORMS:
        driver, reason = _try(platform, end - time.monotonic())
        if driver:
            return RendererChoice("gl", platform, driver)
        reasons.append(f"{platform}: {reason}")
    if name == "auto":
        return RendererChoice("cast")
    raise UsageError(
        f"OpenGL does not work here ({'; '.join(reasons)}). It needs `pip install 'grammarlab[gl]'` and a driver with "
        "EGL or OSMesa (Debian: libegl1 or libosmesa6). The renderer 'cast' needs neither."
    )


def _try(platform: str, timeout: float) -> tuple[str, str]:
    """Driver of a platform if it works, otherwise empty and the reason."""
    if timeout <= 0:
        return "", "no time left to try it"
    # The test process must find the same package.
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path or str(Path.cwd()) for path in sys.path)}
    try:
        done = subprocess.run(  # noqa: S603 - our own interpreter and module
            [sys.executable or "python3", "-P", "-m", "grammarlab.rendering.trial", platform],
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=timeout,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "", f"no answer within {timeout:.0f} seconds"
    except OSError as error:
        return "", str(error)
    lines = [line for line in done.stdout.decode(errors="replace").splitlines() if line.strip()]
    if done.returncode == 0 and lines:
        return lines[-1], ""
    return "", _reason(done.stderr.decode(errors="replace"), done.returncode)


def _reason(stderr: str, code: int) -> str:
    """The last line of a traceback, or a text about the exit code."""
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    return lines[-1][:200] if lines else f"ended with code {code}"
