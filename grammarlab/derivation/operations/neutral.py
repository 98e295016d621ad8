"""Operations that change normals, or the division of a surface into faces, but not the surface.

They are accepted and have no effect: concave faces are cut when they are drawn. Later operations may depend
on the division into faces, and on no other effect of these operations; `grammarlab check` warns of each use.
"""

from __future__ import annotations

from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.language.vocabulary.keywords import KEYWORDS

_WORDS = frozenset[str]().union(*KEYWORDS.values())
_OF_FACES = ("cleanupGeometry", "convexify")
_OF_LOOKS = ("setNormals", "setupUV", "softenNormals")


def unchanged(call: BoundCall) -> Shapes:
    """The unchanged shapes."""
    return call.shapes


OPERATIONS: dict[str, Operation] = {name: Operation(unchanged, _WORDS, (0, 9)) for name in (*_OF_FACES, *_OF_LOOKS)}
CHANGE_LOOKS = frozenset(_OF_LOOKS)
"""Operations that no later shape depends on."""
