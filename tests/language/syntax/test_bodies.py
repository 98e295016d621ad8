"""What expressions and operations mean."""

import pytest

from grammarlab.errors import LanguageError
from grammarlab.language.syntax.syntax_tree import (
    Array,
    Binary,
    Block,
    Boolean,
    Call,
    Components,
    Floating,
    Group,
    Index,
    Inline,
    Invoke,
    Name,
    Number,
    Part,
    Relative,
    Scatter,
    Sequence,
    Span,
    String,
    Unary,
)
from tests.language.syntax.read import items, value

A, B, C = (Sequence((Invoke(name),)) for name in "ABC")


# Expressions


@pytest.mark.parametrize(
    ("loose", "tight"), [("||", "&&"), ("&&", "=="), ("==", "<"), ("!=", ">="), ("<", "+"), ("-", "*"), ("+", "%")]
)
def test_operators_bind_as_in_c(loose, tight):
    a, b, c = Name("a"), Name("b"), Name("c")
    assert value(f"a {loose} b {tight} c") == Binary(loose, a, Binary(tight, b, c))
    assert value(f"a {tight} b {loose} c") == Binary(loose, Binary(tight, a, b), c)
    assert value(f"a {tight} b {tight} c") == Binary(tight, Binary(tight, a, b), c)


@pytest.mark.parametrize(
    ("text", "number"), [("1", 1), (".5", 0.5), ("1.", 1), ("1e-3", 0.001), ("2.5E+2", 250), ("007", 7), ("0.1", 0.1)]
)
def test_numbers(text, number):
    assert value(text) == Number(float(number))


def test_signs_bind_tighter_than_operators_and_looser_than_indices():
    assert value("-a[0] * !b") == Binary("*", Unary("-", Index(Name("a"), (Number(0.0),))), Unary("!", Name("b")))
    assert value("a - -1") == Binary("-", Name("a"), Unary("-", Number(1.0)))


def test_relative_binds_tightly_and_floating_spans_the_size():
    (s, block) = items("s('1+0.3, '-.5, '(a+b)) split(x) { ~2*a : A | ~'0.5 : B | '0.5 : C }")
    assert s == Invoke(
        "s",
        (
            Binary("+", Relative(Number(1.0)), Number(0.3)),
            Relative(Unary("-", Number(0.5))),
            Relative(Binary("+", Name("a"), Name("b"))),
        ),
    )
    assert isinstance(block, Block)
    assert [part.head for part in block.group.parts if isinstance(part, Part)] == [
        Floating(Binary("*", Number(2.0), Name("a"))),
        Floating(Relative(Number(0.5))),
        Relative(Number(0.5)),
    ]


def test_arrays_have_rows_columns_and_spans():
    assert value("[1,2;3,4]") == Array(((Number(1.0), Number(2.0)), (Number(3.0), Number(4.0))))
    assert value("[]") == Array(())
    assert value("[1:3]") == Array(((Span(Number(1.0), Number(3.0)),),))
    assert value("[9:-2:1, 5]") == Array(((Span(Number(9.0), Number(1.0), Unary("-", Number(2.0))), Number(5.0)),))
    assert value("a[1, 2]") == Index(Name("a"), (Number(1.0), Number(2.0)))


def test_operators_with_a_dot_work_element_by_element():
    assert value("[1] .* 2 .== x") == Binary(".==", Binary(".*", Array(((Number(1.0),),)), Number(2.0)), Name("x"))


def test_comp_is_an_expression_too():
    assert value("comp(fe) { front : scope.sx | all = 0 }") == Components(
        (Name("fe"),), (Part(Name("front"), Name("scope.sx")), Part(Name("all"), Number(0.0), True))
    )


@pytest.mark.parametrize(
    ("text", "meaning"),
    [(r'"a\"b"', 'a"b'), (r'"a\\b"', "a\\b"), (r'"a\nb"', "a\nb"), (r'"a\.b"', r"a\.b"), (r'"\\n"', "\\n"), ('""', "")],
)
def test_escapes_in_strings(text, meaning):
    assert value(text) == String(meaning)


def test_booleans_and_dotted_names():
    assert value("true") == Boolean(True)
    assert value("lib.height") == Name("lib.height")


# Operations


