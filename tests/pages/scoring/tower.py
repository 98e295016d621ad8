"""A grammar whose models differ in a few ways."""

from __future__ import annotations

from grammarlab.derivation.derive import derive
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.flattening import flattened
from grammarlab.runs.sample.records import compiled

TOWER = """
attr floors = 50% : 2 else : 5
Lot --> 40% : extrude(floors * 3) Flat
        30% : extrude(12) roofGable(30) Gable
        else : extrude(6) comp(f) { top : Top | side : Side }
Side --> 50% : color("#ff0000") Red else : color("#0000ff") Blue
"""


def kind_of(model: str) -> str:
    """The symbol that the start rule made of a model: Flat, Gable or another one."""
    grammar, program = compiled(TOWER, "tower")
    address = Address.parse(model)
    program = flattened(grammar).program if address.flat else program
    forest = derive(program, 1, address.seed, first_model=address.model)
    return forest.symbols[forest.nodes.symbol[1]]
