"""Operations of CGA, one family per file."""

from grammarlab.derivation.operations import (
    alignment,
    appearance,
    area_splits,
    cleaning,
    comp,
    enveloping,
    extrusion,
    insertion,
    outlines,
    roofing,
    scattering,
    scope,
    setbacks,
    shading_normals,
    split,
    tagging,
    texturing,
    uv_insertion,
)

OPERATIONS = {
    **alignment.OPERATIONS,
    **appearance.OPERATIONS,
    **cleaning.OPERATIONS,
    **enveloping.OPERATIONS,
    **extrusion.OPERATIONS,
    **insertion.OPERATIONS,
    **appearance.NEUTRAL,
    **outlines.OPERATIONS,
    **roofing.OPERATIONS,
    **scope.OPERATIONS,
    **shading_normals.OPERATIONS,
    **tagging.OPERATIONS,
    **texturing.OPERATIONS,
    **uv_insertion.OPERATIONS,
}
"""Operations without a block, by name."""

BLOCKS = {
    **area_splits.BLOCKS,
    **comp.BLOCKS,
    **outlines.BLOCKS,
    **scattering.BLOCKS,
    **setbacks.BLOCKS,
    **split.BLOCKS,
}
"""Operations with a block, by name."""

LEFT_OUT = frozenset(appearance.NEUTRAL)
"""Ignored operations, which no later shape depends on."""
