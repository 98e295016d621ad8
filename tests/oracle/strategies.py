"""Random rule files that say something: every one can be parsed and derived, and ends.

Rules lead to later rules only, but for recursions that count down. Sizes are odd numbers, so that no two repeat counts
of a split are equally good and no condition stands on the edge.
"""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

HEADER = """
attr h = rand(1.03, 3.1)
attr w = 50% : 1.57 30% : case h > 2.02 : 0.71 else : 2.23 else : 0.93
attr tag = 40% : "a" else : "b" + str(1)
attr flag = p(0.7) && (h < 2.51 || tag == "a")
const g = h + w * f(1.01)
const names = "red;green;blue;"
f(x) = 60% : x + rand(1.13) else : case x > 1.07 : x / 2 else : x
f(x, y) = case flag : min(x, y) + f(x) / 3 else : f(y) % 1.7 + 0.13
deep(n) = case n < 1 : rand(0.31, 0.47) else : deep(n - 1) * 0.9 + 0.11
"""

AXES = st.sampled_from("xyz")
COLORS = st.sampled_from(["#ff0000", "#20c040", "#8090ff40"])
NUMBERS = st.sampled_from(
    [
        *("0.53", "1.19", "2.57", "h", "w", "f(2.03)", "f(w, h)", "g", "rand(0.51, 2.03)", "rand(1.7) + 0.21"),
        *("0.2 + h * 0.1", "max(1.01, w)", "deep(2)", "scope.sx / 3.7 + 0.4", "sqrt(h) + sin(30) * w"),
        *("rint(h) + 0.27", "listSize(names) / 2.9", "geometry.area / 40 + 0.3", "abs(scope.sz - 1.3) + 0.2"),
    ]
)
CONDITIONS = st.sampled_from(
    [
        *("h > 2.01", "scope.sx > 3.13", 'tag == "a"', 'tag != "b1"', "p(0.4)", "split.index % 2 == 0", "!flag"),
        *('comp.sel == "side"', "split.total > 3", "comp.index == 1", "geometry.nFaces > 1", "f(1) > 1.21 && p(0.5)"),
        *("geometry.isRectangular || w > 1", 'listItem(names, split.index) == "green"', "scope.elevation > 1.37"),
    ]
)
SELECTORS = st.sampled_from(
    [
        *("front", "back", "left", "side", "top", "bottom", "vertical", "horizontal", "border", "all"),
        *(
            "0",
            "split.index + 1",
            "world.up",
            "world.south",
            "world.side",
            "object.front",
            "street.front",
            "street.side",
        ),
    ]
)
STREET_SELECTORS = st.sampled_from([f"street.{side}" for side in ("front", "front", "back", "left", "right", "side")])


@st.composite
def operations(draw: st.DrawFn) -> str:
    """One operation without a block."""
    a, b = draw(NUMBERS), draw(NUMBERS)
    axes = draw(st.sampled_from(["x", "xz", "xyz", "y"]))
    mode = draw(st.sampled_from(["rel", "rel", "abs"]))
    system = draw(st.sampled_from(["world", "scope", "object", "pivot"]))
    choices = [
        f"t({a}, 0, '0.25)",
        f"t('-0.13, {a}, {b})",
        f"s('1, {a}, '0.51)",
        f"s({a}, {b}, '1)",
        "r(0, 90, 0)",
        f"r(scopeCenter, {a} * 7, {b} * 11, {a} * 5)",
        f"r(0, {a} * 10, 0)",
        f"r(0, 0, {b} * 10) r({a} * 10, 0, 0)",
        f"translate({mode}, {system}, {a}, 0.3, {b})",
        'report("t", scope.tx + 3 * scope.ty + 7 * scope.tz)',
        'report("r", scope.rx + scope.ry + pivot.px + 3 * pivot.py + 7 * pivot.pz)',
        f"rotate({mode}, {system}, 0, {a} * 9, 17)",
        f"s('0.53, '0.77, '0.51) center({axes})",
        f'color("{draw(COLORS)}")',
        "color(h / 3, 0.5, w / 3)",
        f"set(material.opacity, {a} / 9)",
        f"set(w, {a})",
        'set(tag, "a" + tag)',
        f'texture("wall" + rint({a}) + ".png")',
        f'report("{draw(st.sampled_from(["k", "l"]))}", {a})',
        "reverseNormals()",
    ]
    return draw(st.sampled_from(choices))


@st.composite
def solids(draw: st.DrawFn) -> str:
    """Something that gives a shape a volume."""
    height = draw(NUMBERS)
    primitive = draw(st.sampled_from(["cube", "cylinder"]))
    choices = [
        f"extrude({height})",
        f's({height}, 3.1, 2.07) i("builtin:{primitive}")',
        f's(2.3, {draw(st.sampled_from(["0", "1.9"]))}, 1.7) i("builtin:{primitive}")',
        "primitiveCube()",
        "primitiveCylinder(5)",
    ]
    return draw(st.sampled_from(choices))


