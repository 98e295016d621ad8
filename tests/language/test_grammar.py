"""Grammars as values, and as files."""

import hashlib
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import LanguageError
from grammarlab.language.checking.check import check
from grammarlab.language.grammar import Grammar, read_text
from grammarlab.language.importing import load

TEXT = """
attr h = 1
const c = 2
f = 3
f(x) = x
Lot --> A
@StartRule
Town --> Lot
A(n) --> NIL
A --> A(1)
style Red
Lot --> B
"""


def test_definitions_are_found_by_name_and_number_of_parameters():
    grammar = Grammar.parse(TEXT)
    assert set(grammar.rules) == {("Lot", 0), ("Town", 0), ("A", 1), ("A", 0)}
    assert set(grammar.functions) == {("f", 0), ("f", 1)}
    assert set(grammar.attributes) == {"h", "c"}


def test_the_start_rule_is_the_marked_one_else_the_first():
    marked, plain = Grammar.parse(TEXT).start_rule, Grammar.parse("A --> B\nB --> C").start_rule
    assert marked is not None
    assert plain is not None
    assert (marked.name, plain.name) == ("Town", "A")
    assert Grammar.parse("attr a = 1").start_rule is None


@given(st.sampled_from(["A --> B", "A --> B ", "A --> C"]), st.sampled_from(["A --> B", "A --> B "]))
def test_grammars_are_equal_exactly_when_their_texts_are(first, second):
    a, b = Grammar.parse(first, "a.cga"), Grammar.parse(second, "b.cga")
    assert (a == b) == (first == second)
    assert (a.hash == b.hash) == (first == second)
    assert a.hash == hashlib.sha256(first.encode()).hexdigest()


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
def test_files_in_usual_encodings_are_read(tmp_path, encoding):
    path = tmp_path / "town.cga"
    path.write_bytes('A --> report("Gebäude", 1)\r\n'.encode(encoding))
    assert "Gebäude" in load(path).text


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(LanguageError, match="no-such"):
        load(tmp_path / "no-such.cga")


def test_a_file_too_large_is_not_read(tmp_path):
    path = tmp_path / "large.cga"
    path.write_bytes(b"A" * (5 * 2**20))
    with pytest.raises(LanguageError, match="at most"):
        load(path)


def test_imported_names_are_known_and_others_are_not(tmp_path):
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "wall.cga").write_text('import more : "more.cga"\nattr h = 1\nWall(n) --> more.X\ng(x) = x')
    (tmp_path / "lib" / "more.cga").write_text("X --> NIL")
    main = tmp_path / "main.cga"
    main.write_text('import w : "lib/wall.cga"\nLot --> extrude(w.h + w.g(1)) w.Wall(2)')
    assert check(load(main)) == ()
    main.write_text('import w : "lib/wall.cga"\nLot --> extrude(w.k + w.k(1)) w.Wall w.Door')
    codes = [finding.code for finding in check(load(main))]
    assert codes == ["unknown-name", "unknown-function", "wrong-arity", "unknown-name"]


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("gone.cga", "cannot read"),
        ("../outside.cga", "outside"),
        ("/../outside.cga", "outside"),
        ("broken.cga", "cannot use"),
        ("main.cga", "imports the file that imports it"),
        ("x" * 5000, "not a valid path"),
        ("a\0b", "not a valid path"),
    ],
)
def test_imports_that_cannot_be_followed_are_findings(tmp_path, path, reason):
    (tmp_path / "outside.cga").write_text("X --> NIL")
    folder = tmp_path / "rules"
    folder.mkdir()
    (folder / "broken.cga").write_text("X --> ((")
    main = folder / "main.cga"
    main.write_text(f'import lib : "{path}"\nLot --> lib.X')
    (finding,) = check(load(main))
    assert finding.code == "bad-import"
    assert reason in finding.message or "cannot use" in finding.message


def test_a_link_out_of_the_folder_is_not_followed(tmp_path):
    (tmp_path / "outside.cga").write_text("X --> NIL")
    folder = tmp_path / "rules"
    folder.mkdir()
    (folder / "link.cga").symlink_to(tmp_path / "outside.cga")
    (folder / "main.cga").write_text('import lib : "link.cga"\nLot --> lib.X')
    (finding,) = check(load(folder / "main.cga"))
    assert "outside" in finding.message


