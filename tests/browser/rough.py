"""The command line with rough pictures on its scoring page: they are there and in their places, in a tenth of the time.

``python -m tests.browser.rough score toy``. Tests of pictures are elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.pages.workers.worker_pool import Handler, WorkerPool

if TYPE_CHECKING:
    from grammarlab.rendering.camera import Camera
    from grammarlab.rendering.raycast import RaycastRenderer
    from grammarlab.rendering.renderer import RenderOptions
    from grammarlab.scene import TriangleBatch

SIDE = 8
"""Pixels along each side of a square of one colour."""


@dataclass
class RoughPool(WorkerPool):
    """Processes of `artist`, whatever they were to make."""

    def __post_init__(self) -> None:
        self.make = "tests.browser.rough:artist"


def artist(*arguments: Any) -> Handler:
    """The worker that draws, which takes one sample in full light for a square of pixels."""
    from grammarlab.pages.workers import artist as exact
    from grammarlab.rendering.raycast import RaycastRenderer

    drawn = RaycastRenderer.render

    def rough(self: RaycastRenderer, batch: TriangleBatch, camera: Camera, options: RenderOptions) -> NDArray[np.uint8]:
        width, height = max(options.width // SIDE, 1), max(options.height // SIDE, 1)
        small = drawn(self, batch, camera, replace(options, width=width, height=height, samples=1, openness_rays=0))
        rows, columns = np.arange(options.height) * height, np.arange(options.width) * width
        return small[np.ix_(rows // options.height, columns // options.width)]

    RaycastRenderer.render = rough
    return exact.artist(*arguments)


def main() -> None:
    """Run the command line."""
    from grammarlab import cli
    from grammarlab.pages.scoring import session

    session.WorkerPool = RoughPool  # ty: ignore[invalid-assignment]
    cli.main()


if __name__ == "__main__":
    main()
