"""Scenes of fewer triangles, for models seen from afar."""

from __future__ import annotations

from grammarlab.scene.instances import Scene

PLAIN_TRIANGLES = 300
"""Most triangles of a model of level ``plain``."""
BLOCK_TRIANGLES = 30
"""Most triangles of a model of level ``block``."""


def simplified(scene: Scene, most_triangles: int) -> Scene:
    """Each model of a scene as its largest walls and roofs, within its bounding box.

    Args:
        scene: B models.
        most_triangles: largest number of triangles of a model, at least 24.

    Returns:
        B models in one instance per wall or roof, each of the mean colour of what it replaces. The same for a model
        alone and in a batch.
    """
    raise NotImplementedError
