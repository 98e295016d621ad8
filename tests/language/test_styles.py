"""Styles of rule files: what they override, where, and in imported files."""

from __future__ import annotations

import pytest

from grammarlab.derivation import derive
from grammarlab.errors import LanguageError
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.language.linking import linked
from grammarlab.language.styles import style_names, styled

TEXT = """@Range(1, 9) attr h = rand(3)
attr colour = "red"
@StartRule
Lot --> extrude(h) Body(2)
Body(n) --> A

style Tall
attr h = rand(90)
B --> Z

style Blue extends Tall
attr colour = "blue"
Body(n) --> B
"""


def test_a_style_replaces_definitions_where_they_stand_and_adds_others():
    grammar = Grammar.parse(TEXT)
    assert style_names(grammar) == ("Default", "Tall", "Blue")
    assert styled(grammar, "Blue").text.split("\n") == [
        "@Range(1, 9) attr h = rand(90)",
        'attr colour = "blue"',
        "@StartRule",
        "Lot --> extrude(h) Body(2)",
        "Body(n) --> B",
        "",
        "B --> Z",
        "",
    ]
    assert styled(grammar, "Default").text == TEXT[: TEXT.index("\nstyle Tall")]


def test_equal_draws_of_a_style_stay_equal():
    grammar = Grammar.parse(TEXT)
    plain, tall = (derive(styled(grammar, name), 5, 1).leaves.size[:, 1] for name in ("Default", "Tall"))
    assert tall.tolist() == pytest.approx((30.0 * plain).tolist())


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        (TEXT, "Blu", "unknown style 'Blu'"),
        ("Lot --> A  style X extends X  B --> C", "X", "extends itself"),
        ("Lot --> A  style X extends Y  style Y extends X", "X", "extends itself"),
    ],
)
def test_unknown_and_endless_styles_are_refused(text, name, message):
    with pytest.raises(LanguageError, match=message):
        styled(Grammar.parse(text), name)


def test_an_import_takes_a_style_of_the_file(tmp_path):
    (tmp_path / "part.cga").write_text("Wall --> A.  style Brick  Wall --> B.")
    (tmp_path / "main.cga").write_text(
        'import one : "part.cga"  import two(Brick) : "part.cga"  Lot --> one.Wall two.Wall'
    )
    forest = derive(Grammar.parse(linked(load(tmp_path / "main.cga"))), 1, 1)
    assert {forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]} == {"one.A.", "two.B."}


def project(folder, files):
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def test_imports_come_from_a_library_and_from_the_project_around_the_rules(tmp_path):
    project(
        tmp_path,
        {
            "City/rules/main.cga": """import a : "/ESRI.lib/rules/Roofs/roof.cga"  import b : "/City/shared/wall.cga"
                                      Lot --> a.Roof b.Wall""",
            "City/shared/wall.cga": "Wall --> W.",
            "City/assets/brick.txt": "",
            "libraries/ESRI.lib/rules/Roofs/roof.cga": 'import t : "../tiles.cga"  Roof --> t.Tile',
            "libraries/ESRI.lib/rules/tiles.cga": "Tile --> T.",
        },
    )
    path = tmp_path / "City/rules/main.cga"
    grammar = load(path, library=tmp_path / "libraries")
    assert grammar.import_findings == ()
    assert "a.t.Tile --> a.t.T." in linked(grammar)
    assert [finding.location.line for finding in load(path).import_findings] == [1]


@pytest.mark.parametrize("written", ["../../secret.cga", "/../secret.cga", "/City/notes.txt", "a\x00b"])
def test_imports_do_not_leave_their_roots(tmp_path, written):
    project(tmp_path, {"secret.cga": "A --> B", "City/notes.txt": "A --> B", "City/rules/x.cga": "Lot --> A"})
    path = tmp_path / "City/rules/main.cga"
    path.write_text(f'import a : "{written}"  Lot --> a.A')
    (finding,) = load(path, library=tmp_path / "City").import_findings
    assert finding.code == "bad-import"


def test_a_call_of_an_imported_rule_gives_its_attributes_values(tmp_path):
    (tmp_path / "part.cga").write_text('attr h = 2\nWall --> extrude(h) Inner\nInner --> report("h", h) X')
    rules = 'import p : "part.cga"\nLot --> split(x) { ~5 : A(split.index + 3) }*\nA(n) --> p(h = n).Wall p.Wall'
    (tmp_path / "main.cga").write_text(rules)
    forest = derive(Grammar.parse(linked(load(tmp_path / "main.cga"))), 1, 1, footprint=(10.0, 5.0))
    assert sorted(forest.reports.value.tolist()) == [2.0, 2.0, 3.0, 4.0]
    assert sorted(forest.leaves.size[:, 1].tolist()) == [2.0, 2.0, 3.0, 4.0]
