"""Findings of the checker: what is wrong is found and named, what is right is left alone."""

from pathlib import Path

import pytest

from grammarlab.language.checking.check import SupportedFeatures, check, check_text
from grammarlab.language.grammar import Grammar

GRAMMARS = sorted((Path(__file__).parents[3] / "grammars").glob("*.cga"))


def findings(text, supported=None):
    return check_text(text, supported=supported or SupportedFeatures())


def codes(text):
    return [(finding.severity, finding.code) for finding in findings(text)]


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [
        # names
        ("Lot --> extrude(hight) A", "unknown-name", "hight"),
        ("Lot --> extrude(flor(1)) A", "unknown-function", "flor(1)"),
        ("Lot --> set(foo, 1) A", "unknown-name", "foo"),
        ("Lot --> comp(f) { tpo : A }", "unknown-selector", "tpo"),
        ("Lot --> split(w) { 1 : A }", "unknown-keyword", "w"),
        ("Lot --> offset(-1, insde) A", "unknown-keyword", "insde"),
        ("Lot --> inline(merge) A", "unknown-keyword", "inline"),
        ("Lot --> roof(1) { all : A }", "unknown-operation", "roof(1)"),
        ("style Red extends Blue\nLot --> A", "unknown-name", "Red"),
        # numbers of arguments
        ("Lot --> t(0, 1) A", "wrong-arity", "t(0, 1)"),
        ("Lot --> color(1, 2) A", "wrong-arity", "color(1, 2)"),
        ("Lot --> extrude(f(1)) A\nf(a, b) = a + b", "wrong-arity", "f(1)"),
        ("Lot --> extrude(rand(1, 2, 3)) A", "wrong-arity", "rand(1, 2, 3)"),
        ("Lot --> comp(f)", "missing-block", "comp(f)"),
        ("Lot --> A i\ni --> B", "shadowed-rule", "i"),
        ('Lot --> i(1, "yUp", 2, 3, 4)\ni(a, b, c, d, e) --> B', "shadowed-rule", "i(1"),
        ("Lot --> extrude(3) { all : A }", "unknown-operation", "extrude(3)"),
        # types
        ('Lot --> extrude("a") A', "wrong-type", '"a"'),
        ("Lot --> texture(1) A", "wrong-type", "1"),
        ("Lot --> report(1, 2)", "wrong-type", "1"),
        ("Lot --> case 3 : A else : B", "wrong-type", "3"),
        ('Lot --> "a"% : A else : B', "wrong-type", '"a"'),
        ('attr a = "x" * 2\nLot --> A', "wrong-type", '"x"'),
        ("attr a = 1 + true\nLot --> A", "wrong-type", "1 + true"),
        ("attr a = !1\nLot --> A", "wrong-type", "1"),
        ('attr a = 1 == "1"\nLot --> A', "wrong-type", '1 == "1"'),
        ("attr a = true < false\nLot --> A", "wrong-type", "true < false"),
        ("attr a = 1 && true\nLot --> A", "wrong-type", "1"),
        ('attr a = "s"\nattr b = a - 1\nLot --> A', "wrong-type", "a"),
        ("f(x) = str(x)\nattr b = sqrt(f(1))\nLot --> A", "wrong-type", "f(1)"),
        ("const a = [1, 2]\nLot --> extrude(a) A", "wrong-type", "a"),
        ("attr a = 3[0]\nLot --> A", "wrong-type", "3"),
        ('attr a = [1, "a"]\nLot --> A', "mixed-types", '"a"'),
        ('attr a = case p(0.5) : 1 else : "b"\nLot --> A', "mixed-types", '"b"'),
        ('Lot --> split(x) { "a" : A }', "wrong-type", '"a"'),
        ("attr a = '3\nLot --> A", "misplaced-size", "'3"),
        ("Lot --> s(~1, 1, 1) A", "misplaced-size", "~1"),
        ("Lot --> set(split.index, 1) A", "read-only", "split.index"),
        # shape of definitions
        ("Lot --> A\nLot --> B", "duplicate-definition", "Lot"),
        ("attr a = 1\nconst a = 2\nLot --> A", "duplicate-definition", "a"),
        ("attr a = 1\na = 2\nLot --> A", "duplicate-definition", "a"),
        ("f(x) = 1\nf(y) = 2\nLot --> A", "duplicate-definition", "f"),
        ("f(x, x) = 1\nLot --> A", "duplicate-parameter", "f"),
        ("f(x) = case x > 1 : 1\nLot --> A", "case-without-else", "case"),
        ("Lot --> comp(f) { { 1 : A } }", "misplaced-group", "1 : A"),
        ("Lot --> comp(f) { all : A }*", "misplaced-star", "all"),
        ("Lot --> split(x) { 1 = A }", "wrong-separator", "1 = A"),
        # chance
        ("Lot --> 30% : A 60% : B", "percentages", "30"),
        ("Lot --> 60% : A 60% : B else : C", "percentages", "60"),
        ("Lot --> 1e308% : A 1e308% : B else : C", "percentages", "1e308"),
        ("Lot --> 1e308% : A 1e308% : B", "percentages", "1e308"),
        ("Lot --> 0% : A 0% : B", "percentages", "0"),
        ("attr a = 50% : 1 20% : 2\nLot --> A", "percentages", "50"),
        ("Lot --> 130% : A (-30)% : B", "bad-percentage", "-30"),
        # what never ends
        ("Lot --> A\nA --> B\nB --> A", "endless-rule", "Lot"),
        ("Lot --> 50% : Lot else : [ Lot ] A", "endless-rule", "Lot"),
        ("Lot --> case p(0.5) : Lot else : Lot", "endless-rule", "Lot"),
        ("f(x) = f(x - 1)\nLot --> A", "endless-value", "f"),
        ("attr a = b\nattr b = a\nLot --> A", "endless-value", "a"),
        ("f(x) = case f(x) > 1 : 1 else : 2\nLot --> A", "endless-value", "f"),
    ],
)
def test_errors_are_found_where_they_are(text, code, place):
    found = [finding for finding in findings(text) if finding.severity == "error"]
    assert code in {finding.code for finding in found}, found
    location = next(finding.location for finding in found if finding.code == code)
    line = text.splitlines()[location.line - 1]
    assert line[location.column - 1 :].startswith(place.split("\n")[0])


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("Lot --> NIL\nA --> NIL", "unreachable-rule"),
        ("Lot --> NIL\nA --> B\nB --> 50% : A else : C", "unreachable-rule"),
        ("Lot --> 33.3% : A 33.3% : B 33.3% : C", "percentages"),
        ("Lot --> 50% : A 50% : B else : C", "empty-else"),
        ("Lot --> case p(0.5) : A", "case-without-else"),
        ("Lot --> split(x) { 0 : A | 1 : B }", "empty-part"),
        ("Lot --> split(x) { ~(1 - 2) : A }", "empty-part"),
        ("Lot --> split(x) { 0 / 0 : A }", "empty-part"),
        ("@Rnage(1, 2) attr a = 1\nLot --> A", "unknown-annotation"),
        ("@Order attr a = 1\nLot --> A", "bad-annotation"),
        ("@Range(2, 1) attr a = 1\nLot --> A", "bad-annotation"),
        ("@Range(mn=2, max=1) attr a = 1\nLot --> A", "bad-annotation"),
        ("@StartRule attr a = 1\nLot --> A", "bad-annotation"),
        ("@Color Lot --> A", "bad-annotation"),
        ("attr a = 1", "no-rule"),
        ("Lot(n) --> A", "start-parameters"),
        ("Lot --> Extrud(1)", "unknown-symbol"),
        ("Lot --> wall\nWall --> NIL", "unknown-symbol"),
        ("Lot --> trim\ntrim --> NIL", "shadowed-rule"),
    ],
)
def test_doubtful_places_are_warned_of(text, code):
    found = findings(text)
    assert code in {finding.code for finding in found if finding.severity == "warning"}, found
    assert not [finding for finding in found if finding.severity == "error"]


