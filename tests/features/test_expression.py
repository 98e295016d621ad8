"""The little language of preferences."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.features.expression import MAX_FEATURES, MAX_STEPS, Expression
from grammarlab.features.patterns.operations import FUNCTIONS, OPERATIONS
from grammarlab.features.patterns.pattern import Apply, Draw, Pattern, Threshold
from grammarlab.features.patterns.pattern_text import parse as parse_pattern

PATTERNS = ("{A}", "{A:0 > B}", "{C >> D[E, F]}")


def value(text, definitions=None, **features):
    """The expression on one model; features by name: A=2."""
    found = Expression.parse(text, definitions)
    return float(found.evaluate(np.array([[features[str(f)] for f in found.features]], dtype=float))[0])


# Against Python itself: every text below means the same there, once & and | stand for and and or ---------------------


def tree():
    leaf = st.one_of(
        st.sampled_from(["x", "y", "z"]), st.integers(0, 9).map(str), st.sampled_from(["0.5", "2.5e-1", ".25", "3."])
    )

    def grow(inner):
        binary = st.sampled_from(["+", "-", "*", "/", "%", "<", "<=", "==", "!=", ">", ">=", "and", "or"])
        return st.one_of(
            st.tuples(inner, binary, inner).map(lambda t: ("binary", *t)),
            st.tuples(st.sampled_from(["-", "+", "not "]), inner).map(lambda t: ("unary", *t)),
            st.tuples(st.sampled_from(["min", "max"]), st.lists(inner, min_size=2, max_size=3)).map(
                lambda t: ("call", *t)
            ),
            st.tuples(st.sampled_from(["abs", "log", "exp", "sqrt"]), inner.map(lambda t: [t])).map(
                lambda t: ("call", *t)
            ),
        )

    return st.recursive(leaf, grow, max_leaves=12)


def text_of(node):
    match node:
        case str():
            return {"x": "{A}", "y": "{B}", "z": "$z"}.get(node, node)
        case ("binary", left, sign, right):
            return f"({text_of(left)} {sign} {text_of(right)})"
        case ("unary", sign, inner):
            return f"({sign}{text_of(inner)})"
        case (_, name, inner):
            return f"{name}({', '.join(map(text_of, inner))})"
    raise AssertionError(node)


def finite(number):
    return number if math.isfinite(number) else 0.0


def meaning(node, values):
    """What the documentation says, in plain Python."""

    def of(inner):
        return meaning(inner, values)

    try:
        match node:
            case "x" | "y" | "z":
                return values[node]
            case str():
                return float(node)
            case ("binary", left, sign, right):
                a, b = of(left), of(right)
                python = {"and": "bool(a) and bool(b)", "or": "bool(a) or bool(b)"}.get(sign, f"a {sign} b")
                return finite(float(eval(python, {"a": a, "b": b})))  # noqa: S307
            case ("unary", sign, inner):
                return finite(float(eval(f"{sign}a", {"a": of(inner)})))  # noqa: S307
            case ("call", "min" | "max" as name, inner):
                return {"min": min, "max": max}[name](map(of, inner))
            case ("call", "abs", [inner]):
                return abs(of(inner))
            case ("call", name, [inner]):
                return finite(getattr(math, name)(of(inner)))
    except (ZeroDivisionError, ValueError, OverflowError):
        return 0.0


@given(tree(), st.lists(st.integers(0, 4), min_size=3, max_size=3))
def test_an_expression_means_what_it_means_in_python(node, numbers):
    values = dict(zip("xyz", map(float, numbers), strict=True))
    found = Expression.parse(text_of(node))
    columns = []
    for feature in found.features:
        if isinstance(feature, Threshold):
            columns.append(float(values["z"] < feature.bound))
        else:
            columns.append(values[{"A": "x", "B": "y", "z": "z"}[str(feature)]])
    expected = meaning(node, values)
    assert found.evaluate(np.array([columns]))[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("8 / 4 / 2", 1),
        ("8 - 4 - 2", 2),
        ("-2 * -3", 6),
        ("7 % 3 * 2", 2),
        ("1 + 7 % 3", 2),
        ("-1 % 3", 2),
        ("7.5 % -2", -0.5),
        ("1 < 2 < 3", 1),
        ("1 < 3 < 2", 0),
        ("3 > 2 > 1 > 0 != 5", 1),
        ("1 + 1 == 2", 1),
        ("1 or 0 and 0", 1),
        ("not 0 and 0", 0),
        ("not 1 == 2", 1),
        ("2 and 3", 1),
        ("min(3, 1, 2) + max(3, 1, 2)", 4),
        ("abs(-3) + sqrt(16)", 7),
        ("log(exp(2))", 2),
        ("floor(2.7) + 10 * ceil(2.2) + 100 * rint(2.3)", 232),
        ("floor(-2.7) + 10 * ceil(-2.2) + 100 * rint(2.5)", 177),
        ("choose(0, 10, 1, 20, 30)", 20),
        ("choose(0, 10, 0, 20, 30)", 30),
        ("1e2 + .5 + 2.", 102.5),
    ],
)
def test_precedence_and_functions(text, expected):
    assert value(text) == pytest.approx(expected)


@pytest.mark.parametrize(
    "text",
    [
        *("1 / 0", "0 / 0", "-1 / 0", "1 % 0", "0 % 0", "log(0)", "log(0 - 1)", "sqrt(-1)", "exp(1000)", "1e308 * 10"),
        *("{A} / {B}", "{A} % {B}", "log({B})"),
    ],
)
def test_what_no_finite_number_expresses_is_zero(text):
    assert value(text, A=1, B=0) == 0


@pytest.mark.parametrize(
    ("text", "below", "not_below"),
    [("$h < 5", 1, 0), ("5 > $h", 1, 0), ("$h >= 5", 0, 1), ("5 <= $h", 0, 1), ("$h < 2 + 3", 1, 0)],
)
def test_a_draw_compared_with_a_number_reads_a_threshold_only(text, below, not_below):
    found = Expression.parse(text)
    assert found.features == (Threshold("h", 5.0),)
    assert found.evaluate(np.array([[1.0], [0.0]])).tolist() == [below, not_below]


def test_open_and_closed_bounds_differ_by_the_last_bit():
    closed, open_ = Expression.parse("$h <= 5"), Expression.parse("$h < 5")
    assert closed.features == (Threshold("h", float(np.nextafter(5.0, 6.0))),)
    assert open_.features == (Threshold("h", 5.0),)
    assert Expression.parse("$h > 5").features == closed.features


def test_a_range_reads_two_thresholds():
    found = Expression.parse("1 <= $h < 5")
    assert found.features == (Threshold("h", 1.0), Threshold("h", 5.0))
    assert found.evaluate(np.array([[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]])).tolist() == [1, 0, 0]


def test_a_draw_in_arithmetic_is_read_as_a_number():
    assert Expression.parse("$w * $h < 9").features == (Draw("w"), Draw("h"))
    assert Expression.parse("$Wall#2:1 > 0").features == (Draw("Wall#2", 1),)


def test_the_features_are_those_that_the_value_depends_on_each_once():
    found = Expression.parse("({A} + {A}) * {B:0} + 0 * 7 + { A }", {"unused": Expression.parse("{C}")})
    assert found.features == (Pattern("A"), Pattern("B", branch=(0,)))


@pytest.mark.parametrize("text", PATTERNS)
def test_a_pattern_in_braces_is_the_pattern(text):
    assert Expression.parse(text).features == (parse_pattern(text[1:-1]),)


@given(st.integers(0, 2**32))
def test_a_batch_equals_its_members(seed):
    found = Expression.parse("choose({A} > 1 and not {B}, {A} / {C}, {B} + {C} > 3, log({C}), -{B})")
    values = np.random.default_rng(seed).integers(0, 4, (20, len(found.features))).astype(float)
    alone = [found.evaluate(row[None])[0] for row in values]
    np.testing.assert_array_equal(found.evaluate(values), alone)
    np.testing.assert_array_equal(found.evaluate(values[:0]), [])


def test_a_definition_stands_for_its_value():
    small = Expression.parse("{Block} < 3")
    tall = Expression.parse("not small and {Tower}", {"small": small})
    assert Expression.parse("10 * tall + small", {"small": small, "tall": tall}) == Expression.parse(
        "10 * (not ({Block} < 3) and {Tower}) + ({Block} < 3)"
    )


def test_parts_that_are_used_many_times_are_evaluated_once():
    definitions = {"d0": Expression.parse("{A}")}
    for i in range(60):
        definitions[f"d{i + 1}"] = Expression.parse(f"d{i} + d{i}", definitions)
    assert len(definitions["d60"].steps) == 61
    assert definitions["d60"].evaluate(np.array([[1.0]]))[0] == 2.0**60


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "found nothing"),
        ("  \n ", "found nothing"),
        ("1 +", "expected a value: a number, a {pattern}, a $draw, a name or a parenthesis; found the end"),
        ("(1 + 2", "a closing parenthesis, or the end; found the end"),
        ("1 2", "expected an operator such as +, < or and"),
        ("{A} = 2", "to compare, write =="),
        ("{A} && {B}", "write and"),
        ("{A} || {B}", "write or"),
        ("!{A}", "write not"),
        ("{A}^2", "no powers"),
        ("50%", "expected a value: a number, a {pattern}, a $draw, a name or a parenthesis; found the end"),
        ("{A", "a pattern ends with }"),
        ("A} + 1", "a pattern begins with {"),
        ("$", "after $ comes the name of an attribute"),
        ("'a'", "texts have no place here"),
        ("smal + 1", "unknown name 'smal'; did you mean small?"),
        ("xyz", "known names: small, min"),
        ("min(1)", "expected min(a, b, ...), found 1 values"),
        ("abs(1, 2)", "expected abs(x), found 2 values"),
        ("choose(1, 2)", "expected choose(when, value, ..., otherwise), found 2 values"),
        ("sin(1)", "'sin' is not a function; expected one of min, max, abs, log, exp, sqrt, floor, ceil, rint, choose"),
        ("small(1)", "'small' is not a function"),
        ("min + 1", "min is a function: expected min(a, b, ...)"),
        ("1e999", "too large"),
        ("{A > }", "in the pattern {A > }: expected a symbol or *"),
        ("__import__('os')", "expected a value"),
        ("small.real", "expected an operator"),
        ("[1][0]", "conditions of a pattern are inside its braces"),
    ],
)
def test_a_mistake_is_explained(text, says):
    with pytest.raises(UsageError) as caught:
        Expression.parse(text, {"small": Expression.parse("{A} < 3")})
    assert says in str(caught.value)


def test_the_place_of_a_mistake_is_underlined():
    with pytest.raises(UsageError) as caught:
        Expression.parse("{A} > 1\n  and bigg < 2\n  or 1")
    assert str(caught.value).endswith("\n    and bigg < 2\n        ^^^^")


def test_the_place_is_shown_in_a_long_line_too():
    with pytest.raises(UsageError) as caught:
        Expression.parse(" + ".join(["1"] * 500) + " + +")
    assert max(map(len, str(caught.value).splitlines())) < 150
    assert str(caught.value).splitlines()[1].endswith("1 + +")


@given(st.text(alphabet="{}()$+-*/%<>=! \n.,:@[]|&abAB019é\x00\ud800ormindt", max_size=60))
def test_any_text_is_an_expression_or_explained(text):
    try:
        found = Expression.parse(text)
    except UsageError:
        return
    assert np.isfinite(found.evaluate(np.ones((2, len(found.features))))).all()


@pytest.mark.parametrize(
    "text",
    [
        *("(" * 9_000 + "1" + ")" * 9_000, "-" * 19_000 + "1", "not " * 4_000 + "1", "1" + " + 1" * 1_900),
        "{A}" + "<1" * 999,
    ],
    ids=lambda text: text[:3],
)
def test_deep_nesting_neither_overflows_nor_hangs(text):
    assert np.isfinite(Expression.parse(text).evaluate(np.ones((1, 1 if "A" in text else 0)))).all()


def test_size_is_bounded():
    with pytest.raises(UsageError, match="20,003 characters: expected at most 20,000"):
        Expression.parse("1" * 20_003)
    with pytest.raises(UsageError, match=f"expected at most {MAX_FEATURES}"):
        Expression.parse(" + ".join(f"{{A{i}}}" for i in range(MAX_FEATURES + 1)))
    with pytest.raises(UsageError, match=f"more than {MAX_STEPS:,} steps"):
        Expression.parse(" + ".join(f"{{A}} * {i}" for i in range(MAX_STEPS // 3 + 1)), {})


def test_every_function_is_carried_out():
    assert FUNCTIONS.keys() <= OPERATIONS.keys()
    steps = Expression.parse("min({A}, 1) and choose({B}, 1, 0)").steps
    assert {step.operation for step in steps if isinstance(step, Apply)} == {"min", "and", "choose"}


def test_columns_must_be_those_of_the_features():
    with pytest.raises(UsageError, match="expected 1 columns"):
        Expression.parse("{A}").evaluate(np.zeros((3, 2)))
