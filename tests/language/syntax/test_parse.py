"""What texts mean."""

import pytest

from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Array,
    Attribute,
    Binary,
    Block,
    Boolean,
    Call,
    Case,
    Function,
    Group,
    Import,
    Index,
    Invoke,
    Name,
    Number,
    Part,
    Rule,
    Scoped,
    Sequence,
    Stochastic,
    String,
    Style,
    Unary,
)
from tests.language.syntax.read import definitions, items, rule_body, value

A, B, C = (Sequence((Invoke(name),)) for name in "ABC")


# Where definitions end


def test_a_name_with_parameters_before_an_arrow_begins_a_rule():
    first, second = definitions("A --> B C(x) --> D")
    assert first == Rule("A", (), B)
    assert second == Rule("C", ("x",), Sequence((Invoke("D"),)))


def test_rules_and_functions_without_line_ends_are_told_apart():
    found = definitions("A --> B(1) C f(x) = x D(y) --> NIL g = 2 attr h = f(3) const c = g E --> A")
    assert [node.name for node in found if not isinstance(node, Import)] == ["A", "f", "D", "g", "h", "c", "E"]


def test_an_equals_sign_inside_braces_begins_nothing():
    assert len(definitions("A --> comp(f) { front = B | side : C }")) == 1


def test_parameters_may_hold_parentheses_of_the_body_before():
    (first, second) = definitions("A --> B (1) C (x) --> D")
    assert first == Rule("A", (), Sequence((Invoke("B", (Number(1.0),)),)))
    assert second == Rule("C", ("x",), Sequence((Invoke("D"),)))


def test_an_empty_body_ends_where_a_line_begins_a_definition():
    first, second, third = definitions("A -->\nf = 1\nB --> C")
    assert first == Rule("A", (), Sequence(()))
    assert second == Function("f", (), Number(1.0))
    assert third == Rule("B", (), C)


def test_start_is_a_keyword_before_a_rule_and_a_symbol_elsewhere():
    first, second = definitions("start Lot --> lib.start start\nB --> C")
    assert first == Rule("Lot", (), Sequence((Invoke("lib.start"), Invoke("start"))), keyword="start")
    assert second == Rule("B", (), C)


@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r", "\u2028"])
def test_line_ends_of_every_kind_count_alike(line_end):
    grammar = Grammar.parse(f"// one{line_end}A --> B{line_end}{line_end}C --> D")
    assert [node.location.line for node in grammar.tree.definitions] == [2, 4]


def test_comments_of_three_kinds_are_skipped_and_strings_hide_them():
    text = 'A --> B // x --> y\n# C --> D\n/* E --> F\n */ color("#ff0000") i("http://x/*y*/")'
    assert rule_body(text) == Sequence(
        (Invoke("B"), Invoke("color", (String("#ff0000"),)), Invoke("i", (String("http://x/*y*/"),)))
    )


@pytest.mark.parametrize("line", ['version "2023.0"', "version 2023.0"])
def test_the_version_is_read_with_and_without_quotes(line):
    assert Grammar.parse(f"\ufeff/* head */ {line}\nA --> B").tree.version == "2023.0"


# Choices


def test_an_else_belongs_to_the_innermost_open_choice():
    assert rule_body("L --> case a : case b : A else : B else : C") == Case(
        (Name("a"), None), (Case((Name("b"), None), (A, B)), C)
    )


def test_cases_after_percentages_belong_to_the_cases_around():
    body = rule_body("L --> case a : 30% : A 70% : B case b : C")
    assert body == Case((Name("a"), Name("b")), (Stochastic((Number(30.0), Number(70.0)), (A, B)), C))


def test_a_complete_choice_inside_another_leaves_the_rest_to_it():
    body = rule_body("L --> 50% : 40% : A else : B 50% : C")
    assert body == Stochastic((Number(50.0), Number(50.0)), (Stochastic((Number(40.0), None), (A, B)), C))


@pytest.mark.parametrize(
    ("percentage", "tree"),
    [
        ("30", Number(30.0)),
        ("share", Name("share")),
        ("(1 + share)", Binary("+", Number(1.0), Name("share"))),
        ("2 * share", Binary("*", Number(2.0), Name("share"))),
        ("f(2)", Call("f", (Number(2.0),))),
        ("shares[1]", Index(Name("shares"), (Number(1.0),))),
        ("30 % 7", Binary("%", Number(30.0), Number(7.0))),
    ],
)
def test_percentages_are_expressions(percentage, tree):
    assert rule_body(f"L --> {percentage}% : A {percentage} % : B else : C") == Stochastic(
        (tree, tree, None), (A, B, C)
    )


