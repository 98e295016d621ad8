"""Arrays, as CityEngine's reference describes them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.errors import BudgetError, DerivationError
from grammarlab.language.grammar import Grammar

L_SHAPE = np.array([[0.0, 0, 0], [0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0]])
KNOWN = 'a = [1, 2, 3, 4]\nm = [1, 2, 3; 4, 5, 6; 7, 8, 9]\nwords = ["x", "y"]\n'


def aligned(text: str) -> str:
    """An array's text with its columns aligned at their ends, from one with tabs between them."""
    head, *lines = text.split("\n")
    rows = [line.split("\t") for line in lines]
    widths = [3 + max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join([head, *("".join(c.rjust(w) for c, w in zip(row, widths, strict=True)) for row in rows)])


def printed(value: str, definitions: str = KNOWN, num_models: int = 1, **options) -> list[str]:
    rules = f"{definitions}\n@StartRule\nLot --> extrude(2) print({value})"
    return list(derive(Grammar.parse(rules), num_models, seed=2, **options).prints)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("[1, 2.5, 3]", "(3)[1,2.5,3]"),
        ("[true, false]", "(2)[true,false]"),
        ('["B", "C"]', "(2)[B,C]"),
        ('["A", words, "E"]', "(4)[A,x,y,E]"),
        ("[-1; -2]", "(2x1)\n-1\n-2"),
        ("[0:2; 3, 3, 3]", "(2x3)\n0\t1\t2\n3\t3\t3"),
        ("[[-1; -2], [0:2; 3, 3, 3]; [0:2; 3, 3, 3], [-1; -2]]",
         "(4x4)\n-1\t0\t1\t2\n-2\t3\t3\t3\n0\t1\t2\t-1\n3\t3\t3\t-2"),
        ("[2 : 4]", "(3)[2,3,4]"),
        ("[0.5 : 3]", "(3)[0.5,1.5,2.5]"),
        ("[4 : 2]", "(0)[]"),
        ("[1 : 0.5 : 3]", "(5)[1,1.5,2,2.5,3]"),
        ("[4 : -1 : 2]", "(3)[4,3,2]"),
        ("[1 : -0.5 : 2]", "(0)[]"),
        ("[1 : -0.5 : 1]", "(1)[1]"),
        ("[1 : 0 : 1]", "(0)[]"),
        ("[0 : 0.15 : 0.5]", "(4)[0,0.15,0.3,0.45]"),
        ("[floatArray, 7]", "(1)[7]"),
        ("stringArray", "(0)[]"),
    ],
)  # fmt: skip
def test_arrays_are_written_and_printed_as_in_the_reference(value, expected):
    assert printed(value) == [aligned(expected)]


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("a[0]", "1"),
        ("a[3]", "4"),
        ("m[1, 1]", "5"),
        ("a[[0, 2]]", "(2)[1,3]"),
        ("a[[1, 1]]", "(2)[2,2]"),
        ("a[3 : -1 : 1]", "(3)[4,3,2]"),
        ("a[[0, 1; 2, 3]]", "(2x2)\n1\t2\n3\t4"),
        ("m[1, [0, 2]]", "(2)[4,6]"),
        ("m[[0, 0, 1], 2]", "(3x1)\n3\n3\n6"),
        ("m[0:2, [0, 2]]", "(3x2)\n1\t3\n4\t6\n7\t9"),
        ("a[[true, false, true]]", "(2)[1,3]"),
        ("m[[false, true, true], 0]", "(2x1)\n4\n7"),
        ("a[-1]", "0"),
        ("a[4]", "0"),
        ("words[2]", ""),
        ("a[[false, false, true, true, true]]", "(3)[3,4,0]"),
        ("m[[2, 3], -1:1]", "(2x3)\n0\t7\t8\n0\t0\t0"),
        ("m[3]", "4"),
        ("m[[0; 3; 6]]", "(3x1)\n1\n4\n7"),
        ("m[0, [0, 1; 2, 3]]", "(4)[1,2,3,0]"),
        ("a[[true, false; true, false]]", "(2)[1,3]"),
        ("floatArray[1:2, 1:3]", "(2x3)\n0\t0\t0\n0\t0\t0"),
    ],
)
def test_cells_are_taken_as_in_the_reference(value, expected):
    assert printed(value) == [aligned(expected)]


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("size(m) + nRows(m) * 10 + nColumns(a) * 100", "439"),
        ("nRows(floatArray) + size(stringArray)", "0"),
        ("[1, 2] == [1, 2]", "true"),
        ('["a", "b"] == ["a"; "b"]', "false"),
        ("[true, false] != [true, true]", "true"),
        ('"array: " + words', "array: (2)[x,y]"),
        ('words + " is an array"', "(2)[x,y] is an array"),
        ("str(a)", "(4)[1,2,3,4]"),
        ("fibonacci(10)", "(10)[0,1,1,2,3,5,8,13,21,34]"),
    ],
)
def test_arrays_are_compared_counted_and_handed_to_functions(value, expected):
    fibonacci = (
        "fibonacci(n) = case n <= 2 : [0:n-1] else : fibonacci([0,1], n)\n"
        "fibonacci(a, n) = case size(a) == n : a else : fibonacci([a, a[size(a)-2] + a[size(a)-1]], n)\n"
    )
    assert printed(value, KNOWN + fibonacci) == [aligned(expected)]


