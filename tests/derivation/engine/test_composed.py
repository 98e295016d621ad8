"""Grammars put together from every operation with any numbers: an error of ours or sound leaves, nothing else."""

from __future__ import annotations

import random

import numpy as np
import pytest

from grammarlab.derivation import Budget, derive
from grammarlab.errors import GrammarlabError
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED
from tests.cases import some
from tests.derivation.operations.leaves import L_SHAPE, TRIANGLE

NUMBERS = [
    *(
        "0",
        "1",
        "-2",
        "3.7",
        "'0.5",
        "~1",
        "1e9",
        "1e-9",
        "-1e300",
        "0 / 0",
        "1 / 0",
        "true",
        '"a"',
        "h",
        "t",
        "p(0.5)",
    ),
    *("rand(1, 3)", "scope.sx", "scope.sy", "split.index", "comp.index", "geometry.area", "geometry.nHoles"),
]
SELECTORS = [
    *(
        "top",
        "bottom",
        "front",
        "side",
        "all",
        "border",
        "inside",
        "vertical",
        "world.up",
        "object.front",
        "hip",
        "eave",
    ),
    *("0", "-1", "h", "top || front", "!top", "geometry.area() > 3", "p(0.5)", 't == "a"', "scope.sx > 2", "remainder"),
]
OPERATIONS = [
    *("t(#, #, #)", "s(#, #, #)", "r(#, #, #)", "extrude(#)", "extrude(world.up, #)", "extrude(vertex.normal, #)"),
    *("extrude(world.up.flatTop, #)", "taper(#)", "roofHip(#)", "roofGable(#, #, #, true)", "roofPyramid(#)"),
    *("roofShed(#, #)", "roofRidge(byHeight, #)", "offset(#)", "offset(#, inside)", "innerRect()", "primitiveCube()"),
    *("primitiveSphere(5, #)", "primitiveCylinder()", "primitiveCone(#, #, #)", 'i("builtin:cone", zUp)'),
    *('i("builtin:star", yUp, keepSizeAlignPosition)', "mirror(true, false, false)", "reverseNormals()"),
    *("alignScopeToAxes(y)", "alignScopeToAxes(object.x)", "alignScopeToGeometry(yUp, any, longest)"),
    *("alignScopeToGeometry(zUp, #, #)", "rotateScope(#, #, #)", "setPivot(yzx, #)", "center(xy)", "color(#, #, #)"),
    *("set(h, #)", "set(material.opacity, #)", 'report("k", #)', "print(#)", "rotate(abs, world, #, #, #)"),
    *("translate(abs, object, #, #, #)", "A", "B", "C(#)", "Leaf", "NIL", "[ t(1, 2, 3) Leaf ]", "[ extrude(-1) A ]"),
]
COMPONENTS = ("f", "f", "f, noAlign", "e", "e, noAlign", "v", "fe", "fv")
FOOTPRINTS = ((8.0, 6.0), (20.0, 0.5), 0.3 * L_SHAPE, TRIANGLE)


class Composer:
    """Writes rule files by chance."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def filled(self, pattern: str) -> str:
        """A pattern with a number for each ``#``."""
        first, *rest = pattern.split("#")
        return first + "".join(self.random.choice(NUMBERS) + part for part in rest)

    def parts(self, heads: list[str], separators: list[str], depth: int) -> str:
        count = self.random.randint(1, 3)
        pick = self.random.choice
        return " | ".join(f"{pick(heads)} {pick(separators)} {self.body(depth - 1)}" for _ in range(count))

    def block(self, depth: int) -> str:
        pick = self.random.choice
        selected = self.parts(SELECTORS, [":", ":", "=", "=:"], depth)
        sized = self.parts(NUMBERS, [":"], depth)
        return pick(
            [
                f"split({pick('xyz')}) {{ {sized} | {{ {self.parts(NUMBERS, [':'], depth)} }}* }}",
                f"split({pick('xyz')}, noAdjust) {{ {sized} }}*",
                f"comp({pick(COMPONENTS)}) {{ {selected} }}",
                f"comp({pick(COMPONENTS)}) {{ {selected} }}",
                self.filled(f"setback(#) {{ {self.parts(SELECTORS, [':', '='], depth)} }}"),
                self.filled(pick(["shapeL(#, #)", "shapeO(#, #, #, #)", "innerRectangle(edge)"]))
                + f" {{ shape : {self.body(depth - 1)} | remainder = {self.body(depth - 1)} }}",
            ]
        )

    def body(self, depth: int) -> str:
        words = [self.filled(self.random.choice(OPERATIONS)) for _ in range(self.random.randint(0, 3))]
        if depth > 0 and self.random.random() < 0.7:
            words.append(self.block(depth))
        return " ".join(words) or "Leaf"

    def rule_file(self) -> str:
        rules = [
            'attr h = rand(0.5, 3)\nattr t = 50% : "a" else : "b"',
            f"Lot --> {self.body(3)}\nA --> {self.body(2)}",
            f"B --> 50% : {self.body(1)} else : Leaf\nC(x) --> case x > 1 : {self.body(1)} else : Leaf",
        ]
        return "\n".join(rules)


@pytest.mark.parametrize("seed", some(range(80)))
def test_a_composed_grammar_derives_or_says_why_not(seed):
    composer = Composer(seed)
    text = composer.rule_file()
    check_text(text, "composed.cga", SUPPORTED)
    budget = Budget(shapes=2_000, depth=15)
    try:
        forest = derive(Grammar.parse(text), 2, seed, footprint=composer.random.choice(FOOTPRINTS), budget=budget)
    except GrammarlabError:
        return
    assert (forest.leaves.size >= 0.0).all()
    assert np.isfinite(forest.leaves.position).all()
