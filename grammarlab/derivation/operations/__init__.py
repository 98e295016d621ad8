"""The operations of CGA, one family a file."""

from grammarlab.derivation.operations import alignment, appearance, components, extrusion, insertion, scope, splits

OPERATIONS = {
    **alignment.OPERATIONS,
    **appearance.OPERATIONS,
    **extrusion.OPERATIONS,
    **insertion.OPERATIONS,
    **scope.OPERATIONS,
}
"""Operations without a block, by name."""

BLOCKS = {**components.BLOCKS, **splits.BLOCKS}
"""Operations with a block, by name."""