@given(st.lists(st.integers(-9, 9), min_size=1, max_size=8), st.integers(-3, 10))
def test_a_cell_is_that_of_a_python_list(cells, index):
    value = f"[{', '.join(map(str, cells))}][{index}]"
    assert printed(value, "") == [str(cells[index]) if 0 <= index < len(cells) else "0"]


def test_arrays_differ_from_shape_to_shape_and_travel_with_it():
    rules = """attr h = [rand(1, 2), 5]
        Lot --> set(h, [h[1], scope.sx]) split(x) { 3 : A([split.index : 2]) | 4 : A([7]) }
        A(v) --> report("first", v[0]) report("width", h[1]) report("size", size(v)) report("five", h[0]) B"""
    reports = derive(Grammar.parse(rules), 3, seed=2).reports
    values = {key: reports.value[reports.key == i].tolist() for i, key in enumerate(reports.keys)}
    assert sorted(values["first"]) == [0.0] * 3 + [7.0] * 3
    assert sorted(values["size"]) == [1.0] * 3 + [3.0] * 3
    assert (set(values["width"]), set(values["five"])) == ({20.0}, {5.0})


def test_an_array_attribute_is_drawn_once_and_recorded():
    forest = derive(Grammar.parse('attr h = [rand(1, 2), 5]\nLot --> report("h", h[0]) report("h", h[0])'), 4, seed=2)
    drawn = np.sort(forest.draws.value)
    assert np.array_equal(np.unique(forest.reports.value), drawn)
    assert len(drawn) == 4


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("comp(v) { all : comp.index }", "(8)[0,1,2,3,4,5,6,7]"),
        ("comp(f) { top : 1 }", "(6)[0,1,0,0,0,0]"),
        ("comp(f) { side = true }", "(6)[false,false,true,true,true,true]"),
        ("comp(f) { top : comp.sel + comp.index | side = str(comp.index) }", "(6)[,top0,0,0,0,0]"),
        ("comp(f) { 0 : 5 | geometry.area > 300 : 7 }", "(6)[5,7,0,0,0,0]"),
        ("comp(f) { aslant : 1 }", "(6)[0,0,0,0,0,0]"),
        ("size(comp(e) { all : scope.sx })", "12"),
        ("comp(f) { side : case comp.index % 2 == 0 : 1 else : 6 }", "(6)[0,0,1,6,1,6]"),
    ],
)
def test_comp_gives_a_value_for_each_component(value, expected):
    assert printed(value, "") == [aligned(expected)]


def test_values_of_components_are_those_that_the_operation_meets():
    rules = """areas = comp(f) { all : geometry.area }
        Lot --> roofHip(30) print(size(areas)) set(seen, areas) comp(f) { all : Face(areas[comp.index]) }
        attr seen = floatArray
        Face(expected) --> report("off", geometry.area - seen[comp.index]) A"""
    forest = derive(Grammar.parse(rules), 2, seed=1, footprint=L_SHAPE)
    assert len(forest.reports.value) > 10
    assert np.abs(forest.reports.value).max() < 1e-9


def test_components_draw_for_themselves_and_are_the_same_in_any_batch():
    rules = "Lot --> extrude(2) print(comp(f) { side : rand(1, 2) | top = rand(3, 4) })"
    whole = derive(Grammar.parse(rules), 6, seed=4)
    assert len(np.unique(whole.draws.value)) == 6 * 5
    assert derive(Grammar.parse(rules), 1, seed=4, first_model=3).prints == whole.prints[3:4]


