"""Built-in functions and shape attributes, one family per file."""

from grammarlab.derivation.functions import (
    array_functions,
    asset_fitting,
    asset_functions,
    color_functions,
    number_functions,
    shape_attributes,
    shape_measures,
    shape_textures,
    text_functions,
)

BUILTINS = {
    **number_functions.BUILTINS,
    **text_functions.BUILTINS,
    **array_functions.BUILTINS,
    **color_functions.BUILTINS,
    **shape_attributes.BUILTINS,
    **asset_functions.BUILTINS,
    **asset_fitting.BUILTINS,
    **shape_measures.BUILTINS,
    **shape_textures.BUILTINS,
}
"""Every built-in function by name."""

SHAPE_ATTRIBUTES = shape_attributes.SHAPE_ATTRIBUTES
"""Every shape attribute by name."""
