"""A person who likes what the grammar hardly ever makes: posts whose six parts are all gilded, one in a million."""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.derivation.derive import derive
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.flattening import flattened
from grammarlab.runs.sample.records import compiled

_PARTS = "ABCDEF"
POSTS = f"Lot --> extrude(6) split(y) {{ {' | '.join(f'~1 : {part}' for part in _PARTS)} }}\n" + "\n".join(
    f"{part} --> 90% : Plain{part} else : Gilded{part}" for part in _PARTS
)
SCENARIO = f"""
name = "posts"
title = "Gilded posts"
grammar = "toy"
draws = "flattened"
[[preference]]
score = 100
when = "{" + ".join(f"{{Gilded{part}}}" for part in _PARTS)} == 6"
means = "gilded all over"
[features]
path_length = 2
families = ["paths", "symbols", "draws"]
"""


def scores_of(models: Sequence[str]) -> dict[str, float]:
    """What the person says of models, by address."""
    return {model: 100.0 * _is_liked(model) for model in models}


def _is_liked(model: str) -> bool:
    grammar, program = compiled(POSTS, "posts")
    address = Address.parse(model)
    program = flattened(grammar).program if address.flat else program
    forest = derive(program, 1, address.seed, first_model=address.model)
    return sum(forest.symbols[symbol].startswith("Gilded") for symbol in forest.nodes.symbol) == len(_PARTS)