def test_a_dot_behind_a_symbol_belongs_to_it():
    assert items("Roof. Wall./* c */ A.") == (Invoke("Roof."), Invoke("Wall."), Invoke("A."))


def test_operations_stand_without_parentheses():
    first, second = items("reverseNormals primitiveCube()")
    assert (first, second) == (Invoke("reverseNormals"), Invoke("primitiveCube"))
    assert isinstance(first, Invoke)
    assert isinstance(second, Invoke)
    assert not first.parenthesised
    assert second.parenthesised


def test_groups_nest_and_repeat_with_a_star_that_may_stand_apart():
    (block, after) = items("split(y) { 1 : A | { ~1 : B | { 2 : C }* } * | 3 : A }* X")
    inner = Group((Part(Number(2.0), C),), True)
    assert block == Block(
        "split",
        (Name("y"),),
        Group(
            (
                Part(Number(1.0), A),
                Group((Part(Floating(Number(1.0)), B), inner), True),
                Part(Number(3.0), A),
            ),
            True,
        ),
    )
    assert after == Invoke("X")


def test_parts_are_separate_combined_or_connected():
    (block,) = items("comp(f) { front : A | side = B | all =: C }")
    assert isinstance(block, Block)
    assert [(part.inclusive, part.connected) for part in block.group.parts if isinstance(part, Part)] == [
        (False, False),
        (True, False),
        (False, True),
    ]


def test_selectors_are_names_numbers_and_expressions():
    (block,) = items("comp(f) { 0 : A | street.front : A | i + 1 : A | f(1) && top : A }")
    assert isinstance(block, Block)
    assert [part.head for part in block.group.parts if isinstance(part, Part)] == [
        Number(0.0),
        Name("street.front"),
        Binary("+", Name("i"), Number(1.0)),
        Binary("&&", Call("f", (Number(1.0),)), Name("top")),
    ]


def test_scatter_inline_and_boolean_operations():
    found = items(
        "scatter(surface, 9, uniform) { A B } inline A inline(unify) { B C } "
        "union A subtract(swap) { B C } inline comp(f) { all : A } intersect { B C | A }"
    )
    block = Block("comp", (Name("f"),), Group((Part(Name("all"), A),)))
    both = Sequence((Invoke("B"), Invoke("C")))
    assert found == (
        Scatter((Name("surface"), Number(9.0), Name("uniform")), Sequence((Invoke("A"), Invoke("B")))),
        Inline("inline", "", A),
        Inline("inline", "unify", both),
        Inline("union", "", A),
        Inline("subtract", "swap", both),
        Inline("inline", "", Sequence((block,))),
        Inline("intersect", "", both, A),
    )


def test_the_perimeter_split_has_depths_and_a_remainder():
    (block,) = items("splitAndSetbackPerimeter(1) { 2 : 3 : A | ~1 : d : B }* { remainder : C }")
    assert block == Block(
        "splitAndSetbackPerimeter",
        (Number(1.0),),
        Group(
            (
                Part(Number(2.0), A, depth=Number(3.0)),
                Part(Floating(Number(1.0)), B, depth=Name("d")),
            ),
            True,
        ),
        Group((Part(Name("remainder"), C),)),
    )


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("split(y) { split(y) { ~2 : A | ~2 : B }* }", "split(y) { ~1 : split(y) { ~2 : A | ~2 : B }* }"),
        ("split(x) { 1 : A | split(y) { 2 : B } | 1 : C }", "split(x) { 1 : A | ~1 : split(y) { 2 : B } | 1 : C }"),
        ("split(x) { { comp(f) { top : A } | 1 : B }* }", "split(x) { { ~1 : comp(f) { top : A } | 1 : B }* }"),
        ("split(x) { setback(1) { all : A } }", "split(x) { ~1 : setback(1) { all : A } }"),
    ],
)
def test_a_part_of_split_that_is_a_block_without_a_size_takes_the_room_that_is_left(written, meant):
    assert items(written) == items(meant)


@pytest.mark.parametrize(
    "text",
    ["split(x) { A }", "split(x) { split(y) { 1 : A } B }", "comp(f) { split(x) { 1 : A } }", "split(x) { split }"],
)
def test_other_parts_need_a_size_or_a_selector(text):
    with pytest.raises(LanguageError):
        items(text)