def test_each_edge_is_set_back_by_its_distance():
    rules = """dists = comp(fe) { left : 5 | front = 2 }
        Lot --> setback(dists) { all : A | remainder : B }"""
    forest = derive(Grammar.parse(rules), 2, seed=1, footprint=(20.0, 10.0))
    rest = forest.nodes.symbol[forest.leaves.node] == forest.symbols.index("B")
    assert np.allclose(forest.leaves.position[rest], [5.0, 0.0, 0.0])
    assert np.allclose(forest.leaves.size[rest], [15.0, 0.0, 8.0])


def test_equal_distances_in_an_array_are_one_distance():
    one, many = (
        derive(Grammar.parse(f"Lot --> setback({distance}) {{ all = A | remainder : B }}"), 2, 1, footprint=L_SHAPE)
        for distance in ("2", "[2, 2, 2, 2, 2, 2, 9]")
    )
    assert np.array_equal(one.leaves.position, many.leaves.position)
    assert np.array_equal(one.leaves.size, many.leaves.size)
    short = derive(Grammar.parse("Lot --> setback([2]) { all = A | remainder : B }"), 1, 1, footprint=(20.0, 10.0))
    assert short.leaves.size.tolist() in ([[20, 0, 2], [20, 0, 8]], [[2, 0, 10], [18, 0, 10]])


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("a + 1", r"\+ expects single values, found a whole array and a float"),
        ("-a", "- expects a single value"),
        ("a == 1", "compares values of one type"),
        ("a < a", "expects single values"),
        ("sin(a)", "sin takes no arrays"),
        ("[1, true]", "cells of one type"),
        ("[1, 2; 3]", "rows of one type and length"),
        ("[[1; 2], 3]", "arrays of equal height"),
        ("a[true]", "numbers as indices"),
        ("3[0]", r"expected an array before '\['"),
        ("[1 : 0 / 0]", "finite number"),
        ("a .+ [1]", "arrays of one size"),
        ("comp(f) { top : 1 | side : true }", "values of one type, found bool and float"),
        ("comp(f) { top =: 1 }", "expects f, e, v, fe or fv"),
        ("size(3)", "expected an array, found a float"),
        ("case a : 1 else : 2", "found a whole array"),
    ],
)
def test_what_arrays_cannot_do_is_said_with_its_place(value, message):
    with pytest.raises(DerivationError, match=rf"<text>:\d+:\d+: .*{message}"):
        printed(value if not value.startswith("case") else f"({value})")


@pytest.mark.parametrize("value", ["[1 : 1000000]", "[1:1000][1:0.001:900, 1:900]", "[0 : 1 / 100000 : 9]"])
def test_arrays_are_bounded(value):
    with pytest.raises(BudgetError, match="array would have"):
        printed(value)


def test_all_arrays_together_are_bounded(monkeypatch):
    monkeypatch.setattr("grammarlab.derivation.state.array_table.MAX_CELLS_IN_ALL", 5_000)
    rules = "Lot --> split(x) { 0.1 : A([split.index : split.index + 99]) }*\nA(v) --> B"
    with pytest.raises(BudgetError, match="all arrays together"):
        derive(Grammar.parse(rules), 1, 1)


@pytest.mark.parametrize(
    "operation", ["extrude(a)", "color(a)", "t(a, 0, 0)", "i(a)", "split(x) { a : B }", "a% : B else : C"]
)
def test_operations_refuse_arrays(operation):
    with pytest.raises(DerivationError, match="found a whole array"):
        derive(Grammar.parse(f"{KNOWN}\n@StartRule\nLot --> {operation}"), 1, 1)