@st.composite
def splits(draw: st.DrawFn, depth: int, rules: str) -> str:
    """A split with fixed, relative, floating and repeated sizes."""

    def part(prefixes: list[str], value: str) -> str:
        return f"{draw(st.sampled_from(prefixes))}{value} : {draw(bodies(depth - 1, rules))}"

    members = [part(["~", "", "'0.2 * "], draw(NUMBERS)) for _ in range(draw(st.integers(1, 3)))]
    for _ in range(draw(st.sampled_from([0, 1, 1, 2]))):
        lengths = st.floats(0.9, 3).map(lambda value: f"{value:.4f}1")
        repeated = [part(["~", ""], draw(lengths)) for _ in range(draw(st.integers(1, 2)))]
        members.insert(draw(st.integers(0, len(members))), f"{{ {' | '.join(repeated)} }}*")
    if draw(st.booleans()):
        members = [f"{{ {' | '.join(members)} }}"]
    mode = draw(st.sampled_from(["", "", ", noAdjust", ", adjust"]))
    return f"split({draw(AXES)}{mode}) {{ {' | '.join(members)} }}"


@st.composite
def comps(draw: st.DrawFn, depth: int, rules: str) -> str:
    """Components of a kind, each part for what the parts before it left."""
    kind = draw(st.sampled_from("ffffe"))
    selectors = draw(st.lists(SELECTORS, min_size=1, max_size=3, unique=True))
    # All faces of a box together are a mesh of any kind to the engine, but look like a box to the oracle.
    marks = [draw(st.sampled_from("::=" if kind == "f" and selector != "all" else ":")) for selector in selectors]
    inside = bodies(depth - 1, rules) if kind == "f" else st.builds('color("{}") {}'.format, COLORS, successors(""))
    inner = [draw(inside) for _ in selectors]
    parts = [f"{selector} {mark} {body}" for selector, mark, body in zip(selectors, marks, inner, strict=True)]
    return f"comp({kind}) {{ {' | '.join(parts)} }}"


@st.composite
def successors(draw: st.DrawFn, rules: str) -> str:
    """One of some rules, a leaf, or nothing."""
    number = draw(NUMBERS)
    calls = {"A": ["A", "A"], "B": ["B(2)", f"B({number})", f"B({number}, h)"], "C": ["C"]}
    return draw(st.sampled_from(["Leaf", "Leaf", "A.", "", *(call for rule in rules for call in calls[rule])]))


@st.composite
def bodies(draw: st.DrawFn, depth: int, rules: str) -> str:
    """Some operations and what they lead to; choices among them."""
    kind = draw(st.sampled_from([1, 1, 1, 2, 2, 2, 3, 4, 5, 6, 7, 8, 0])) if depth > 0 else 0
    before = " ".join(draw(st.lists(operations(), max_size=2)))
    inner, then = bodies(depth - 1, rules), successors(rules)
    if kind in {1, 2}:
        after = f"{draw(operations())} {draw(then)}" if draw(st.booleans()) else ""
        solid = draw(solids()) if draw(st.booleans()) else ""
        return f"{before} {solid} {draw((splits if kind == 1 else comps)(depth, rules))} {after}"
    if kind == 3:
        return f"{before} [ {draw(inner)} ] {draw(operations())} {draw(then)}"
    if kind == 4:
        return f"{draw(st.integers(1, 60))}% : {draw(inner)} else : {draw(inner)}"
    if kind == 5:
        first, second = f"case {draw(CONDITIONS)} : {draw(inner)}", f"case {draw(CONDITIONS)} : {draw(inner)}"
        return f"{first} {second} else : {draw(bodies(0, rules))}"
    if kind == 7:
        return f"{before} {draw(then)} {draw(then)}"
    if kind == 8:
        return f"{before} {draw(st.sampled_from(['NIL', '[ NIL ]', 'Leaf NIL']))}"
    if kind == 6:
        return f"{draw(solids())} {before} {draw(then)}"
    return f"{before} {draw(then)}"


@st.composite
def rule_files(draw: st.DrawFn) -> str:
    """A whole rule file, for an initial shape a few metres wide."""
    return "\n".join(
        [
            HEADER,
            f"Lot --> {draw(solids())} {draw(st.one_of(splits(3, 'AABC'), comps(3, 'AABC')))}",
            f"A --> {draw(bodies(2, 'BBC'))}",
            f"B(n) --> case n < 1 : C else : t(0, 0.1, 0) s('0.9, '0.9, '0.9) B(n - 1) {draw(operations())}",
            f"B(n, m) --> {draw(st.integers(1, 60))}% : t(0, n, m) C B(m / 2) else : set(h, m) C",
            f"C --> {draw(bodies(1, ''))}",
        ]
    )


