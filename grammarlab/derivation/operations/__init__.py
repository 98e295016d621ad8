"""The operations of CGA, one family a file."""

from grammarlab.derivation.operations import (
    alignment,
    appearance,
    components,
    extrusion,
    insertion,
    planar,
    roofs,
    scope,
    splits,
    textures,
)

OPERATIONS = {
    **alignment.OPERATIONS,
    **appearance.OPERATIONS,
    **extrusion.OPERATIONS,
    **insertion.OPERATIONS,
    **planar.OPERATIONS,
    **roofs.OPERATIONS,
    **scope.OPERATIONS,
    **textures.OPERATIONS,
}
"""Operations without a block, by name."""

BLOCKS = {**components.BLOCKS, **planar.BLOCKS, **splits.BLOCKS}
"""Operations with a block, by name."""

WITHOUT_EFFECT = frozenset(textures.OPERATIONS)
"""Operations that are read and then left out."""