# What whole arrays become; the examples are those of CityEngine's reference.


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ('sortIndices(["c", "b", "d", "a"])', "(4)[3,1,0,2]"),
        ("sortIndices([2, 1, 3, 3, 1])", "(5)[1,4,0,2,3]"),
        ('sortIndices(["e", "c", "d"; "b", "a", "c"; "d", "a", "d"])', "(3x3)\n1\t2\t0\n4\t3\t5\n7\t6\t8"),
        ("sortRowIndices([4, 0, 1; 2, 1, 9; 1, 3, 0; 2, 1, 0])", "(4)[2,3,1,0]"),
        ("transpose(m[0:1, 0:2])", "(3x2)\n1\t4\n2\t5\n3\t6"),
        ("setElems([0, 0, 0, 0, 0, 0], 2, 1)", "(6)[0,0,1,0,0,0]"),
        ("setElems([0, 0, 0, 0, 0, 0], [5, 1, 3], [1:3])", "(6)[0,2,0,3,0,1]"),
        ("setElems([0, 0, 0, 0, 0, 0], [1, 1, 1], [1:3])", "(6)[0,3,0,0,0,0]"),
        ("setElems([1:7], [1:7] .> 4, [3, 2, 1])", "(7)[1,2,3,4,3,2,1]"),
        ("setElems([0, 0; 0, 0], [1, 0], [1, 0], [1, 2; 3, 4])", "(2x2)\n4\t3\n2\t1"),
        ("setElems([1, 1], [-1, 3], 9)", "(4)[1,1,0,9]"),
        ('sum(a) + "," + sum(words) + "," + sum(floatArray())', "10,xy,0"),
        ('findFirst(a, 3) + findFirst(words, "z") + findFirst("abab", "b", 2)', "4"),
        ('floatArray(["1", "b"])', "(2)[1,nan]"),
        ('stringArray([1, 2]) == listToArray("1;2;")', "true"),
        ('listFromArray(["p", "q"])', "p;q;"),
        ("[5, 6] .- a[0:1]", "(2)[4,4]"),
        ("2 .* a", "(4)[2,4,6,8]"),
        ("a .% 2 .== 0", "(4)[false,true,false,true]"),
        ('"w" .+ words', "(2)[wx,wy]"),
        (".!([true, false] .&& true)", "(2)[false,true]"),
        ("abs(.-a)", "(4)[1,2,3,4]"),
        ('splitString(".b.", ".")', "(3)[,b,]"),
        ('splitString("a  b c", "$\\\\s+")', "(3)[a,b,c]"),
        ('splitString("ab", "")', "(4)[,a,b,]"),
    ],
)
def test_arrays_become_what_the_reference_says(value, expected):
    assert printed(value) == [aligned(expected)]


@given(st.lists(st.integers(-9, 9), max_size=8))
def test_cells_in_the_order_of_their_sorted_indices_ascend(cells):
    array = f"[{', '.join(map(str, cells))}]"
    assert printed(f"({array})[sortIndices({array})]") == [f"({len(cells)})[{','.join(map(str, sorted(cells)))}]"]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("setElems(a, [0, 1], [1, 2, 3])", "one for each of 2 cells, found 3"),
        ('setElems(a, 0, "x")', "values of the type float, found string"),
        ("a .&& a", "cells of the types float and float"),
        (".!a", "cells of the type bool"),
        ('splitString("aaaa", "$(a+)+b")', "could take too long"),
        ('splitString("a", "$[")', "is not a regular expression"),
    ],
)
def test_what_whole_arrays_cannot_do_is_said(value, message):
    with pytest.raises(DerivationError, match=message):
        printed(value)


def test_arrays_do_not_grow_without_bounds():
    with pytest.raises(BudgetError, match="more than 100,000"):
        printed("setElems(a, 1e9, 1)")


def test_tables_and_texts_come_from_the_asset_folder(tmp_path):
    (tmp_path / "floors.csv").write_text("Floor;Height\n0;10\n1;7,5\n2\n", encoding="utf-8")
    (tmp_path / "note.txt").write_bytes("one\r\ntwo\x07".encode("utf-16"))
    values = [
        'readStringTable("floors.csv")',
        'readFloatTable("floors.csv")[1, 1] + nRows(readFloatTable("floors.csv"))',
        'readTextFile("note.txt")',
        'readStringTable("absent.csv")',
        'filesSearch("*.csv")',
    ]
    assert [printed(value, assets=tmp_path)[0] for value in values] == [
        aligned("(4x2)\nFloor\tHeight\n0\t10\n1\t7,5\n2\t"),
        "14",
        "one\ntwo?",
        "(0)[]",
        "(1)[floors.csv]",
    ]
    with pytest.raises(DerivationError, match="outside the asset folder"):
        printed('readTextFile("../secret.txt")', assets=tmp_path)


def test_columns_are_aligned_as_the_runtime_prints_them():
    # Measured: PRT 3.3.11669, the package arrayAttrs2d of pyprt.
    assert printed("[1, 2, 3; 4, 5, 6]") == ["(2x3)\n   1   2   3\n   4   5   6"]
    assert printed("[false, true; true, false]") == ["(2x2)\n   false    true\n    true   false"]
    assert printed('["first", "row"; "second", "row"]') == ["(2x2)\n    first   row\n   second   row"]
