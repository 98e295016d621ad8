"""What in a design is allowed but hardly meant."""

from __future__ import annotations

from grammarlab.layers.design import WILDCARD, Design, Layer


def design_notes(design: Design) -> tuple[str, ...]:
    """Notes on a design: patterns that no layer uses, and letters without size and shape that hide what is below.

    Args:
        design: a design; layers that are switched off count as well.
    """
    used = {name for layer in design.layers for name in layer.patterns}
    unused = [f"the pattern {name!r} is in no layer." for name in design.patterns if name not in used]
    return (*unused, *_covering(design))


def _covering(design: Design) -> list[str]:
    """Notes on letters that cover layers below as far as they reach, although nothing says what they look like."""
    below = design.layers[:-1]  # nothing is below the last layer
    notes = {}
    for layer in below:
        for axis, name in enumerate(layer.patterns):
            for symbol in sorted(_bare(design, layer, axis)):
                notes[name, symbol] = (
                    f"{symbol} in the pattern {design.patterns[name].text!r} of the layer {layer.name!r} has no size "
                    f"and no shape, and covers the layers below. For a gap, write a control pattern, such as "
                    f"'cec; c := C', or set `transparent = true`; for a wall, give it a shape."
                )
    return list(notes.values())


def _bare(design: Design, layer: Layer, axis: int) -> set[str]:
    """Visible symbols of a layer without size, for which no table of shapes has an entry."""
    mask = layer.masks[axis]
    pattern = design.patterns[layer.patterns[axis]]
    shaped = {key[axis] for shapes in (design.shapes, layer.shapes) for key in shapes}
    return {
        name
        for name in set(pattern.symbols()) - pattern.placeholders()
        if design.symbols[name].size is None
        and design.symbols[name].opaque
        and not design.symbols[name].transparent
        and (mask is None or name in mask)
        and name not in shaped
        and (WILDCARD, WILDCARD) not in {**design.shapes, **layer.shapes}
    }
