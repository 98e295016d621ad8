"""The operations of CGA, one family a file."""

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
"""Operations that are left out, and that no shape depends on."""

LEFT_OUT = frozenset(neutral.OPERATIONS)
"""All operations that are read and then left out."""
