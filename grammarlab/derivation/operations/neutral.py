"""Operations that change normals, or how a surface is cut into faces, but not where it is.

They are accepted and have no effect: concave faces are cut where they are drawn. What is derived afterwards may depend
on how a surface is cut into faces, and on nothing else of this; `grammarlab check` says so of each use.
"""

from __future__ import annotations

from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.language.vocabulary.keywords import KEYWORDS

_WORDS = frozenset[str]().union(*KEYWORDS.values())
_OF_FACES = ("cleanupGeometry", "convexify")
_OF_LOOKS = ("setNormals", "setupUV", "softenNormals")


def unchanged(call: BoundCall) -> Shapes:
    """The shapes as they are."""
    return call.shapes


OPERATIONS: dict[str, Operation] = {name: Operation(unchanged, _WORDS, (0, 9)) for name in (*_OF_FACES, *_OF_LOOKS)}
CHANGE_LOOKS = frozenset(_OF_LOOKS)
"""Those that no shape derived afterwards depends on."""
