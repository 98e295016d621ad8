"""What every format offers: a file that models are added to, one after the other."""

from __future__ import annotations

import abc
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.scene import Scene, TriangleBatch

GENERATOR = "grammarlab"


class AbstractWriter(abc.ABC):
    """One file in the making. It depends on the models and their order, and not on how they came in batches."""

    @abc.abstractmethod
    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """Add one model.

        Args:
            scene: the model.
            batch: its triangles.
            name: what it is called in the file.
            offset: [3] where its coordinates begin, in metres from the origin of the file.

        Raises:
            AssetError: a texture is unusable.
        """

    @abc.abstractmethod
    def finish(self) -> tuple[Path, ...]:
        """Write what is not yet written, after the last model.

        Returns:
            Further files beside the file.
        """