@pytest.mark.parametrize(
    "text",
    [
        "Lot --> A Wall Roof.",
        "Lot --> extrude(world.up, 10) comp(f) { top : A | side = B | 0 : C | scope.sx > 1 : D }",
        "Lot --> extrude(h) A\nattr h = case p(0.5) : rand(1, 2) else : 3",
        "Lot --> t('0.5, -1, 0) s('1, '1 + 0.3, 0) r(scopeCenter, 0, 90, 0) center(xz) A",
        "Lot --> split(x) { ~1 : A | '0.5 : B | { ~w * 2 : C | w : D }* }\nconst w = 2",
        "Lot --> A(1) A(1, 2)\nA(x) --> extrude(x) B\nA(x, y) --> extrude(x + y) B",
        "Lot --> 100 / 3% : A 100 / 3% : B 100 / 3% : C",
        "Lot --> s% : A else : B\nattr s = 30",
        "Lot(n) --> case n > 0 : Lot(n - 1) else : NIL\n@StartRule Go --> Lot(3)",
        "Lot --> split(y) { 1 : A | ~1 : Lot }",
        "Lot --> 99% : Lot else : A",
        "f(x) = case x > 1 : f(x - 1) else : 0\nLot --> extrude(f(3)) A",
        "f(x) = x > 1 && f(x - 1)\nLot --> case f(3) : A else : B",
        'Lot --> report("a" + 1, geometry.area) print(1 + "a" + true) texture(str(1) + ".jpg") A',
        "Lot --> set(h, 3) set(material.opacity, 0.5) set(trim.vertical, false) A\nattr h = 1",
        "const a = [1, 2; 3, 4]\nLot --> extrude(a[1, 0] + size(a[0])) A",
        "attr big = max(1, 2) > rint(2.5) || isnan(3)\nLot --> case big : A else : B",
        "extension Roof --> roofHip(30, 0.5, true)\n@StartRule Lot --> A",
        'import lib : "lib.cga"\nLot --> lib.Wall(1) extrude(lib.height)',
        "Lot --> extrude(h) A\nattr h = 0\nstyle Red\nattr h = 1\nstyle Blue extends Red\nLot --> B",
        "Lot --> alignScopeToGeometry(yUp, any, longest) setback(1) { front : A | remainder = B }",
        'Lot --> i("a.obj", zUp, keepSizeAndPosition) setupProjection(0, scope.xy, ~2, \'1, 0, 0) A',
        "d(x) with (y := x * 2) = y\nLot with (h := d(1)) --> extrude(h) A",
        "Lot --> scatter(surface, 10, gaussian, center, '0.2) { A } union { A B } subtract(swap) A inline(unify) A",
    ],
)
def test_what_is_right_is_left_alone(text):
    assert findings(text) == ()


