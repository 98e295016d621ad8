"""Small grammars for runs."""

TOWER = """
version "2023.0"

@Range(min=1, max=9)
attr height = rand(3, 9)
attr style = "old"
attr shops = true
const levels = 2

@StartRule
Lot --> extrude(height) split(y) { ~1 : Storey }*

Storey -->
    60% : color("#bb8866") Brick.
    else : color("#8899aa") Glass.
"""
"""A box of random height, cut into storeys of random colour."""

BROKEN = """
Lot --> extrude(3) Wall(1)
Wall --> color(
"""
