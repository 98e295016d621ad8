"""Checks of all rule files of a folder."""

from __future__ import annotations

import pytest

from grammarlab.errors import UsageError
from grammarlab.runs.sample.folder_checks import check_folder


def test_every_file_of_a_folder_is_tried_and_what_is_missing_is_counted(tmp_path):
    files = {
        "runs.cga": "Lot --> comp(g) { all : A }\nStart --> extrude(3) A\n@StartRule\nMain --> Start",
        "below/part.cga": "Wall(a) --> extrude(a) A",
        "below/import.cga": 'import b : "absent.cga"\nLot --> b.Wall',
        "broken.cga": "Lot --> extrude(",
        "stops.cga": "Lot --> comp(g) { all : A }",
        "endless.cga": "Lot --> Lot Lot",
        "below/nested.cga": 'import c : "import.cga"\nLot --> extrude(c.b.height) A',
        "note.txt": "Lot --> A",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    checked = check_folder(tmp_path)
    assert {file.file: file.outcome for file in checked.files} == {
        "below/import.cga": "import",
        "below/nested.cga": "import",
        "below/part.cga": "no start rule",
        "broken.cga": "error",
        "endless.cga": "error",
        "runs.cga": "runs",
        "stops.cga": "stops",
    }
    ((feature, number),) = checked.wanted()
    assert number == 2
    assert "comp with g" in feature
    assert checked.counts()["error"] == 2


def test_a_folder_without_rule_files_is_refused(tmp_path):
    with pytest.raises(UsageError, match=r"expected \.cga files"):
        check_folder(tmp_path)


def test_projects_of_a_folder_import_from_each_other(tmp_path):
    for name, text in {
        "Town/rules/main.cga": 'import b : "/Lib/rules/part.cga"\nLot --> b.Wall(3)',
        "Lib/rules/part.cga": "Wall(a) --> extrude(a) A",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text)
    assert check_folder(tmp_path).counts() == {"no start rule": 1, "runs": 1}
