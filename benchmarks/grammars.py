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


MIRRORED = """
attr storeys = 36
Lot --> extrude(3 * storeys) comp(f){ side: Wall }
Wall --> split(y){ 3: split(x){ ~1.2: Bay(split.index % 2 == 0) }* }*
Bay(isMirrored) --> case isMirrored: mirrorScope(true, false, false) Insert else: s(-scope.sx, '1, '1) Insert
Insert --> s('1.3, '1, 0.4) i("builtin:cone") comp(f){ all = Cone. }
"""
"""A tower whose walls have about 3,000 inserted meshes, mirrored and trimmed, on a lot of 30 x 20 metres."""

DRESSED = """
attr storeys = 9
Lot --> extrude(3 * storeys) comp(f){ side: Wall }
Wall --> split(y){ 3: Floor(split.index % 5) }*
Floor(kind) --> split(x){ ~2.5: Bay(kind) }*
Bay(kind) --> split(y){ 0.8: Sill(kind) | ~1.6: Window(kind) | 0.6: Lintel(kind) }
Sill(kind) --> s('1, '1, 0.3) primitiveCylinder(5 + kind) split(x){ ~1: Bar. | ~2: Bar. }
Window(kind) --> offset(-0.1 - 0.02 * kind) comp(f){ inside: Glass. | border: extrude(0.1) Frame }
Frame --> comp(f){ top: Front. | all = Sides. }
Lintel(kind) --> extrude(0.2) comp(f){ top: taper(0.1 + 0.05 * kind) Stone. | all = Stone. }
"""
"""Walls of about 4,700 leaves that have about 50 different meshes, on a lot of 30 x 20 metres."""

VARIED = """
attr kinds = 16
Lot --> extrude(60) comp(f){ front: Wall }
Wall --> split(y){ 3: Floor(split.index) }*
Floor(storey) --> split(x){ ~1: Bay((30 * storey + split.index) % kinds) }*
Bay(kind) --> offset(-0.05 - 0.0005 * kind) comp(f){ inside: Glass. | border: extrude(0.1) Frame. }
"""
"""A wall of 600 bays, of which as many as wished differ, on a lot of 30 x 20 metres."""

SMALL = """
Lot --> extrude(9) comp(f){ front: Wall }
Wall --> split(y){ ~3: split(x){ ~2: Bay }* }*
Bay --> split(x){ 0.5: Pier. | ~1: split(y){ 1: Sill. | ~1: Glass. } | 0.5: Pier. | 0.1: Gap. }
"""
"""A rule of 75 leaves, on a lot of 10 x 10 metres."""
