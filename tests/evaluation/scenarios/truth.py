"""What the people of the scenarios like, told once more: plain Python that walks one derivation tree.

Written from the grammars' comments and the paper's Table 4.2, apart from the expressions in ``scenarios/``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby, pairwise

import numpy as np

from grammarlab.derivation.forest import Forest


@dataclass(slots=True)
class Node:
    symbol: str
    branch: int | None
    """First level of the branch, None for leaves and rules without a choice."""
    children: Sequence[Node] = ()
    draws: dict[str, float] = field(default_factory=dict)
    """What its rule drew."""

    def walk(self) -> Iterator[Node]:
        stack: list[Node] = [self]
        while stack:
            node = stack.pop()
            yield node
            stack.extend(reversed(node.children))

    def find(self, symbol: str) -> list[Node]:
        return [node for node in self.walk() if node.symbol == symbol]

    def choice(self, symbol: str) -> int | None:
        """The branch of the only node with a symbol; None when there is none."""
        found = self.find(symbol)
        assert len(found) <= 1, symbol
        return found[0].branch if found else None


@dataclass
class Model:
    root: Node
    draws: dict[str, float]


def models(forest: Forest) -> Iterator[Model]:
    nodes = forest.nodes
    branches = [rule.branch[0] if rule.branch else None for rule in forest.rules]
    made = [
        Node(forest.symbols[symbol], branches[rule] if rule >= 0 else None)
        for symbol, rule in zip(nodes.symbol.tolist(), nodes.rule.tolist(), strict=True)
    ]
    order = np.lexsort((nodes.repeat, nodes.child, nodes.parent))
    parents = nodes.parent.tolist()
    for parent, rows in groupby(order.tolist(), parents.__getitem__):
        if parent >= 0:
            made[parent].children = [made[row] for row in rows]
    roots = {int(nodes.model[row]): made[row] for row in np.flatnonzero(nodes.parent < 0)}
    draws: dict[int, dict[str, float]] = {model: {} for model in roots}
    for node, site, value in zip(forest.draws.node, forest.draws.site, forest.draws.value, strict=True):
        name = forest.sites[site].name
        made[node].draws[name] = draws[int(nodes.model[node])][name] = float(value)
    for model in range(forest.num_models):
        yield Model(roots[model], draws[model])


# Furniture -----------------------------------------------------------------------------------------------------------

ONE, TWO, FOUR = 0, 1, 2
PADS, PLATE, CROSS, RUNNERS, PLINTH = range(5)
LIGHT, DARK, STEEL, PAINT = range(4)
ROUND, RECTANGLE = 0, 1


def legs_if_valid(table: Node) -> int | None:
    """How many legs (as a branch) a valid table has, None for others."""
    legs, base = table.choice("LegCount"), table.choice("Base")
    assert legs is not None
    one = {PLATE, PLINTH} if table.choice("OneLeg") in {0, 3} else {CROSS, PLINTH}
    suits = {ONE: one, TWO: {RUNNERS, PLINTH}, FOUR: {None, PADS, RUNNERS, PLINTH}}
    return legs if base in suits[legs] else None


def finishes(table: Node) -> set[int]:
    """The finishes of all parts; 9 for brass, marble, glass and black."""
    whole = table.choice("Finish")
    assert whole is not None
    found = {whole}
    for node in table.walk():
        if node.symbol in {"TopFinish", "LegFinish", "BaseFinish", "ShelfFinish", "Edge"} and node.branch is not None:
            found.add({0: whole, 1: LIGHT, 2: DARK, 3: STEEL, 4: 9}[node.branch])
    return found


def f1(m: Model) -> float:
    return {ONE: 70, TWO: 20, FOUR: 10}.get(legs_if_valid(m.root), 0)  # type: ignore[call-overload]


def f2(m: Model) -> float:
    kind = (m.root.choice("Plan"), m.root.choice("Finish"))
    return 60 if kind == (ROUND, LIGHT) else 40 if kind == (RECTANGLE, DARK) else 0


def f3(m: Model) -> float:
    if legs_if_valid(m.root) is None:
        return 0
    finish = m.root.choice("Finish")
    return 70 if finish == STEEL else 30 if finish in {LIGHT, DARK} else 0


def f2_parts(m: Model) -> float:
    plan, used = m.root.choice("Plan"), finishes(m.root)
    return 60 if plan == ROUND and used == {LIGHT} else 40 if plan == RECTANGLE and used == {DARK} else 0


def f3_parts(m: Model) -> float:
    if legs_if_valid(m.root) is None:
        return 0
    used = finishes(m.root)
    return 70 if used == {STEEL} else 30 if used <= {LIGHT, DARK} else 0


def f4(m: Model) -> float:
    if legs_if_valid(m.root) is None:
        return 0
    return {ROUND: 70, RECTANGLE: 30}.get(m.root.choice("Plan"), 0)  # type: ignore[call-overload]


# Buildings -----------------------------------------------------------------------------------------------------------


def style(m: Model) -> str | None:
    """The style of a building whose parts agree."""
    found = set()
    for part in ("WallColor", "GroundFloor", "UpperFloors", "Roof"):
        own = [s for s in ("Office", "Paris", "Plain", "Old") if m.root.find(part + s)]
        assert len(own) == 1, part
        found.add(own[0])
    return found.pop() if len(found) == 1 else None


def floors(m: Model) -> int:
    """2 to 6, from the branch of Floors."""
    branch = m.root.choice("Floors")
    assert branch is not None
    return branch + 2


def shape(m: Model) -> str:
    branch = m.root.choice("Building")
    assert branch is not None
    return ("rectangle", "L", "U")[branch]


def b1(m: Model) -> float:
    return {"Office": 40, "Paris": 20, "Plain": 20, "Old": 20, None: 0}[style(m)]


def b2(m: Model) -> float:
    return 50 if (floors(m) >= 5 and shape(m) == "L") or (floors(m) <= 3 and shape(m) == "rectangle") else 0


def b3(m: Model) -> float:
    return {"L": 60, "rectangle": 40, "U": 0}[shape(m)]


def b4(m: Model) -> float:
    return 80 if floors(m) >= 5 else 20 if floors(m) <= 3 else 0


# Skyscrapers ---------------------------------------------------------------------------------------------------------

BOX, CYLINDER, V = range(3)
BLACK, BLUE, GREEN = range(3)


def blocks(m: Model) -> list[tuple[int, int]]:
    """Shape and windows of the blocks from the ground up."""
    (tower,) = m.root.find("Tower")
    found = []
    for block in tower.children:
        if block.symbol == "Block":
            glass = block.choice("Glass")
            assert block.branch is not None
            assert glass is not None
            found.append((block.branch, glass))
    assert len(found) == (tower.branch or 0) + 1
    return found


def s1(m: Model) -> float:
    shapes = {shape for shape, _ in blocks(m)}
    return {BOX: 60, V: 20, CYLINDER: 20}[shapes.pop()] if len(shapes) == 1 else 0


def s2(m: Model) -> float:
    return {BOX: 100, CYLINDER: 50, V: 0}[blocks(m)[0][0]]


def l3(m: Model) -> float:
    found = blocks(m)
    return {BLACK: 50, GREEN: 30, BLUE: 20}.get(found[2][1], 0) if len(found) == 3 else 0


def l4(m: Model) -> float:
    found = blocks(m)
    below = [low for low, high in pairwise(found) if high == (CYLINDER, BLACK)]
    return 100 if (BOX, GREEN) in below and (BOX, BLUE) not in below else 0


def l4_relation(m: Model) -> float:
    shapes = [shape for shape, _ in blocks(m)]
    return 100 if (BOX, CYLINDER) in pairwise(shapes) else 0


# Airplanes -----------------------------------------------------------------------------------------------------------


def a1(m: Model) -> float:
    styles = ("Biplane", "Fokker", "Airliner", "Transport", "Jet")
    parts = ("Body", "Wings", "Tail", "Engine", "Engines", "Gear")
    own = {style + part: style for style in styles for part in parts}
    found = Counter(own[node.symbol] for node in m.root.walk() if node.symbol in own)
    assert found.total() == 5
    if found["Biplane"] + found["Fokker"] == 5:
        return 100
    return 50 if found["Biplane"] + found["Fokker"] == 0 else 0


# Limits --------------------------------------------------------------------------------------------------------------


def steps(m: Model, *names: str) -> list[float]:
    return [(11 + m.draws[name]) / 11 for name in names]


def l1(m: Model) -> float:
    return 100 if m.draws["height"] < 5 else 0


def l2(m: Model) -> float:
    return 100 if np.prod([m.draws[name] for name in ("width", "depth", "height")]) < 125 else 0


def l1_discrete(m: Model) -> float:
    return 100 if steps(m, "height")[0] < 5 else 0


def l2_discrete(m: Model) -> float:
    return 100 if np.prod(steps(m, "width", "depth", "height")) < 125 else 0


def l5(m: Model) -> float:
    parts = ("Steps", "Columns", "Beams", "Roof", "Finial")
    return 100 if all(m.root.find("Gilded" + part) for part in parts) else 0


TRUTH: dict[str, Callable[[Model], float]] = {
    "F1": f1,
    "F2": f2,
    "F3": f3,
    "F2_parts": f2_parts,
    "F3_parts": f3_parts,
    "F4": f4,
    "F3xF4": lambda m: f3(m) * f4(m) / 100,
    "B1": b1,
    "B2": b2,
    "B3": b3,
    "B4": b4,
    "S1": s1,
    "S2": s2,
    "A1": a1,
    "L1": l1,
    "L2": l2,
    "L1_discrete": l1_discrete,
    "L2_discrete": l2_discrete,
    "L3": l3,
    "L4": l4,
    "L4_relation": l4_relation,
    "L5": l5,
}
