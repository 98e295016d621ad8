"""Built-in functions: the same for a constant, for a column, and as Python has them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.errors import BudgetError, DerivationError
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.builtins import attributes


def reported(expression: str, attributes: str = "", num_models: int = 1) -> list[float]:
    """The value of an expression for each model."""
    grammar = Grammar.parse(f'{attributes}\nLot --> report("value", {expression})')
    return derive(grammar, num_models, seed=1, footprint=(3.0, 4.0)).reports.value.tolist()


def test_print_shows_its_value_as_an_operation_and_passes_it_on_as_a_function():
    grammar = Grammar.parse(
        'attr h = print(3) + 4\nLot --> print("wide: " + scope.sx) extrude(h) print(print(h) > 5) A'
    )
    forest = derive(grammar, 2, seed=1, footprint=(3.0, 4.0))
    assert forest.prints == ("wide: 3", "wide: 3", "3", "3", "7", "7", "true", "true")
    assert forest.leaves.size[:, 1].tolist() == [7.0, 7.0]


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("1 + 2 * 3", 7),
        ("1 + (case 1 > 2 : 5 else : 7)", 8),
        ("(1 + 2) * 3", 9),
        ("-5 % 3", -2),
        ("7 / 2", 3.5),
        ("2 < 3 && !(1 == 2) || false", 1),
        ("sin(30)", 0.5),
        ("atan2(1, 1)", 45),
        ("pow(2, 10)", 1024),
        ("rint(2.6) + floor(-1.5) + ceil(1.2)", 3),
        ("max(1, min(5, 3))", 3),
        ("clamp(7, 0, 5)", 5),
        ("sqrt(2) * sqrt(2)", 2),
        ("ln(exp(3))", 3),
        ("abs(-2.5)", 2.5),
        ('len("abc" + 12)', 5),
        ('find("abcabc", "b", 1)', 4),
        ('count("abcabc", "bc")', 2),
        ('float(substring("a12b", 1, 3))', 12),
        ('len(replace("aXbX", "X", "--"))', 6),
        ('float(listItem("3;4;5;", 1))', 4),
        ('listSize("3;4;5;") + listIndex("a;b;", "b")', 4),
        ('len(getPrefix("a.b.c", ".")) + len(getSuffix("a.b.c", "."))', 2),
        ('bool("false")', 0),
        ('"a" + 1 == "a1"', 1),
        ("geometry.area", 12),
        ("geometry.nVertices() + geometry.nFaces", 5),
        ("scope.sx * scope.sz + scope.sy", 12),
        ("isnan(0 / 0)", 1),
    ],
)
def test_the_value_of_an_expression(expression, expected):
    assert reported(expression) == [pytest.approx(expected)]


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ('getRange("myTexture.hasName.001.jpg", ".", ".")', "hasName.001"),
        ('getRange("CityEngine", "CityEn", "tyEngine")', ""),
        ('listRemove("rule;your;city;", "*u*")', "your;city;"),
        ('listRemoveAll("rule;your;designs;and;your;cities;", "*u*")', "designs;and;cities;"),
        ('listRetainAll("floor;floor_1;floor_2;", "*_*")', "floor_1;floor_2;"),
        ('"" + listCount("rule;your;city;", "*y*") + listIndex("rule;your;city;", "*y")', "22"),
        ('listClean(";;my;city;rules;;your;;city;;")', "my;city;rules;your;city;"),
        ('listAdd("rule;your;", "city;") + listTerminate("a;b")', "rule;your;city;a;b;"),
        ('listRange("a;b;c;d;", 1, 3) + listLast("a;b;") + listFirst("c;d;")', "b;c;bc"),
        ('fileName("a/b/c.01.obj") + fileBasename("a/b/c.01.obj")', "c.01.objc.01"),
        ('fileDirectory("a/b/c.01.obj") + fileExtension("a/b/c.01.obj")', "a/b/obj"),
        ("colorHSVToHex(90, 0.5, 0.5) + colorRGBOToHex(1, 0, 2, 0.5)", "#608040#ff00ff80"),
        ('"" + colorHexToH("#60804080") + colorHexToO("#4080BF") + colorHexToS("#4080BF")', "9000.664921465968586"),
        ('max("abc", "def") + min("abc", "def") + clamp("b", "c", "d")', "defabcc"),
        ('"" + ("a" < "b") + ("b" <= "a") + isNull("x") + isNull(0 / 0)', "truefalsefalsetrue"),
        ('replace("a#b#", "#", 3) + substring("abc", -20, 2) + substring("abc", 2, 1)', "a3b3ab"),
        ('str(1.69 - 69 / 100) + bool("0.0") + bool("beneath the remains")', "1falsetrue"),
        ('"" + geometry.nEdges + geometry.nHoles + geometry.isPlanar(0.25) + geometry.isOriented(top)', "40truetrue"),
        ('"" + geometry.area(top) + geometry.area(side) + geometry.boundaryLength()', "12014"),
        ('"" + geometry.isClosedSurface() + geometry.isConcave() + geometry.isRectangular(1)', "falsefalsetrue"),
    ],
)
def test_the_text_that_the_reference_promises(expression, expected):
    assert reported(f'float({expression} == "{expected}")') == [1.0]


@pytest.mark.parametrize("expression", ['find("a", 5, 0)', "len(5)", "findFirst(4, 3)", 'min("a", 3)', '1 < "a"'])
def test_functions_of_text_refuse_other_types(expression):
    with pytest.raises(DerivationError, match=r"<text>:2:\d+: .*(expected a string|one type)"):
        reported(f"float({expression})")


def test_functions_of_text_work_row_by_row():
    lists = 'attr a = 50%: "red;green;" else: "blue;"\nattr n = 50%: 1 else: 7'
    assert set(reported("listSize(listAdd(a, str(n)))", lists, 64)) == {2.0, 3.0}
    assert set(reported('float(a < "c")', lists, 64)) == {0.0, 1.0}
    assert set(reported("rint(7 * colorHexToR(colorRGBToHex(n / 7, 0, 0)))", lists, 64)) == {1.0, 7.0}


def test_materials_can_be_read_back_as_text():
    text = 'Lot --> color("#ff8800") texture("wall.png") A\nA --> report("c", float(material.color.rgb == "#ff8800")) '
    text += 'report("t", float(material.colormap == "wall.png")) report("a", material.color.a)'
    assert derive(Grammar.parse(text), 1, seed=1).reports.value.tolist() == [1.0, 1.0, 1.0]


def test_a_random_item_of_a_list_is_drawn_evenly_and_recorded():
    grammar = Grammar.parse('attr item = listRandom("a;b;c;d;")\nLot --> report("is b", float(item == "b"))')
    forest = derive(grammar, 4000, seed=1)
    assert np.mean(forest.reports.value) == pytest.approx(0.25, abs=0.03)
    assert np.allclose(forest.log_probability(), np.log(0.25))


FUNCTIONS = ["sin", "cos", "tan", "exp", "sqrt", "floor", "ceil", "rint", "abs", "ln", "atan"]


@pytest.mark.parametrize("function", FUNCTIONS)
def test_a_constant_and_a_column_give_the_same_bits(function):
    column = reported(f"{function}(x)", "attr x = 50%: 0.7 else: 3.3", 40)
    constants = {reported(f"{function}({value})")[0] for value in (0.7, 3.3)}
    assert set(column) == constants


@pytest.mark.parametrize(("power", "base"), [(0.3, 1.7), (2.5, 9.1)])
def test_powers_do_not_depend_on_the_batch(power, base):
    one = reported(f"pow(x, {power})", f"attr x = 50%: {base} else: 2", 1)
    many = reported(f"pow(x, {power})", f"attr x = 50%: {base} else: 2", 64)
    assert many[0] == one[0]


def test_text_of_a_column_is_put_together_row_by_row():
    values = reported('len("h" + x + y)', 'attr x = 50%: 7 else: 100\nattr y = 50%: "ab" else: ""', 64)
    assert set(values) == {2.0, 4.0, 6.0}


def test_a_recursive_function_ends():
    assert reported("sum(10)", "sum(n) = case n <= 0: 0 else: n + sum(n - 1)") == [55.0]


def test_an_endless_function_is_refused():
    with pytest.raises(DerivationError, match="calls itself"):
        reported("f(1)", "f(n) = f(n + 1)")


def test_attributes_that_depend_on_each_other_in_a_circle_are_refused():
    with pytest.raises(DerivationError, match="a -> b -> a"):
        reported("a", "attr a = b + 1\nattr b = a + 1")


def test_numbers_and_strings_do_not_mix():
    with pytest.raises(DerivationError, match="expects numbers"):
        reported('3 * "a"')


def test_draws_of_two_calls_of_one_function_differ():
    values = reported("f - f", "f = rand(1, 2)", 8)
    assert all(value != 0.0 and math.isfinite(value) for value in values)


def test_an_attribute_is_drawn_once_for_each_model():
    values = reported("h - h", "attr h = rand(1, 2)", 8)
    assert np.array_equal(values, np.zeros(8))


def test_files_are_searched_with_a_pattern_that_differs_from_model_to_model(tmp_path):
    for name in ("a1.png", "a2.png", "b1.png"):
        (tmp_path / name).write_bytes(b"")
    text = """attr kind = 50%: "a" else: "b"
        Lot --> report("found", listSize(fileSearch(kind + "*.png"))) report("is", fileExists(kind + "2.png")) A"""
    reports = derive(Grammar.parse(text), 20, seed=1, assets=tmp_path).reports
    found, there = (reports.value[reports.key == reports.keys.index(key)] for key in ("found", "is"))
    assert set(zip(found.tolist(), there.tolist(), strict=True)) == {(2.0, 1.0), (1.0, 0.0)}


def test_every_shape_may_report_under_a_key_of_its_own():
    forest = derive(Grammar.parse('Lot --> split(x) { ~1 : report("x" + split.index, scope.sx) A }*'), 2, seed=1)
    keys = [forest.reports.keys[key] for key in forest.reports.key]
    assert sorted(set(keys)) == sorted(f"x{i}" for i in range(len(set(keys))))
    assert len(keys) == 2 * len(set(keys)) == len(forest.leaves)
    same = derive(Grammar.parse('Lot --> split(x) { ~1 : report("x", scope.sx) A }*'), 2, seed=1)
    assert sorted(forest.reports.value) == sorted(same.reports.value)


@pytest.mark.parametrize(
    "rules",
    [
        'twice(s, n) = case n == 0 : s else : twice(s + s, n - 1)\nLot --> print(twice("abcdefgh", 50))',
        'wide(s) = replace(s, "a", "aaaaaaaaaaaaaaaaaaaaaaaaaaa")\nLot --> print(wide(wide(wide(wide(wide("a"))))))',
        'more(s, n) = case n == 0 : s else : more(listAdd(s, s), n - 1)\nLot --> print(more("abcdefgh;", 50))',
    ],
)
def test_strings_do_not_grow_without_bound(rules):
    with pytest.raises(BudgetError, match="a string would have"):
        derive(Grammar.parse(rules), 1, seed=1)


TURNED = "extrude(5) t(1, 2, 3) r(10, 20, 30) s(1, 2, 3)"
SYSTEMS = ("scope", "pivot", "object", "world")


@pytest.mark.parametrize("source", SYSTEMS)
@pytest.mark.parametrize("target", SYSTEMS)
@pytest.mark.parametrize("kind", ["pos", "orient"])
def test_what_is_converted_and_back_is_as_it_was(source, target, kind):
    """An attribute may be called as a word of ``convert`` is: only the place tells which is meant."""
    there = ", ".join(f"convert({axis}, {source}, {target}, {kind}, x, 5, z)" for axis in "xyz")
    back = "".join(f'report("{axis}", convert({axis}, {target}, {source}, {kind}, a, b, c))' for axis in "xyz")
    rules = (
        f"attr x = 4\nattr z = 6\nLot --> comp(f) {{ all : Face }}\nFace --> {TURNED} A({there})\nA(a, b, c) --> {back}"
    )
    corners = np.array([[1.0, 0, 1], [1, 0, 4], [5, 0, 6], [5, 0, 3]])
    forest = derive(Grammar.parse(rules), 1, seed=1, footprint=corners)
    assert np.allclose(forest.reports.value, [4, 5, 6], atol=1e-9)


def test_the_corner_of_a_scope_in_world_coordinates_is_where_the_leaf_stands():
    corner = "".join(f'report("{axis}", convert({axis}, scope, world, pos, 0, 0, 0))' for axis in "xyz")
    forest = derive(Grammar.parse(f"Lot --> {TURNED} {corner} A"), 1, seed=1)
    assert np.allclose(forest.reports.value, forest.leaves.position[0])
    angles = "".join(f'report("{axis}", convert({axis}, scope, pivot, orient, 0, 0, 0))' for axis in "xyz")
    forest = derive(Grammar.parse(f"Lot --> extrude(5) r(10, 20, 30) {angles} A"), 1, seed=1)
    assert np.allclose(forest.reports.value, [10, 20, 30])


def test_the_size_and_the_corner_of_an_asset_are_those_of_its_file(tmp_path):
    (tmp_path / "tri.obj").write_text("v 1 2 3\nv 3 2 3\nv 1 6 4\nf 1 2 3\n")
    measures = "".join(f'report("{m}", assetInfo(listItem("tri.obj;", 0), {m}))' for m in ("sx", "sy", "sz"))
    measures += "".join(f'report("{m}", assetInfo("tri.obj", {m}))' for m in ("tx", "ty", "tz"))
    forest = derive(Grammar.parse(f"Lot --> {measures}"), 1, seed=1, assets=tmp_path)
    values = dict(zip((forest.reports.keys[key] for key in forest.reports.key), forest.reports.value, strict=True))
    assert values == {"sx": 2, "sy": 4, "sz": 1, "tx": 1, "ty": 2, "tz": 3}


def test_a_missing_asset_measures_as_the_box_that_stands_for_it(tmp_path):
    rules = 'Lot --> report("sy", assetInfo("none.obj", sy)) report("ty", assetInfo("none.obj", ty))'
    forest = derive(Grammar.parse(rules), 2, seed=1, assets=tmp_path)
    assert forest.reports.value.tolist() == [1.0, 1.0, 0.0, 0.0]
    (missing,) = forest.missing_assets
    assert (missing.path, missing.location.column) == ("none.obj", 22)


def test_horizontal_trim_planes_are_off_and_vertical_ones_on_until_rules_say_otherwise():
    rules = (
        'Lot --> set(trim.vertical, false) split(x) { ~1 : report("v", trim.vertical) report("h", trim.horizontal) A }'
    )
    assert derive(Grammar.parse(rules), 1, seed=1).reports.value.tolist() == [0.0, 0.0]


def test_what_no_picture_shows_of_a_material_is_remembered_below_and_forgotten_beside():
    rules = (
        'Lot --> [ set(material.name, material.name + "wet") set(material.shininess, 7) Told ] Told '
        'Told --> report(material.name + "/" + material.shader, material.shininess) A'
    )
    reports = derive(Grammar.parse(rules), 1, seed=1).reports
    told = [(reports.keys[key], value) for key, value in zip(reports.key, reports.value.tolist(), strict=True)]
    assert sorted(told) == [("/CityEngineShader", 1.0), ("wet/CityEngineShader", 7.0)]


def test_every_attribute_of_a_material_that_the_language_knows_can_be_read():
    names = [name for name in attributes() if name.startswith("material.")]
    rules = "Lot --> " + " ".join(f"print({name})" for name in names) + " A"
    assert len(derive(Grammar.parse(rules), 1, seed=1).prints) == len(names) > 50


def test_the_origin_of_the_initial_shape_is_its_first_corner_and_turn():
    names = [f"initialShape.origin.{kind}{axis}" for kind in "po" for axis in "xyz"]
    rules = "Lot --> t(3, 4, 5) r(0, 30, 0) " + "".join(f'report("{i}", {name})' for i, name in enumerate(names))
    angle = np.radians(25.0)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    corners = np.array([[0.0, 0, 4], [6, 0, 4], [6, 0, 0], [0, 0, 0]]) @ turn.T + [7, 2, 9]
    found = derive(Grammar.parse(rules), 1, seed=1, footprint=corners).reports.value
    assert np.allclose(found, [7, 2, 9, 0, 25, 0])


@pytest.mark.parametrize(
    ("ramp", "ends"),
    list(
        {
            "whiteToBlack": ("#ffffff", "#000000"),
            "greenToRed": ("#3ba800", "#ff0000"),
            "yellowToRed": ("#f5f500", "#f50000"),
            "redToBlue": ("#c44539", "#3661cf"),
            "orangeToBlue": ("#ffc800", "#0000ff"),
            "brownToBlue": ("#9c5621", "#218291"),
            "spectrum": ("#b952a4", "#ed2726"),
        }.items()
    ),
)
def test_a_color_ramp_goes_from_its_first_color_to_its_last_in_36_small_steps(ramp, ends):
    values = [-1.0, *((i + 0.5) / 36 for i in range(36)), 1.0, 7.0]
    rules = "Lot --> " + " ".join(f'print(colorRamp("{ramp}", {value}))' for value in values)
    prints = derive(Grammar.parse(rules), 1, seed=1).prints
    assert (prints[0], prints[1], prints[-2], prints[-1]) == (ends[0], *ends, ends[1])
    colors = np.array([[int(text[i : i + 2], 16) for i in (1, 3, 5)] for text in prints[1:-2]])
    assert len(np.unique(colors, axis=0)) == 36
    assert np.abs(np.diff(colors, axis=0)).max() <= 50


def test_a_ramp_nobody_knows_is_an_empty_text():
    assert derive(Grammar.parse('Lot --> print(colorRamp("rainbow", 0.5))'), 1, seed=1).prints == ("",)


@pytest.mark.parametrize(
    ("operations", "expected"),
    [
        ("extrude(world.up, 5)", 5.0),
        ("extrude(world.up, 5) split(y) { geometry.lowerheight : X }\nX -->", 5.0),
        ("extrude(world.up, 5) rotate(abs, world, 0, 90, 0)", 5.0),
        ("extrude(world.up.flatTop, 5)", 5.0),
        ("", 0.0),
        ("extrude(world.up, 5) reverseNormals()", 0.0),
    ],
)
def test_the_lower_height_is_that_of_the_lowest_corner_that_looks_up(operations, expected):
    slope = np.array([[0, 0, 0], [0, 0, 4], [3, 2, 4], [3, 2, 0.0]])
    grammar = Grammar.parse(f'Lot --> {operations} report("value", geometry.lowerheight)')
    assert derive(grammar, 1, seed=1, footprint=slope).reports.value == pytest.approx(expected)
