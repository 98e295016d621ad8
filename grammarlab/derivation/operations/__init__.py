"""Operations of CGA, one family per file."""

from grammarlab.derivation.operations import alignment, appearance, insertion, neutral, scattering, scope, texturing
from grammarlab.derivation.operations.faces import components, extrusion, planar, roofs
from grammarlab.derivation.operations.splitting import splits

OPERATIONS = {
    **alignment.OPERATIONS,
    **appearance.OPERATIONS,
    **extrusion.OPERATIONS,
    **insertion.OPERATIONS,
    **neutral.OPERATIONS,
    **planar.OPERATIONS,
    **roofs.OPERATIONS,
    **scope.OPERATIONS,
    **texturing.OPERATIONS,
}
"""Operations without a block, by name."""

BLOCKS = {**components.BLOCKS, **planar.BLOCKS, **scattering.BLOCKS, **splits.BLOCKS}
"""Operations with a block, by name."""

CHANGE_LOOKS = neutral.CHANGE_LOOKS
"""Ignored operations that no shape depends on."""

LEFT_OUT = frozenset(neutral.OPERATIONS)
"""All ignored operations."""