@pytest.mark.parametrize(
    ("name", "meant"), [("extude(1)", "extrude"), ("comp(f) { tpo : A }", "top"), ("offset(1, insde)", "inside")]
)
def test_the_nearest_name_is_suggested(name, meant):
    (finding,) = findings(f"Lot --> {name}")
    assert finding.hint == f"did you mean '{meant}'?"


def test_a_rule_with_the_name_of_an_operation_is_to_be_renamed_where_only_the_rule_fits():
    meant, warned = findings("Lot --> i\ni --> A")
    assert (meant.severity, meant.hint[:38]) == ("error", "give the rule another name, such as I,")
    assert (warned.severity, warned.code) == ("warning", "shadowed-rule")
    # Neither fits, so the forms of the operation are named.
    assert ("error", "wrong-arity") in codes("Lot --> s(1)\ns --> A")


def test_a_parameter_hides_nothing_outside_its_definition():
    assert [finding.code for finding in findings("f(x) = x\nLot --> extrude(x) A")] == ["unknown-name"]


def test_names_in_broken_definitions_are_not_reported_again():
    text = "attr h == 3\nWall(n) --> split(x) { 1 A }\nLot --> extrude(h) Wall(2)"
    assert [finding.code for finding in findings(text)] == ["double-equals", "part-without-colon"]


def test_findings_stand_in_the_order_of_the_text_and_come_once():
    text = "Lot --> extrude(b) extrude(a) A\nattr h = b\nattr k = h + h + a"
    found = findings(text)
    places = [(finding.location.line, finding.location.column) for finding in found]
    assert places == sorted(places)
    assert len(set(found)) == len(found)
    assert found == findings(text)


NOTHING = SupportedFeatures(*[frozenset()] * 5)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("Lot --> taper(3) A", "taper"),
        ("Lot --> splitArea(x) { 1 : A }", "splitArea"),
        ("Lot --> scatter(surface, 1, uniform) { A }", "scatter"),
        ("Lot --> inline A", "inline"),
        ("Lot --> union { A B }", "union"),
        ('attr a = fileRandom("*")\nLot --> A', "fileRandom"),
        ("attr a = scope.sx\nLot --> A", "scope.sx"),
        ("const a = [1]\nLot --> A", "array"),
        ("attr a = sqrt(2) .+ 1\nLot --> A", ".+"),
        ('import a : "b.cga"\nLot --> A', "import"),
        ('import a : "b.cga"\nLot --> a(B --> C).A', "redefining"),
        ("f with (x := 1) = x\nLot --> A", "variable"),
        ("attr a = comp(f) { all : 1 }\nLot --> A", "comp as a function"),
        ("Lot --> comp(f) { all =: A }", "=:"),
        ("Lot --> comp(f) { hip : A }", "comp with hip"),
    ],
)
def test_what_cannot_be_carried_out_is_named(text, named):
    found = [finding for finding in findings(text, NOTHING) if finding.severity == "unsupported"]
    assert any(named in finding.message for finding in found)
    assert not [finding for finding in findings(text) if finding.severity == "unsupported"]


def test_features_are_supported_by_name():
    only = SupportedFeatures(operations=frozenset({"extrude", "split"}), keywords=frozenset({"split:x"}))
    found = findings("Lot --> extrude(1) taper(2) split(x) { 1 : A } split(y) { 1 : A }", only)
    assert [finding.message.split(" is CGA")[0] for finding in found] == ["the operation taper", "split with y"]


@pytest.mark.parametrize("path", GRAMMARS, ids=lambda path: path.stem)
def test_shipped_grammars_have_no_errors(path):
    found = check(Grammar.parse(path.read_text(encoding="utf-8")))
    assert [finding for finding in found if finding.severity == "error"] == []


def test_rules_in_a_redefinition_are_reached():
    text = (
        'import temple : "temple.cga" (Roof --> MyRoof)\n@StartRule\nLot --> temple.start\nMyRoof --> roofGable(22) A.'
    )
    assert "unreachable-rule" not in {finding.code for finding in check_text(text)}
