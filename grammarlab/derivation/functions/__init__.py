"""Built-in functions and shape attributes, one family per file."""

from grammarlab.derivation.functions import arrays, colors, files, fitting, lists, maths, ramps, random, text
from grammarlab.derivation.functions.shapes import attributes, coordinates, geometry, texture_coordinates

BUILTINS = {
    **maths.BUILTINS,
    **random.BUILTINS,
    **text.BUILTINS,
    **arrays.BUILTINS,
    **lists.BUILTINS,
    **colors.BUILTINS,
    **ramps.BUILTINS,
    **coordinates.BUILTINS,
    **files.BUILTINS,
    **fitting.BUILTINS,
    **geometry.BUILTINS,
    **texture_coordinates.BUILTINS,
}
"""Every built-in function by name."""

SHAPE_ATTRIBUTES = attributes.SHAPE_ATTRIBUTES
"""Every shape attribute by name."""
