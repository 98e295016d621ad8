"""Operations that change texture coordinates, or how a surface is cut into faces, but not where it is.

They are accepted and have no effect: images are projected along the world's axes when a model is written, concave
faces are cut where they are drawn. `grammarlab check` lists these operations as not supported.
"""

from __future__ import annotations

from grammarlab.derivation.calls import Call, Operation
from grammarlab.derivation.shapes import Shapes
from grammarlab.language.keywords import KEYWORDS

_WORDS = frozenset[str]().union(*KEYWORDS.values())
_NAMES = (
    "cleanupGeometry",
    "convexify",
    "copyUV",
    "deleteUV",
    "normalizeUV",
    "offsetUV",
    "projectUV",
    "rotateUV",
    "scaleUV",
    "setNormals",
    "setupProjection",
    "setupUV",
    "softenNormals",
    "tileUV",
    "translateUV",
)


def unchanged(call: Call) -> Shapes:
    """The shapes as they are."""
    return call.shapes


OPERATIONS: dict[str, Operation] = {name: Operation(unchanged, _WORDS, (0, 9)) for name in _NAMES}
