"""Small grammars with what the language of tastes is about."""

from __future__ import annotations

from functools import cache

from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.features.patterns.pattern import Pattern
from grammarlab.language.grammar import Grammar
from grammarlab.tastes.attribute_readers import readers_of
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.visible_orders import visible_orders

GRAMMARS = {
    "towers": """
        attr storey = rand(3, 4)
        attr plinth = rand(1, 3)
        attr front = rand(5, 9)
        attr color =
            30% : 1
            30% : 2
            else : 3
        Lot --> 30% : Two Tower Tower 30% : Three Tower Tower Tower else : Four Tower Tower Tower Tower
        Tower --> 40% : Brick Roof 40% : Glass Roof else : Steel
        Roof --> 50% : Flat else : Gable
    """,
    "recursive": """
        attr size = rand(1, 2)
        Lot --> Stack
        Stack --> 50% : Part Stack else : Part End
        Part --> 30% : Red 30% : Blue else : Green
    """,
    "roles": """
        Lot --> 50% : OfficeFloor OfficeRoof else : HouseFloor HouseRoof HouseFloor
        OfficeFloor --> 50% : OfficeGlass else : OfficeBrick
        HouseFloor --> 50% : HouseBrick else : HouseGlass
        OfficeRoof --> 50% : OfficeFlat else : OfficeGable
        HouseRoof --> 50% : HouseGable 25% : HouseFlat else : HouseHip
    """,
    "styles": """
        Lot --> 50% : WallsOffice else : WallsHouse
        WallsOffice --> FloorOnOffice RoofOnOffice
        WallsHouse --> FloorOnHouse RoofOnHouse
        FloorOnOffice --> 50% : FloorOffice else : FloorHouse
        FloorOnHouse --> 50% : FloorOffice else : FloorHouse
        RoofOnOffice --> 50% : RoofOffice else : RoofHouse
        RoofOnHouse --> 50% : RoofOffice else : RoofHouse
    """,
    "blocks": """
        attr lowHeight = rand(3, 5)
        attr middleHeight = rand(2, 4)
        attr highHeight = rand(1, 3)
        attr brickColor = 50% : "#804030" else : "#603020"
        attr woodColor = 40% : "#a08060" 30% : "#907050" else : "#302010"
        attr trim = 60% : 1 else : 2
        Lot -->
            40% : s(1, lowHeight, 1) Block Brick
            30% : s(1, lowHeight + middleHeight, 1) Block Block Wood
            else : s(1, lowHeight + middleHeight + highHeight, 1) Block Block Block Wood
        Block --> 40% : color(0.9, 0.9, 0.8) Pane 30% : color(0.1, 0.1, 0.1) Pane else : color(0.5, 0.5, 0.5) Pane
        Brick --> color(brickColor) Wall
        Wood --> color(woodColor) Wall
    """,
    "roofs": """
        Lot --> Tower House House
        Tower --> TowerRoof
        House --> HouseRoof
        TowerRoof -->
            40% : color("#808080") TowerFlat
            30% : color("#000000") TowerGable
            else : color("#ffffff") TowerHip
        HouseRoof -->
            40% : color("#808080") HouseFlat
            30% : color("#000000") HouseGable
            10% : color("#ffffff") HouseHip
            else : color("#202020") HouseDome
    """,
    "shifts": """
        attr lowShift = rand(-5, -3)
        attr middleShift = rand(-4, -2)
        attr highShift = rand(-2, -1)
        Lot -->
            50% : t(0, lowShift, 0) t(0, middleShift, 0) A
            30% : t(0, lowShift, 0) t(0, highShift, 0) B
            else : t(0, lowShift, 0) t(0, middleShift, 0) t(0, highShift, 0) C
    """,
    "sections": """
        Lot --> 50% : Section Section else : Section Section Section
        Section --> 80% : Left Right else : Left
        Left --> 50% : Round else : Square
        Right --> 50% : Round else : Square
    """,
}


READERS = {"plinth": (Pattern("Tower", branch=(0,)),)}
"""Branches that use draws, as if others did not."""


def elements_of(name: str) -> Elements:
    """Quantities of models of a grammar."""
    if name not in ("blocks", "roofs", "shifts"):
        return Elements.of(forests_of(name), READERS if name == "towers" else {})
    grammar = Grammar.parse(GRAMMARS[name])
    return Elements.of(forests_of(name), readers_of(grammar), visible_orders(grammar))


@cache
def forests_of(name: str) -> tuple[Forest, ...]:
    """Two batches of models of a grammar."""
    grammar = Grammar.parse(GRAMMARS[name])
    return derive(grammar, 40, seed=1), derive(grammar, 24, seed=2)


def elements_of_long_names(length: int) -> Elements:
    """Quantities of models of two towers with three choices each whose symbols have long names."""
    name = "x" * length
    rule = f"{name} --> 40% : color(0.5, 0.5, 0.5) A 30% : color(0.1, 0.1, 0.1) B else : color(0.9, 0.9, 0.9) C"
    grammar = Grammar.parse(f"Lot --> Low High\nLow --> {name} {name} {name}\nHigh --> {name} {name} {name}\n{rule}")
    return Elements.of([derive(grammar, 40, seed=1)], orders=visible_orders(grammar))
