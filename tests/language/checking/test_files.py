"""Checking a rule file on disk follows its imports."""

from __future__ import annotations

import os
import re

import pytest

from grammarlab.errors import LanguageError
from grammarlab.language.checking.check import check, check_files
from grammarlab.language.grammar import Grammar, read_text
from grammarlab.language.importing import load
from grammarlab.language.linking import linked


def write(folder, **files):
    for name, text in files.items():
        (folder / f"{name}.cga").write_text(text)
    return folder / "main.cga"


def codes(path, **options):
    return {one.file: [finding.code for finding in one.findings] for one in check_files(path, path.name, **options)}


def test_findings_of_imported_files_stand_in_those_files(tmp_path):
    main = write(
        tmp_path,
        main='import walls : "walls.cga"\nLot --> walls.Wall(3) walls.Wal(1) extrude(foo)',
        walls='import parts : "parts.cga"\nWall(h) --> extrude(hh) parts.Brick',
        parts="Brick --> extrude(1) extrude(1, 2, 3)",
    )
    found = codes(main)
    assert found == {
        "main.cga": ["unknown-name", "unknown-name"],
        "walls.cga": ["unknown-name"],
        "parts.cga": ["wrong-arity"],
    }
    first = check_files(main, "main.cga")[1]
    assert "  Wall(h) --> extrude(hh) parts.Brick\n                      ^^" in first.findings[0].render(
        first.text.splitlines()
    )


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("hieght", "did you mean 'height'?"),
        ("Gen", "a call of an imported rule redefines attributes only"),
        ("p", "a call of an imported rule redefines attributes only"),
    ],
)
def test_a_call_may_redefine_only_attributes_of_the_imported_file(tmp_path, name, hint):
    library = "attr height = 2\nconst c = 1\np = height\nGen --> extrude(p + c) A."
    main = write(tmp_path, main=f'import b : "lib.cga"\nLot --> b(height = 1, c = 2, {name} = 3).Gen', lib=library)
    for findings in (check_files(main, "main.cga")[0].findings, check(Grammar.parse(linked(load(main))))):
        assert [(one.code, one.severity, one.hint) for one in findings] == [("unknown-name", "error", hint)]
        assert findings[0].message == f"the import b has no attribute {name}"


def test_syntax_errors_of_an_imported_file_hide_nothing_in_the_others(tmp_path):
    main = write(
        tmp_path,
        main='import walls : "walls.cga"\nLot --> walls.Unseen extrude(foo)',
        walls="Wall --> split(x) { ~1 Brick }\nDoor --> extrude(bar)",
    )
    assert codes(main) == {"main.cga": ["unknown-name"], "walls.cga": ["part-without-colon", "unknown-name"]}


def test_a_file_that_two_others_import_is_checked_once(tmp_path):
    main = write(
        tmp_path,
        main='import a : "a.cga"\nimport b : "b.cga"\nLot --> a.A b.B',
        a='import c : "c.cga"\nA --> c.C',
        b='import c : "c.cga"\nB --> c.C',
        c="C --> extrude(foo)",
    )
    assert list(codes(main)) == ["main.cga", "a.cga", "c.cga", "b.cga"]


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("gone.cga", "cannot read the rule file"),
        ("../other.cga", "lies outside the folder"),
        ("main.cga", "imports the file that imports it"),
        ("x" * 5000, "'x+' is not a valid path|cannot use"),
    ],
)
def test_imports_that_cannot_be_followed_are_reported_at_their_place(tmp_path, target, message):
    main = write(tmp_path, main=f'import lib : "{target}"\nLot --> lib.A lib.b(3)')
    (one,) = check_files(main, "main.cga")
    (finding,) = one.findings
    assert (finding.code, finding.location.line) == ("bad-import", 1)
    assert re.search(message, finding.message)
    assert ("`library=DIR`" in finding.hint) == ("cannot read" in finding.message)


def test_a_file_beside_stands_in_for_one_in_folders_that_are_lost_but_not_for_itself(tmp_path):
    main = write(
        tmp_path,
        main='import a : "Project/Support/a.cga"\nimport b : "Project/main.cga"\nLot --> extrude(a.h) b.X',
        a="attr h = 3",
    )
    first = check_files(main, "main.cga")[0]
    assert [(finding.code, finding.location.line) for finding in first.findings] == [("bad-import", 2)]


def test_a_file_of_a_folder_above_does_not_stand_in_for_one_that_imports_itself(tmp_path):
    write(tmp_path, a="attr h = 3")
    (tmp_path / "inside").mkdir()
    main = write(
        tmp_path / "inside",
        main='import a : "a.cga"\nLot --> extrude(a.h) X',
        a='import b : "b.cga"',
        b='import a : "a.cga"',
    )
    findings = check_files(main, "main.cga", root=tmp_path)[-1].findings
    assert [finding.code for finding in findings] == ["bad-import"]


def test_a_file_that_is_not_there_is_an_error(tmp_path):
    with pytest.raises(LanguageError, match="cannot read the rule file"):
        check_files(tmp_path / "gone.cga", "gone.cga")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_an_import_that_is_a_pipe_is_refused_without_waiting_for_it(tmp_path):
    main = write(tmp_path, main='import a : "a.cga"\nLot --> X')
    os.mkfifo(tmp_path / "a.cga")
    (checked,) = check_files(main, "main.cga")
    assert [finding.code for finding in checked.findings] == ["bad-import"]
    assert "expected a regular file, found a pipe" in checked.findings[0].message
    with pytest.raises(LanguageError, match="expected a regular file, found a pipe"):
        read_text(tmp_path / "a.cga")
    assert "a pipe" in load(main).import_findings[0].message


def test_a_link_to_itself_is_an_error(tmp_path):
    (tmp_path / "loop.cga").symlink_to("loop.cga")
    with pytest.raises(LanguageError, match="cannot read the rule file"):
        check_files(tmp_path / "loop.cga", "loop.cga")


def test_names_lead_through_the_imports_of_imports(tmp_path):
    names = "{p}Generate {p}G({p}X + {p}f(2)) set({p}X, 9)"
    main = write(
        tmp_path,
        main=f'import d : "distributor.cga"\nLot --> {names.format(p="d.Plant.")} d.Plant.Genrate d.Plant.G(d.Plant.Y)',
        distributor=f'import Plant : "plant.cga"\nDo --> {names.format(p="Plant.")}',
        plant="attr X = 3\nf(a) = a * 2\nGenerate --> extrude(X)\nG(n) --> extrude(n)",
    )
    assert codes(main) == {"main.cga": ["unknown-name"] * 2, "distributor.cga": [], "plant.cga": []}
    assert check(load(main)) == check_files(main, str(main))[0].findings
    first, second = check_files(main, "main.cga")[0].findings
    assert (first.message, first.hint) == ("the import d.Plant has no rule Genrate", "did you mean 'd.Plant.Generate'?")
    assert second.message == "unknown name 'd.Plant.Y'"
