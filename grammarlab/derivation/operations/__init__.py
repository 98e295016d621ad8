"""The operations of CGA, one family a file."""

from grammarlab.derivation.operations import (
    alignment,
    appearance,
    components,
    extrusion,
    insertion,
    neutral,
    planar,
    roofs,
    scope,
    splits,
)

OPERATIONS = {
    **alignment.OPERATIONS,
    **appearance.OPERATIONS,
    **extrusion.OPERATIONS,
    **insertion.OPERATIONS,
    **neutral.OPERATIONS,
    **planar.OPERATIONS,
    **roofs.OPERATIONS,
    **scope.OPERATIONS,
}
"""Operations without a block, by name."""

BLOCKS = {**components.BLOCKS, **planar.BLOCKS, **splits.BLOCKS}
"""Operations with a block, by name."""

WITHOUT_EFFECT = frozenset(neutral.OPERATIONS)
"""Operations that are read and then left out."""
