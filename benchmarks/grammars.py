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

TEXTURED = """
attr height = 60
Lot --> extrude(height) comp(f){ front: Front | side: Side | top: RoofTile. }
Front --> setupProjection(0, scope.xy, 1.5, 1) setupProjection(2, scope.xy, '1, '1)
          split(y){ 5: split(x){ 1: Wall | { ~3.1: Entrance }* | 1: Wall } | { ~4.5: Floor(split.index) }* }
Side --> setupProjection(0, scope.xy, 1.5, 1) setupProjection(2, scope.xy, '1, '1)
         split(y){ 5: Floor(0) | { ~4.5: Floor(split.index) }* }
Entrance --> 30%: Door else: Bay(0)
Floor(i) --> case i == 2: split(y){ 1: Ledge | ~1: Bays(i) | 0.5: Ledge } else: split(y){ ~1: Bays(i) | 0.4: Ledge }
Bays(i) --> split(x){ 0.5: Brick | { ~3.1: Bay(i) }* | 0.5: Brick }
Bay(i) --> case i == 1 || i > 10: s('1, '1, 1.2) t(0, 0, -1.2) Column Arch
           else: split(x){ ~1: Wall | 2: split(y){ ~1: Wall | 1.5: Window | ~1: Wall } | ~1: Wall }
Column --> [ i("builtin:cylinder:8") s(0.3, '1, 0.3) t(0.1, 0, 0.2) Post ]
Post --> setupProjection(0, scope.xy, 1, 1) projectUV(0) Stone.
Arch --> split(y){ ~3: split(x){ ~1: Wall | 1.8: Window | ~1: Wall } | 0.6: Crown }
Crown --> split(x){ ~1: Wall | ~1: [ Keystone ] Wall | ~1: Wall }
Keystone --> i("builtin:cube") t(0, 0, '0.1) s('1, '1, 0.4) texture("key.jpg") Fitted
Fitted --> setupProjection(0, scope.xy, '1, '1) projectUV(0) Key.
Ledge --> [ s('1, '1, 0.6) t(0, 0, -0.2) i("builtin:cube") LedgeFaces ] Wall
LedgeFaces --> comp(f){ top = Cap. | bottom = NIL | all: LedgeFace }
LedgeFace --> setupProjection(0, scope.xy, 1, 1) projectUV(0) texture("ledge.jpg") Stone.
Window --> [ t(0, 0, -0.25) texture("window.jpg") Pane ]
           [ s('1, 0.3, 0.3) t(0, 0, -0.15) i("builtin:cube") color("#eeeeee") Sill. ]
           [ t(0, '1, -0.25) s('1, 0.2, 0.3) i("builtin:cube") color("#eeeeee") Lintel. ]
Pane --> setupProjection(0, scope.xy, '1, '1) projectUV(0) projectUV(2) Glass.
Door --> split(x){ ~1: Wall | 2: split(y){ 2.5: DoorLeaf | ~2: Wall } | ~1: Wall }
DoorLeaf --> t(0, 0, -0.5) texture("door.jpg") setupProjection(0, scope.xy, '1, '1) projectUV(0) Leaf.
Wall --> color("#FF9900") s('1, '1, 0.4) t(0, 0, -0.4) i("builtin:cube") Brick
Brick --> texture("brick.jpg") projectUV(0) projectUV(2) Bricks.
"""
"""A tower of brick with about 3,400 leaves with texture coordinates, on a lot of 30 x 20 metres."""

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

TEMPLE = """
attr height = 12
Lot --> extrude(height) split(y){ 1: comp(f){ side = Step. | top = Floor. } | ~1: comp(f){ side: Colonnade }
                                | 2: comp(f){ side: Frieze | top: Roof } }
Colonnade --> split(x){ ~2.4: Column }*
Column --> s(1.6, '1, 1.6) center(x) t(0, 0, -1.6)
           split(y){ 0.4: i("builtin:cube") Base. | ~1: i("builtin:cylinder:60") Shaft. | 0.5: Capital }
Capital --> split(y){ ~1: i("builtin:sphere:24:16") Echinus. | ~1: i("builtin:cube") Abacus. }
Frieze --> split(x){ 0.7: Triglyph | ~1.1: Metope. }*
Triglyph --> s('1, '1, 0.2) split(x){ { ~1: i("builtin:cylinder:12") Glyph. }* }
Roof --> roofGable(20) comp(f){ top: Slope | vertical = Gable. }
Slope --> split(y){ ~0.5: split(x){ ~0.4: i("builtin:cylinder:12") Tile. }* }*
"""
"""A temple of about 3,400 leaves, most of them round, with 81,000 vertices, on a lot of 30 x 20 metres."""
