"""A note about pictures that take longer."""

from __future__ import annotations

import platform

from grammarlab.cli.console.report import say


def note_slow_pictures() -> None:
    """Print a note if pictures are cast without Embree on this machine."""
    from grammarlab.rendering.light.rays import has_embree

    if not has_embree():
        machine = f"{platform.system()} on {platform.machine()}"
        say(
            f"Pictures take about ten times longer here: the package embreex is not installed (for {machine} there may "
            "be none). They are the same as elsewhere. Where OpenGL works, `grammarlab sample --renderer gl` is faster."
        )
