"""A file with imports and the text without them that it is linked to say the same."""

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.errors import LanguageError
from grammarlab.language.checking.check import check
from grammarlab.language.formatting import format_grammar
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.language.linking import linked
from grammarlab.language.syntax.syntax_tree import Invoke, Name, walk

BRICK = (
    "attr height = 2\nattr x = 3\nk(height) = height + x\n@StartRule\nLot --> extrude(height) Done(x)\nDone(x) --> A"
)


def link(folder, **files):
    for name, text in files.items():
        (folder / f"{name}.cga").write_text(text)
    return linked(load(folder / "main.cga"))


def heights(text):
    """Of every leaf of the first model."""
    return derive(Grammar.parse(text), 1, seed=0).leaves.size[:, 1].tolist()


def definitions(text):
    """What a rule file says, in one canonical style and without comments."""
    return format_grammar(Grammar.parse(text).tree)


def test_a_file_without_imports_is_its_own_text(tmp_path):
    assert link(tmp_path, main="// lib\nLot --> A\n") == "// lib\nLot --> A\n"


def test_names_of_a_library_get_its_alias_and_parameters_and_keywords_do_not(tmp_path):
    library = (
        "attr x = 3\nconst top = 4\nf(x) = x + top\n@StartRule @Hidden Lot(y) --> set(x, f(y)) center(x) "
        "extrude(x, top) split(x) { x : A | { ~y : B(x) }* } comp(f) { top : C. | f(y) > x : NIL }\nB(x) --> D(x)"
    )
    text = link(tmp_path, main='import st : "lib.cga"\nLot --> st.Lot(st.x)', lib=library)
    assert definitions(text) == definitions(
        "Lot --> st.Lot(st.x)\nattr st.x = 3\nconst st.top = 4\nst.f(x) = x + st.top\n"
        "@Hidden st.Lot(y) --> set(st.x, st.f(y)) center(x) extrude(x, st.top) "
        "split(x) { st.x : st.A | { ~y : st.B(st.x) }* } comp(f) { top : st.C. | st.f(y) > st.x : NIL }\n"
        "st.B(x) --> st.D(x)"
    )


@pytest.mark.parametrize(
    ("main", "height"),
    [
        ('import b : "brick.cga"\nLot --> b.Lot', 2),
        ('import b : "brick.cga"\nattr height = 7\nLot --> b.Lot', 7),
        ('import b : "brick.cga"\nconst height = 7\nLot --> b.Lot', 2),
        ('import b : "brick.cga" (height)\nattr height = 7\nLot --> b.Lot', 2),
        ('import b : "brick.cga" ()\nattr height = 7\nLot --> b.Lot', 2),
        ('import b : "brick.cga" (height = 2 * y)\nattr height = 7\nattr y = 6\nLot --> b.Lot', 12),
        ('import b : "brick.cga"\nattr height = b.height + 1\nLot --> b.Lot', 2),
        ('import b : "brick.cga"\nattr x = 10\nLot --> extrude(b.k(1)) A', 11),
        ('import b : "brick.cga"\nLot --> set(b.height, 9) b.Lot', 9),
        ('import b : "brick.cga"\nLot --> b.Lot\nb.Lot --> extrude(21) A', 21),
    ],
)
def test_an_attribute_of_a_library_has_the_value_that_cga_gives_it(tmp_path, main, height):
    text = link(tmp_path, main=main, brick=BRICK)
    assert heights(text) == [height]
    assert not [finding for finding in check(Grammar.parse(text)) if finding.severity == "error"]


def test_values_reach_the_libraries_of_libraries(tmp_path):
    main = 'import a : "a.cga"\nattr height = 4\nLot --> a.Lot'
    assert heights(link(tmp_path, main=main, a='import b : "brick.cga"\nLot --> b.Lot', brick=BRICK)) == [4]