def test_a_space_before_parentheses_keeps_a_percentage_from_the_symbol_before():
    assert rule_body("L --> 10% : A (x)% : B") == Stochastic((Number(10.0), Name("x")), (A, B))


def test_choices_stand_in_parts_brackets_functions_and_arguments():
    (block, scoped, call) = items("split(x) { 1 : 50% : A else : B } [ case a : A else : B ] set(h, 20% : 1 else : 2)")
    half = Stochastic((Number(50.0), None), (A, B))
    assert block == Block("split", (Name("x"),), Group((Part(Number(1.0), half),)))
    assert scoped == Scoped(Case((Name("a"), None), (A, B)))
    assert call == Invoke("set", (Name("h"), Stochastic((Number(20.0), None), (Number(1.0), Number(2.0)))))
    assert value("270 + (case a : 90 else : 0)") == Binary(
        "+", Number(270.0), Case((Name("a"), None), (Number(90.0), Number(0.0)))
    )


# Definitions


def test_annotations_keep_their_order_and_arguments():
    (attribute,) = definitions('@Group("x", 1) @Range(min=0, max=1)\n@Hidden @Enum("a", restricted=false) attr h = 1')
    assert isinstance(attribute, Attribute)
    assert attribute.annotations == (
        Annotation("Group", (("", String("x")), ("", Number(1.0)))),
        Annotation("Range", (("min", Number(0.0)), ("max", Number(1.0)))),
        Annotation("Hidden"),
        Annotation("Enum", (("", String("a")), ("restricted", Boolean(False)))),
    )


def test_handle_annotations_have_vectors_and_shapes_on_the_way_up():
    (attribute,) = definitions("@Handle(shape=Lane^2, translate={-.5, 0, 1}) attr h = 1")
    assert isinstance(attribute, Attribute)
    ((_, shape), (_, vector)) = attribute.annotations[0].arguments
    assert shape == Name("Lane^2")
    assert vector == Array(((Unary("-", Number(0.5)), Number(0.0), Number(1.0)),))


def test_imports_name_styles_values_protected_attributes_and_rules():
    (statement,) = definitions('@Hidden import lib(s, t) : "a/b.cga" (h = 2, w, Roof(x) --> roofHip(x) R)')
    assert statement == Import(
        "lib",
        "a/b.cga",
        (("h", Number(2.0)),),
        (Annotation("Hidden"),),
        ("s", "t"),
        ("w",),
        (Rule("Roof", ("x",), Sequence((Invoke("roofHip", (Name("x"),)), Invoke("R")))),),
    )


def test_empty_parentheses_protect_all_attributes_of_an_import():
    plain, protecting = definitions('import a : "f.cga"\nimport b : "f.cga" ()')
    assert isinstance(plain, Import)
    assert isinstance(protecting, Import)
    assert plain.protected == ()
    assert protecting.protected is None


def test_styles_and_constants():
    assert definitions("style Red\nstyle Dark extends Red\nconst c = 1\nconst f(x) = x") == (
        Style("Red"),
        Style("Dark", "Red"),
        Attribute("c", Number(1.0), True),
        Function("f", ("x",), Name("x"), True),
    )


def test_local_variables_stand_between_name_and_value():
    (function,) = definitions("d(x) with ( y := x * x  z := y ) = z")
    assert isinstance(function, Function)
    assert [variable.name for variable in function.variables] == ["y", "z"]


def test_a_dynamic_import_redefines_attributes_at_the_call():
    (item,) = items("lib(h = 3).Lot(1)")
    assert item == Invoke("lib.Lot", (Number(1.0),), overrides=(Attribute("h", Number(3.0)),))


def test_locations_underline_what_they_name():
    text = "Lot -->\n\t extrude(world.up, hight)"
    body = rule_body(text)
    assert isinstance(body, Sequence)
    (operation,) = body.items
    assert isinstance(operation, Invoke)
    name = operation.arguments[1]
    assert (operation.location.line, operation.location.column, operation.location.length) == (2, 3, 24)
    assert (name.location.line, name.location.column, name.location.length) == (2, 21, 5)
