"""A rule file as a model that follows every save, with its mistakes and the values of its attributes."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any, get_args

import pytest

from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.export.glb import merged_glb
from grammarlab.language.checking.check import check_files
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.parse import parse
from grammarlab.pages import STATIC
from grammarlab.pages.watch.controls import Control, controls_of
from grammarlab.pages.watch.modeler import modeler
from grammarlab.pages.watch.watch_tasks import DrawPicture, MadeModel, MakeModel, Severity, Wanted
from grammarlab.pages.watch.watcher import Watcher
from grammarlab.pages.workers.tasks import FindPart
from grammarlab.runs.sample.checks import SUPPORTED
from tests.waiting import wait_until

RULES = """@Order(2) @Range(min=3, max=30, stepsize=1) attr height = 12
@Order(1) @Group("Look") @Enum("flat", "gable") attr roof = "flat"
@Hidden attr secret = 4
const fixed = 7
@Color attr paint = "#A0522d"
attr hasDoor = true
attr storey = rand(2.8, 3.6)
Lot --> extrude(height) comp(f) { top : Roof | all : Wall }
Roof --> case roof == "gable" : roofGable(35) Tiles else : Flat.
"""


def report(_stage: str, _done: int, _total: int) -> None:
    """Nobody is told."""


def made(file: Path, wanted: Wanted) -> MadeModel:
    return modeler(str(file), "")(MakeModel(wanted), report)


def test_controls_are_those_of_annotations_in_their_order():
    controls = controls_of(Grammar.parse(RULES))
    assert controls == (
        Control("height", "height (m)", "", "number", "12", 3.0, 30.0, 1.0),
        Control("paint", "paint", "", "color", "#A0522d"),
        Control("hasDoor", "has door", "", "switch", "true"),
        Control("storey", "storey", "", "number", ""),
        Control("roof", "roof", "Look", "menu", "flat", choices=("flat", "gable")),
    )


def test_groups_are_together_in_the_order_of_their_numbers():
    places = (("a", "Roof", ""), ("b", "Mass", ", 1"), ("c", "Roof", ", 2"), ("d", "Walls", ", 1"), ("e", "Mass", ""))
    text = "".join(f'@Group("{group}"{number}) attr {name} = 1\n' for name, group, number in places)
    found = controls_of(Grammar.parse(f"{text}@Order(1) attr f = 1 attr g = 1 Lot --> NIL"))
    assert "".join(control.name for control in found) == "fgbedac"


def test_a_file_without_imports_is_parsed_once_and_checked_as_always(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    file = tmp_path / "house.cga"
    file.write_text(f"{RULES}Nobody --> Needs\n")
    (checked,) = check_files(file, "house.cga", SUPPORTED)
    monkeypatch.delattr("grammarlab.language.checking.check.parse")
    mistakes = made(file, Wanted()).mistakes
    places = [(finding.message, finding.location.line, finding.location.column) for finding in checked.findings]
    assert [(mistake.message, mistake.line, mistake.column) for mistake in mistakes] == places
    assert any("Nobody" in message for message, *_ in places)


def test_what_a_derivation_passes_over_or_prints_is_on_the_page_and_unused_rules_are_one_line(tmp_path: Path):
    file = tmp_path / "lot.cga"
    printed = " ".join(f"print({number})" for number in range(22))
    unused = "".join(f"Other{number} --> NIL\n" for number in range(3))
    file.write_text(f'@StartRule\nLot --> {printed} color("#fff") extrude(3) Mass.\n{unused}')
    mistakes = made(file, Wanted()).mistakes
    notes = [mistake.message for mistake in mistakes if mistake.severity == "note"]
    assert notes[:2] == ["printed: 0", "printed: 1"]
    assert (len(notes), notes[-1]) == (21, "… and 2 more printed lines; grammarlab sample shows them")
    unreachable, passed_over = (mistake for mistake in mistakes if mistake.severity == "warning")
    assert "the colour does not change" in passed_over.message
    assert unreachable.line == 3
    assert unreachable.message == "nothing leads from a start rule to the rule Other0, nor to 2 others"


def test_the_page_gets_a_bounded_number_of_remarks_those_of_a_check_first_and_the_begin_of_what_is_printed(
    tmp_path: Path,
):
    file = tmp_path / "lot.cga"
    colors = " ".join(['color("#fff")'] * 120)
    unused = "Other0 --> NIL\nOther1 --> NIL\n"
    file.write_text(f'@StartRule\nLot --> print("{"x" * 5000}\\ny") {colors} extrude(3) Mass.\n{unused}')
    *remarks, rest, printed = made(file, Wanted()).mistakes
    assert remarks[0].message.endswith("the rule Other0, nor to 1 other")
    assert [remark.severity for remark in remarks] == ["warning"] * 100
    assert (rest.severity, rest.message) == ("note", "… and 21 more remarks; grammarlab check or sample shows them")
    assert printed.message.startswith("printed: xxx")
    assert len(printed.message) < 250
    assert printed.message.endswith("… (5,002 characters)")


def test_files_are_read_again_only_after_a_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Sliders, seeds and the sheet need no new reading of the file and its imports; a change of either does."""
    rules, parts = tmp_path / "lot.cga", tmp_path / "walls.cga"
    parts.write_text("Brick --> Stone.")
    rules.write_text('import walls : "walls.cga"\nimport roofs : "roofs.cga"\nLot --> extrude(3) walls.Brick')
    parsed: list[str] = []
    monkeypatch.setattr(
        "grammarlab.language.grammar.parse", lambda text, file: (parsed.append(Path(file).name), parse(text, file))[1]
    )
    make = modeler(str(rules), "")

    def read(request: MakeModel | DrawPicture) -> list[str]:
        parsed.clear()
        make(request, report)
        return [name for name in parsed if name != "lot.cga"]

    assert read(MakeModel(Wanted())) == ["walls.cga"]
    assert read(MakeModel(Wanted())) == ["walls.cga"]  # an import is missing, and might be there now
    (tmp_path / "roofs.cga").write_text("Flat --> Tiles.")
    assert read(MakeModel(Wanted())) == ["walls.cga", "roofs.cga"]
    assert [read(request) for request in (MakeModel(Wanted(seed=2)), DrawPicture(Wanted(model=3), 16))] == [[], []]
    parts.write_text("Brick --> extrude(1) Stone.")
    assert read(DrawPicture(Wanted(), 16)) == ["walls.cga", "roofs.cga"]
    assert read(MakeModel(Wanted())) == []


