"""Built-in functions and shape attributes, one family a file."""

from grammarlab.derivation.functions import attributes, colors, coordinates, files, geometry, lists, maths, random, text

BUILTINS = {
    **maths.BUILTINS,
    **random.BUILTINS,
    **text.BUILTINS,
    **lists.BUILTINS,
    **colors.BUILTINS,
    **coordinates.BUILTINS,
    **files.BUILTINS,
    **geometry.BUILTINS,
}
"""Every built-in function by name."""

SHAPE_ATTRIBUTES = attributes.SHAPE_ATTRIBUTES
"""Every shape attribute by name."""