def test_a_diamond_of_imports_reads_each_file_once(tmp_path):
    for level in range(30):
        lower = f"level{level + 1}.cga"
        (tmp_path / f"level{level}.cga").write_text(f'import a : "{lower}"\nimport b : "{lower}"\nX --> a.X b.X')
    (tmp_path / "level30.cga").write_text("X --> NIL")
    library = load(tmp_path / "level0.cga").libraries
    assert library["a"] is library["b"]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_files_are_read_in_the_encodings_that_editors_write(tmp_path, encoding):
    file = tmp_path / "rules.cga"
    file.write_bytes("// Höhe\nLot --> extrude(3) Dach".encode(encoding))
    assert load(file) == Grammar.parse("// Höhe\nLot --> extrude(3) Dach")


def test_half_a_character_of_two_bytes_is_no_crash(tmp_path):
    file = tmp_path / "rules.cga"
    file.write_bytes("Lot --> A".encode("utf-16")[:-1])
    with pytest.raises(LanguageError):
        load(file)


NOISE = Random(1).randbytes(3000)
BINARY = {
    "zeros": b"\0\x10" * 500,
    "utf-16 without a byte order mark": "Lot --> A".encode("utf-16-le"),
    "utf-32": "Lot --> A".encode("utf-32"),
    "begins as utf-16": b"\xff\xfe" + NOISE,
    "begins as utf-16, other byte order": b"\xfe\xff" + NOISE,
    "utf-16 with zeros": "Lot --> A\0\0".encode("utf-16"),
    "without zeros": NOISE.replace(b"\0", b""),
}


@pytest.mark.parametrize("form", BINARY)
def test_a_binary_file_is_one_finding(tmp_path, form):
    file = tmp_path / "picture.cga"
    file.write_bytes(BINARY[form])
    with pytest.raises(LanguageError, match="rules are text") as error:
        load(file)
    assert len(error.value.findings) == 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "mac_roman"])
def test_control_characters_that_programs_write_into_texts_are_no_sign_of_a_binary_file(tmp_path, encoding):
    file = tmp_path / "rules.cga"
    comment = "// \x1b[1mÅngström\x1b[0m \a\b\f\v Äpfel\n"
    file.write_bytes(f"{comment}Lot --> A\n\x1a".encode(encoding))
    with pytest.raises(LanguageError, match="U\\+001A") as error:
        load(file)
    assert error.value.findings[0].location.line == 3


def test_a_path_from_the_top_of_a_workspace_is_found_below_the_rule_file(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "wall.cga").write_text("A --> B")
    main = tmp_path / "main.cga"
    main.write_text('import w : "/City/rules/parts/wall.cga"\nimport x : "/City/rules/other.cga"\nLot --> w.A x.B')
    grammar = load(main)
    assert grammar.libraries["w"] is not None
    assert grammar.libraries["x"] is None
    assert [finding.code for finding in grammar.import_findings] == ["bad-import"]


ENDS = "// Häuser\nLot --> 40% : A\n    else : B(\nA --> NIL\n"
FORMS = {
    "unix": ENDS.encode(),
    "windows": ENDS.replace("\n", "\r\n").encode(),
    "old mac": ENDS.replace("\n", "\r").encode(),
    "byte order mark": ENDS.encode("utf-8-sig"),
    "utf-16": ENDS.replace("\n", "\r\n").encode("utf-16"),
    "windows-1252": ENDS.replace("\n", "\r\n").encode("cp1252"),
}


@pytest.mark.parametrize("form", FORMS)
def test_the_hash_of_a_file_depends_on_its_text_only(tmp_path, form):
    whole = {name: content.replace(b"B(", b"B ").replace(b"B\0(\0", b"B\0 \0") for name, content in FORMS.items()}
    (tmp_path / "a.cga").write_bytes(whole["unix"])
    (tmp_path / "b.cga").write_bytes(whole[form])
    first, second = load(tmp_path / "a.cga"), load(tmp_path / "b.cga")
    assert first == second
    assert first.hash == second.hash == Grammar.parse(whole["unix"].decode()).hash
    assert Grammar.parse(read_text(tmp_path / "b.cga").replace("\n", "\r\n")).hash == first.hash


@pytest.mark.parametrize("form", FORMS)
def test_errors_have_the_same_place_with_any_line_ends(tmp_path, form):
    (tmp_path / "a.cga").write_bytes(FORMS[form])
    with pytest.raises(LanguageError) as caught:
        load(tmp_path / "a.cga")
    location = caught.value.findings[0].location
    assert (location.line, location.column) == (3, 13)


def test_a_dash_in_windows_1252_is_a_dash(tmp_path):
    (tmp_path / "a.cga").write_bytes(b'A --> report("2 \x96 3", 1)')
    assert "2 \u2013 3" in read_text(tmp_path / "a.cga")