@pytest.mark.parametrize("is_imported", [False, True])
def test_a_save_while_a_model_is_made_is_seen_by_the_next_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_imported: bool
):
    rules, parts = tmp_path / "lot.cga", tmp_path / "walls.cga"
    saved = parts if is_imported else rules
    if is_imported:
        rules.write_text('import walls : "walls.cga"\nLot --> extrude(3) walls.Brick')
    texts = [f"attr saved{number} = 4\nBrick --> extrude(3) {'A. ' * number}" for number in range(5)]
    saved.write_text(texts[1])
    saves = iter((texts[2], texts[3]))

    def late(*arguments: Any) -> bytes:
        if text := next(saves, None):
            saved.write_text(text)
        return merged_glb(*arguments)

    monkeypatch.setattr("grammarlab.pages.watch.modeler.merged_glb", late)
    make = modeler(str(rules), "")

    def shapes() -> int:
        made = make(MakeModel(Wanted()), report)
        assert isinstance(made, MadeModel)
        return made.shapes

    first, *others = (shapes() for _ in range(4))
    assert others == [first + 1, first + 2, first + 2]
    # What is saved for a moment only leaves no remarks.
    saves = iter(("Brick --> extrudd(3) A.",))
    saved.write_text(texts[4])
    shapes()
    saved.write_text(texts[4])
    assert made(rules, Wanted()).mistakes == make(MakeModel(Wanted()), report).mistakes == ()