def test_a_rule_that_a_library_leaves_open_is_the_one_of_the_importing_file(tmp_path):
    text = link(
        tmp_path,
        main='import m : "mass.cga"\nimport f : "face.cga"\nLot --> m.Lot\nm.Facade --> f.Facade',
        mass="Lot --> extrude(3) comp(f) { side : Facade | all : NIL }",
        face="Facade --> split(y) { 1 : A | ~1 : B }",
    )
    forest = derive(Grammar.parse(text), 1, seed=0)
    assert sorted(forest.symbols[i] for i in forest.nodes.symbol[forest.leaves.node]) == ["f.A"] * 4 + ["f.B"] * 4


def test_extension_rules_of_an_import_stand_in_place_of_the_library_s(tmp_path):
    main = 'import m : "mass.cga" (Roof --> extrude(h) A)\nattr h = 5\nLot --> m.Lot'
    assert heights(link(tmp_path, main=main, mass="Lot --> Roof\nextension Roof --> extrude(1) B")) == [5]


def test_what_stands_in_the_importing_file_keeps_its_lines(tmp_path):
    main = '// one\nimport b : "brick.cga"\n@StartRule\nLot --> b.Lot\nstyle Old\nattr y = 1\n'
    lines = link(tmp_path, main=main, brick=BRICK).splitlines()
    assert [line.strip() for line in lines[:4]] == ["// one", "", "@StartRule", "Lot --> b.Lot"]
    assert lines[-2:] == ["style Old", "attr y = 1"]


def test_an_import_that_cannot_be_read_stays(tmp_path):
    text = link(
        tmp_path,
        main='import a : "a.cga"\nimport gone : "gone.cga"\nLot --> a.Lot gone.X',
        a='import lost : "lost.cga"\nLot --> extrude(lost.height) lost.Y',
    )
    assert {statement.alias for statement in Grammar.parse(text).imports.values()} == {"gone", "a.lost"}
    assert not check(Grammar.parse(text))


def test_values_handed_to_an_import_that_cannot_be_read_are_those_of_the_file_that_says_so(tmp_path):
    text = link(
        tmp_path,
        main='import a : "a.cga"\nLot --> a.Lot',
        a="attr size = 3\n"
        'import lost : "lost.cga" (height = size, Wall --> extrude(size) Brick)\n'
        "Brick --> B\nLot --> lost.Y",
    )
    (statement,) = Grammar.parse(text).imports.values()
    named = [node.identifier for node in walk(statement) if isinstance(node, Name)]
    made = [node.name for node in walk(statement) if isinstance(node, Invoke)]
    assert (named, made) == (["a.size", "a.size"], ["extrude", "a.Brick"])
    assert not check(Grammar.parse(text))


@pytest.mark.parametrize(
    ("path", "place"),
    [
        ("walls/brick.cga", "rules/walls"),
        ("brick.cga", "rules"),
        ("rules/walls/brick.cga", "rules/walls"),
        ("../walls/brick.cga", "rules/walls"),
        ("/Town/rules/walls/brick.cga", "rules/walls"),
        ("/Town/rules/brick.cga", "rules/lots"),
    ],
)
def test_an_import_is_looked_for_up_to_the_folder_of_rules(tmp_path, path, place):
    lots = tmp_path / "town" / "rules" / "lots"
    lots.mkdir(parents=True)
    there = tmp_path / "town" / place
    there.mkdir(parents=True, exist_ok=True)
    (there / "brick.cga").write_text(BRICK)
    (lots / "main.cga").write_text(f'import b : "{path}"\nLot --> b.Lot')
    assert heights(linked(load(lots / "main.cga"))) == [2.0]