@st.composite
def street_parts(draw: st.DrawFn, mark: str, bodies: st.SearchStrategy[str], rest: str) -> str:
    """Parts of a block: some sides of the lot, and what is left."""
    sides = draw(st.lists(STREET_SELECTORS, min_size=1, max_size=3, unique=True))
    return " | ".join(f"{side} {mark} {draw(bodies)}" for side in [*sides, rest])


@st.composite
def street_files(draw: st.DrawFn) -> str:
    """A rule file about lots, some ten metres wide: strips along its edges, masses on the rest, walls of the masses."""
    small, height = st.sampled_from(["0.4", "0.7", "0.9"]), st.sampled_from(["2", "3.5"])
    leaf = st.sampled_from(["Leaf", "A.", "[ t(0, 1, 0) A. ]"])
    walls = st.builds(
        "comp({}) {{ {} }}".format, st.sampled_from(["f", "f", "f", "e", "fe"]), street_parts(":", leaf, "all")
    )
    moved = st.sampled_from(
        [
            *("", "t(1, 0, 2)", "r(0, 30, 0)", "s('0.7, '1, '0.5)", "r(0, 90, 0) s('0.5, '2, '1)", "center(xz)"),
            *("primitiveCube()", "s('0.5, '1, '0.5) center(xz) primitiveCube()", "r(scopeCenter, 0, 170, 0)"),
        ]
    )
    cut = st.sampled_from(
        ["Walls", "split(x) { ~1.1 : Walls | ~2.3 : Walls }", "split(z) { 0.51 : Walls | ~1 : Walls }"]
    )
    mass = st.builds("{} extrude({}) {} {}".format, moved, height, moved, cut)
    ground = st.one_of(
        st.builds("offset(-{}, inside) {}".format, small, mass),
        st.builds("setback({}) {{ {} }}".format, small, street_parts(":", mass, "remainder")),
        st.builds("setback({}) {{ {} }}".format, small, street_parts("=", st.just("A."), "remainder")),
        mass,
        walls,
    )
    inner = draw(
        st.one_of(ground, st.builds("setback({}) {{ {} }}".format, small, street_parts(":", ground, "remainder")))
    )
    top = draw(st.one_of(st.just("T."), st.builds("offset(-0.3, inside) extrude(1.2) {}".format, walls)))
    return "\n".join(
        [
            f"Lot --> {inner}",
            f"Walls --> 60% : {draw(walls)} else : comp(f) {{ street.front : W. | top : Top | all : V. }}",
            f"Top --> {top}",
        ]
    )


COURT = [(4, 8), (4, 4), (8, 4), (8, 8)]
"""Corners of a courtyard, clockwise seen from above."""
FOOTPRINTS: list[tuple[float, float] | np.ndarray] = [
    (8.0, 6.0),
    (8.0, 6.0),
    np.array([[1.0, 0, 7], [6, 0, 8], [7, 0, 1]]),
    np.array([[0.0, 0, 5], [4, 0, 5], [4, 0, 2], [9, 0, 2], [9, 0, 0], [0, 0, 0]]),
    np.array([[2.0, 0, 6], [7, 0, 4], [5, 0, -1], [0, 0, 1]]),
]
"""Rectangles along the axes, a triangle, an L and a rectangle askew."""

LOTS: list[tuple[tuple[float, float] | np.ndarray, list[float] | None]] = [
    ((12.0, 9.0), [8.0, 0.0, 0.0, 0.0]),
    ((12.0, 9.0), [8.0, 6.0, 0.0, 0.0]),
    ((12.0, 9.0), [8.0, 0.0, 12.0, 0.0]),
    ((12.0, 9.0), [0.0, 0.0, 0.0, 0.0]),
    ((12.0, 9.0), None),
    (np.array([[0.0, 0, 11], [9, 0, 12], [11, 0, 1], [1, 0, 0]]), [0.0, 7.0, 0.0, 5.0]),
    (np.array([[0.0, 0, 9], [7, 0, 9], [7, 0, 4], [14, 0, 4], [14, 0, 0], [0, 0, 0]]), [8.0, 0.0, 8.0, 6.0, 0.0, 0.0]),
    (
        np.array([[x, 0.0, z] for x, z in [(0, 12), (12, 12), (12, 0), (0, 0), (0, 12), *COURT, (4, 8)]]),
        [8.0, 6.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0, 0.0, 8.0],
    ),
]
"""Footprints with street widths: a street, a corner, opposite streets, none, unknown, askew, an L, a courtyard."""
