"""Rule files made for timing."""

FACADES = """
Lot --> extrude(60) comp(f){ side: Facade | top: Roof }
Facade --> split(y){ 5: Ground | { ~3.4: Floor }* | 1: Cornice }
Ground --> split(x){ { ~4: Shop }* }
Floor --> split(x){ 0.6: Pier | { ~2.4: Tile }* | 0.6: Pier }
Tile --> split(x){ ~1: Wall | 1.2: Bay | ~1: Wall }
Bay --> split(y){ 0.9: Wall | 1.7: Window | ~1: Wall }
Window --> [ s('1, 0.1, 0.2) t(0, 0, -0.1) i("builtin:cube") Sill ] t(0, 0, -0.15) Glass
Wall --> color("#c8b89a") Plaster.
"""
"""A tower whose facades have about 3,000 leaves on a lot of 30 x 30 metres."""


def chain(length: int) -> str:
    """A rule file of which every model touches ``length`` rules, each with a split, a scaling and two successors."""
    rules = [f"Step{i} --> split(x){{ 0.4: Edge | ~1: s('1, '0.999, '1) Step{i + 1} }}" for i in range(length - 1)]
    return "\n".join(["Lot --> extrude(10) Step0", *rules, f"Step{length - 1} --> Edge"])
