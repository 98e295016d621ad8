"""Random rule files that say something: every one can be parsed and derived, and ends."""

from __future__ import annotations

from hypothesis import strategies as st

AXES = st.sampled_from("xyz")
COLORS = st.sampled_from(["#ff0000", "#20c040", "#8090ff"])
SELECTORS = st.sampled_from(["front", "side", "top", "0", "vertical", "world.up", "all"])
CONDITIONS = st.sampled_from(
    ["h > 2", "scope.sx > 3", 'tag == "a"', "p(0.4)", "split.index % 2 == 0", 'comp.sel == "side"']
)
PLAIN = st.sampled_from(["0.5", "1", "2.5", "h", "w", "f(2)", "g", "rand(0.5, 2)", "0.2 + h * 0.1", "max(1, w)"])

HEADER = """
attr h = rand(1, 3)
attr w = 50% : 1.5 30% : case h > 2 : 0.7 else : 2.2 else : 0.9
attr tag = 40% : "a" else : "b"
const g = h + w
f(x) = 60% : x + rand(1) else : case x > 1 : x / 2 else : x
"""


@st.composite
def operations(draw: st.DrawFn) -> str:
    kind = draw(st.integers(0, 9))
    a, b = draw(PLAIN), draw(PLAIN)
    axes = draw(st.sampled_from(["x", "xz", "xyz", "y"]))
    return [
        f"t({a}, 0, '0.25)",
        f"s('1, {a}, '0.5)",
        f"s({a}, {b}, '1)",
        "r(0, 90, 0)",
        f"r(0, {a} * 10, 0)",
        f"s('0.5, '0.75, '0.5) center({axes})",
        f'color("{draw(COLORS)}")',
        f"set(w, {a})",
        f'report("{draw(st.sampled_from(["k", "l"]))}", {a})',
        "color(h / 3, 0.5, w / 3)",
    ][kind]


@st.composite
def splits(draw: st.DrawFn, depth: int) -> str:
    """A split with fixed, relative, floating and repeated sizes."""
    size = st.builds(lambda mark, value: f"{mark}{value}", st.sampled_from(["~", "", "'0.2 * "]), PLAIN)
    inner = bodies(depth - 1)
    groups = [f"{draw(size)} : {draw(inner)}" for _ in range(draw(st.integers(1, 3)))]
    if draw(st.booleans()):
        lengths = st.builds(lambda mark, value: f"{mark}{value:.2f}", st.sampled_from(["~", ""]), st.floats(0.8, 3))
        repeated = " | ".join(f"{draw(lengths)} : {draw(inner)}" for _ in range(draw(st.integers(1, 2))))
        groups.insert(draw(st.integers(0, len(groups))), f"{{ {repeated} }}*")
    return f"split({draw(AXES)}) {{ {' | '.join(groups)} }}"


@st.composite
def comps(draw: st.DrawFn, depth: int) -> str:
    selectors = draw(st.lists(SELECTORS, min_size=1, max_size=3, unique=True))
    marks = [draw(st.sampled_from([":", ":", "="])) for _ in selectors]
    parts = [f"{selector} {mark} {draw(bodies(depth - 1))}" for selector, mark in zip(selectors, marks, strict=True)]
    return f"extrude({draw(st.sampled_from(['2', 'h + 1']))}) comp(f) {{ {' | '.join(parts)} }}"


def successors() -> st.SearchStrategy[str]:
    return st.sampled_from(["A", "B(2)", "B(h)", "Leaf", "Other.", "NIL", "C"])


@st.composite
def bodies(draw: st.DrawFn, depth: int) -> str:
    """Some operations and what they lead to; choices among them."""
    kind = draw(st.integers(0, 7)) if depth > 0 else 0
    before = " ".join(draw(st.lists(operations(), max_size=2)))
    if kind == 1:
        return f"{before} {draw(splits(depth))}"
    if kind == 2:
        return f"{before} {draw(comps(depth))}"
    if kind == 3:
        return f"[ {before} {draw(successors())} ] {draw(operations())} {draw(successors())}"
    if kind == 4:
        return f"{draw(st.integers(1, 60))}% : {draw(bodies(depth - 1))} else : {draw(bodies(depth - 1))}"
    if kind == 5:
        return f"case {draw(CONDITIONS)} : {draw(bodies(depth - 1))} else : {draw(bodies(depth - 1))}"
    if kind == 6:
        return f'{before} s(2, 3, 2) i("builtin:{draw(st.sampled_from(["cube", "cylinder"]))}") {draw(successors())}'
    return f"{before} {draw(successors())}"


@st.composite
def rule_files(draw: st.DrawFn) -> str:
    """A rule file whose rules only lead to later ones, but for a recursion that counts down."""
    first, second, third = draw(bodies(3)), draw(bodies(2)), draw(bodies(1))
    return "\n".join(
        [
            HEADER,
            f"Lot --> {first}",
            f"A --> {second.replace('A', 'C') if 'A' in second else second}",
            f"B(n) --> case n < 1 : C else : t(0, 0.1, 0) s('0.9, '0.9, '0.9) B(n - 1) {draw(operations())}",
            f"C --> {third.replace('A', 'Leaf').replace('C', 'Leaf').replace('B(2)', 'Leaf').replace('B(h)', 'Leaf')}",
        ]
    )