def test_the_nearest_of_several_imports_of_one_name_is_taken_and_none_beyond_the_folder_of_rules(tmp_path):
    lots = tmp_path / "town" / "rules" / "lots"
    lots.mkdir(parents=True)
    (lots / "main.cga").write_text('import b : "brick.cga"\nLot --> b.Lot')
    (tmp_path / "town" / "brick.cga").write_text(BRICK)
    assert [f.code for f in load(lots / "main.cga").import_findings] == ["bad-import"]
    for folder, height in ((lots.parent, 5), (lots, 7)):
        (folder / "brick.cga").write_text(BRICK.replace("height = 2", f"height = {height}"))
        assert heights(linked(load(lots / "main.cga"))) == [height]
    (lots / "main.cga").write_text('import b : "../../brick.cga"\nLot --> b.Lot')
    assert "lies outside" in load(lots / "main.cga").import_findings[0].message


def test_more_copies_of_files_than_allowed_are_refused(tmp_path):
    files = {f"l{i}": f'import a : "l{i + 1}.cga"\nimport b : "l{i + 1}.cga"\nX --> a.X b.X' for i in range(12)}
    with pytest.raises(LanguageError, match="at most 200 copies"):
        link(tmp_path, main='import a : "l0.cga"\nLot --> a.X', l12="X --> NIL", **files)


COMPUTED = (
    "const c = 3\nattr a = 2\nf = a + 1\nattr d = c * f\nattr e = d + 1\nattr z = 5\n"
    "Lot --> Part(a) Part(c) Part(d) Part(e) Part(z)\nPart(h) --> s(1, h, 1) A."
)


@pytest.mark.parametrize("values", ["", "a = 5", "c = 7, z = 1", "c = 7, a = 5", "d = 4", "e = 1", "f = 2, a = 8"])
def test_a_call_that_redefines_attributes_is_as_an_import_with_these_values(tmp_path, values):
    calls = f"Lot --> set(b.z, 9) set(b.d, 8) b({values}).Lot"
    called = link(tmp_path, main=f'import b : "lib.cga"\n{calls}', lib=COMPUTED)
    # a constant cannot be redefined by an import, so the other file says its value itself
    constant = COMPUTED.replace("const c = 3", f"const c = {7 if 'c =' in values else 3}")
    imported = link(tmp_path, main=f'import b : "lib.cga" ({values})\nLot --> b.Lot', lib=constant)
    assert heights(called) == heights(imported)


def test_random_parts_of_attributes_that_a_call_evaluates_again_are_those_of_the_model(tmp_path):
    library = "attr a = 2\nattr d = a + rand(0, 1)\nLot --> s(1, d, 1) A."
    text = link(tmp_path, main='import b : "lib.cga"\nLot --> b.Lot b(a = 5).Lot b(a = 2).Lot', lib=library)
    first, second, third = heights(text)
    assert first == third == pytest.approx(second - 3)
    assert len(derive(Grammar.parse(text), 1, seed=0).draws.value) == 1


def test_a_call_records_the_draws_of_a_branch_that_was_not_taken_before_and_each_once(tmp_path):
    library = "attr a = 2\nattr w = case a > 3 : rand(0, 10) else : 1\nW --> s(1, w, 1) WW."
    main = 'import b : "lib.cga"\nLot --> b.W [ b(a = 5).W ] b(a = 6).W'
    forest = derive(Grammar.parse(link(tmp_path, main=main, lib=library)), 3, seed=0)
    plain, *drawn = forest.leaves.size[:, 1].reshape(3, 3)
    assert plain.tolist() == [1.0] * 3
    assert all(np.array_equal(heights, forest.draws.value) for heights in drawn)
    assert forest.draws.node.tolist() == [0, 1, 2]
    assert np.allclose(forest.draws.log_density, -np.log(10.0))


def test_what_a_call_redefines_that_is_no_attribute_changes_nothing(tmp_path):
    library = "attr a = 2\np = a\nSub(h) --> s(1, h + a, 1) S.\nGen --> s(1, p, 1) G."
    main = 'import b : "lib.cga"\nLot --> b(a = 9).Sub(2) b(Gen = 2).Gen b(p = 1, a = 4).Gen'
    assert sorted(heights(link(tmp_path, main=main, lib=library))) == [2, 4, 11]
