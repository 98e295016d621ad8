"""Built-in functions and shape attributes, one family per file."""

from grammarlab.derivation.functions import (
    array_editing,
    array_functions,
    asset_fitting,
    asset_functions,
    color_functions,
    context_queries,
    file_texts,
    number_functions,
    shape_attributes,
    shape_materials,
    shape_measures,
    shape_tags,
    shape_textures,
    text_functions,
)

BUILTINS = {
    **number_functions.BUILTINS,
    **text_functions.BUILTINS,
    **array_functions.BUILTINS,
    **array_editing.BUILTINS,
    **file_texts.BUILTINS,
    **color_functions.BUILTINS,
    **shape_attributes.BUILTINS,
    **asset_functions.BUILTINS,
    **asset_fitting.BUILTINS,
    **shape_materials.BUILTINS,
    **shape_measures.BUILTINS,
    **shape_tags.BUILTINS,
    **shape_textures.BUILTINS,
    **context_queries.BUILTINS,
}
"""Every built-in function by name."""

GEOMETRY_FREE = frozenset().union(
    number_functions.BUILTINS,
    text_functions.BUILTINS,
    array_functions.BUILTINS,
    array_editing.BUILTINS,
    file_texts.BUILTINS,
    color_functions.BUILTINS,
)
"""Functions whose values depend on their arguments and on random keys, not on the geometry or material of shapes."""

CONTEXT_QUERIES = frozenset(context_queries.BUILTINS)
"""Functions for which a grammar is derived twice."""

SHAPE_ATTRIBUTES = shape_attributes.SHAPE_ATTRIBUTES
"""Every shape attribute by name."""
