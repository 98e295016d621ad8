"""The operations of CGA, one family a file."""

from grammarlab.derivation.operations import (
    alignment,
    appearance,
    components,
    extrusion,
    insertion,
    planar,
    scope,
    splits,
)

OPERATIONS = {
    **alignment.OPERATIONS,
    **appearance.OPERATIONS,
    **extrusion.OPERATIONS,
    **insertion.OPERATIONS,
    **planar.OPERATIONS,
    **scope.OPERATIONS,
}
"""Operations without a block, by name."""

BLOCKS = {**components.BLOCKS, **planar.BLOCKS, **splits.BLOCKS}
"""Operations with a block, by name."""