@pytest.mark.parametrize("indent", [0, 5, 199, 200, 201, 5000])
def test_the_place_of_a_mistake_in_a_long_line_is_shown(tmp_path: Path, indent: int):
    file = tmp_path / "lot.cga"
    begin = "Lot --> " + "A. " * (indent // 3)
    file.write_text(f"{begin}extrudd(3) {'B. ' * 200}")
    (mistake,) = made(file, Wanted()).mistakes
    before, behind = mistake.code
    assert begin.endswith(before.removeprefix("…"))
    assert before.startswith("…") == (len(begin) > 200)
    assert behind.startswith("extrudd(3) B.")
    assert len(before + behind) <= 402
    assert mistake.column == len(begin) + 1


def test_the_place_of_a_mistake_is_shown_without_indentation(tmp_path: Path):
    file = tmp_path / "lot.cga"
    file.write_text("Lot -->\n" + 14 * "\t" + "A extrudd(3) B")
    (mistake,) = made(file, Wanted()).mistakes
    assert (mistake.code, mistake.line, mistake.column) == (("A ", "extrudd(3) B"), 2, 17)


def test_every_severity_has_a_style_on_the_page():
    style = (STATIC / "watch/page.css").read_text()
    assert all(f".wa-{severity}" in style for severity in get_args(Severity))


def test_a_mistake_has_its_line_whatever_kind_it_is(tmp_path: Path):
    file = tmp_path / "house.cga"
    bench = modeler(str(file), "")
    for text, line, column, words in (
        ("Lot --> extrude(3\n", 1, 16, "never closed"),
        ("attr a = 1\nLot --> extrude(b) Wall", 2, 17, "unknown name 'b'"),
        ("Lot --> Lot", 1, 1, "never ends"),
        ("", 0, 0, "no start rule"),
    ):
        file.write_text(text)
        found: MadeModel = bench(MakeModel(Wanted()), report)
        assert not found.glb
        mistake = found.mistakes[0]
        assert mistake.severity == "error"
        assert words in mistake.message
        assert (mistake.line, mistake.column) == (line, column)
    with pytest.raises(GrammarlabError, match="no model"):
        bench(FindPart("", 0, False), report)
    file.write_text('Lot --> i("absent.obj")')
    absent: MadeModel = bench(MakeModel(Wanted()), report)
    assert "--assets DIR" in absent.mistakes[0].hint
    # A save that removes an attribute leaves its value behind, and the next one is a model again.
    file.write_text("Lot --> extrude(3) comp(f) { all : Wall }")
    good: MadeModel = bench(MakeModel(Wanted(attributes=(("height", "9"),))), report)
    assert (good.shapes, good.mistakes, good.glb[:4]) == (7, (), b"glTF")
    # Rows of the tree: the initial shape with all triangles, and six equal walls with the same ones.
    assert [(row[0], row[1], row[2], row[3]) for row in good.tree] == [(0, "Lot", "", 1), (1, "Wall", " x 6", 1)]
    assert [row[5] for row in good.tree] == [[0, 12], [0, 12]]
    part = bench(FindPart("", 0, True), report)
    assert (part.count, part.path[0][0], part.path[-1][0]) == (6, "Lot", "Wall")
    assert bench(DrawPicture(Wanted(), 24), report)[:2] == b"\xff\xd8"


def test_values_change_the_model_and_values_out_of_range_are_told(tmp_path: Path):
    file = tmp_path / "house.cga"
    file.write_text(RULES)
    assert made(file, Wanted()).shapes == 8
    assert made(file, Wanted(attributes=(("roof", "gable"),))).shapes == 8
    assert made(file, Wanted(attributes=(("height", "9"),))).glb != made(file, Wanted()).glb
    assert "expected 3 to 30" in made(file, Wanted(attributes=(("height", "99"),))).mistakes[0].message
    assert made(file, Wanted()).glb == made(file, Wanted()).glb


def test_every_save_is_seen_and_steps_go_back(tmp_path: Path):
    file = tmp_path / "house.cga"
    file.write_text(RULES)
    with closing(Watcher(str(file))) as watcher:

        def state() -> dict[str, object]:
            return watcher.call("state")[0]

        def wait_for(**values: object) -> None:
            wait_until(lambda: values.items() <= state().items(), state)

        wait_for(version=1, busy=False, mistakes=[])
        watcher.call("set", name="height", value="20")
        wait_for(version=2, values={"height": "20"}, undo="value of height")
        file.write_text("Lot -> NIL")
        wait_until(lambda: state()["mistakes"], state)
        assert state()["version"] == 2  # the last good one stays
        file.write_text(RULES.replace("Tiles", "Slates"))
        wait_for(version=3, mistakes=[], values={"height": "20"})
        watcher.call("undo")
        wait_for(version=4, values={})
        with pytest.raises(GrammarlabError, match="no attribute 'nothing'"):
            watcher.call("set", name="nothing", value="1")
        watcher.call("want", seed=7, model=3)
        wait_for(version=5, seed=7, model=3)
        seed = watcher.call("roll")[0]["seed"]
        wait_for(seed=seed, version=6)
        assert watcher.call("model")[1][0][:4] == b"glTF"


def test_a_species_has_no_rules_to_watch():
    with pytest.raises(UsageError, match="no rules to watch"):
        Watcher("oak")


def test_rules_of_a_library_are_watched_with_it(tmp_path: Path):
    rules = tmp_path / "lot.cga"
    rules.write_text('import walls : "/City.lib/rules/walls.cga"\nLot --> extrude(3) walls.Brick')
    (tmp_path / "lib" / "City.lib" / "rules").mkdir(parents=True)
    (tmp_path / "lib" / "City.lib" / "rules" / "walls.cga").write_text("Brick --> Stone. Stone.")
    libraries = ("", str(tmp_path / "lib"))
    without, made = (modeler(str(rules), "", each)(MakeModel(Wanted()), lambda *_: None) for each in libraries)
    assert isinstance(without, MadeModel)
    assert isinstance(made, MadeModel)
    assert (without.shapes, made.shapes, made.mistakes) == (2, 4, ())


def test_a_misspelt_operation_is_told_at_its_line_beside_the_model(tmp_path: Path):
    rules = tmp_path / "lot.cga"
    rules.write_text("Lot -->\n    extrud(3) Block.")
    make = modeler(str(rules), "")
    for _ in range(2):
        made = make(MakeModel(Wanted()), lambda *_: None)
        assert isinstance(made, MadeModel)
        (mistake,) = made.mistakes
        assert (mistake.severity, mistake.line, mistake.column, made.shapes) == ("warning", 2, 5, 3)
        assert "unknown rule or operation 'extrud'" in mistake.message
    rules.write_text("Lot -->\n    extrude(3) Block.")
    made = make(MakeModel(Wanted()), lambda *_: None)
    assert isinstance(made, MadeModel)
    assert made.mistakes == ()


def test_mistakes_of_imported_files_are_told_with_their_names_after_every_save(tmp_path: Path):
    rules, parts = tmp_path / "lot.cga", tmp_path / "parts" / "walls.cga"
    parts.parent.mkdir()
    rules.write_text('import walls : "parts/walls.cga"\nLot --> extrude(3) walls.Brick')
    make = modeler(str(rules), "")
    wrong = "Brick --> extrudd(3) Stone."
    for text, lines in ((wrong, [1]), ("// moved\n" + wrong, [2]), ("Brick --> Stone.", [])):
        parts.write_text(text)
        made = make(MakeModel(Wanted()), report)
        assert isinstance(made, MadeModel)
        mistakes = [(each.severity, each.line, each.code) for each in made.mistakes]
        assert mistakes == [("warning", line, ("Brick --> ", "extrudd(3) Stone.")) for line in lines]
        assert all(each.message.startswith("parts/walls.cga: unknown rule or") for each in made.mistakes)
    rules.write_text("Lot --> extrude(3) Stone.")
    parts.unlink()
    made = make(MakeModel(Wanted()), report)
    assert isinstance(made, MadeModel)
    assert (made.shapes, made.mistakes) == (2, ())
