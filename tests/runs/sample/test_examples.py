"""What a GRAMMAR argument means."""

import pytest

from grammarlab.errors import UsageError
from grammarlab.runs.sample.shipped import find_rules, shipped_examples


def test_the_shipped_grammars_are_found_by_name_with_their_assets():
    names = {example.name for example in shipped_examples()}
    assert {"toy", "furniture", "building", "skyscraper", "airplane"} <= names
    for name in names:
        source = find_rules(name)
        assert source.shipped
        assert source.assets.is_dir()


def test_every_shipped_grammar_says_in_one_sentence_what_it_is():
    for example in shipped_examples():
        assert 20 < len(example.description()) < 130, example.name


@pytest.mark.parametrize(
    ("text", "description"),
    [
        ('/* A house.\n * And more. */\nversion "1"', "A house."),
        ("/**\n * A house\n * of two storeys. More.\n */", "A house of two storeys."),
        ("# A house.\n# More.\nLot --> X", "A house."),
        ('version "2023.0"\n// A house\n//\n// More.\nLot --> X', "A house"),
        ("Lot --> X // A house.\n", ""),
        ("", ""),
    ],
)
def test_a_description_is_the_first_sentence_of_the_comment_at_the_top(tmp_path, text, description):
    (tmp_path / "a.cga").write_text(text)
    assert find_rules(str(tmp_path / "a.cga")).description() == description


def test_a_path_goes_before_a_shipped_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "toy").write_text("Lot --> X")
    assert not find_rules("toy").shipped


def test_assets_lie_beside_the_rules_unless_said_otherwise(tmp_path):
    rules = tmp_path / "house.cga"
    rules.write_text("Lot --> X")
    assert find_rules(str(rules)).assets == tmp_path
    (tmp_path / "assets").mkdir()
    assert find_rules(str(rules)).assets == tmp_path
    (tmp_path / "assets" / "oak.obj").touch()
    assert find_rules(str(rules)).assets == tmp_path / "assets"
    (tmp_path / "mine").mkdir()
    assert find_rules(str(rules), tmp_path / "mine").assets == tmp_path / "mine"


@pytest.fixture
def project(tmp_path):
    """A project as CityEngine makes them, in a folder that has assets of its own."""
    files = ("assets/oak.obj", "city/assets/elm.obj", "city/scenes/town.cej", "city/rules/lib/street/lot.cga")
    for file in (*files, "city/rules/house.cga", "city/scripts/tool.cga"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text("Lot --> X")
    return tmp_path / "city"


@pytest.mark.parametrize("rules", ["rules/house.cga", "rules/lib/street/lot.cga", "rules/../rules/house.cga"])
def test_the_rules_of_a_project_find_the_assets_of_the_project(project, rules, monkeypatch):
    assert find_rules(str(project / rules)).assets == project / "assets"
    monkeypatch.chdir(project / "rules" / "lib")
    assert find_rules("street/lot.cga").assets == project / "assets"


def test_only_the_folder_of_rules_leads_to_the_assets_of_a_project(project, tmp_path):
    assert find_rules(str(project / "scripts" / "tool.cga")).assets == project / "scripts"
    (project / "assets" / "elm.obj").unlink()
    assert find_rules(str(project / "rules" / "house.cga")).assets == project / "rules"
    (project / "rules" / "lib" / "rules").mkdir()
    (project / "rules" / "lib" / "rules" / "a.cga").write_text("Lot --> X")
    (project / "assets" / "elm.obj").touch()
    assert find_rules(str(project / "rules" / "lib" / "rules" / "a.cga")).assets == project / "rules" / "lib" / "rules"


@pytest.mark.parametrize("place", ["..", "../assets", "assets"])
def test_assets_of_a_project_that_lie_outside_are_left_alone(project, place):
    (project / "assets" / "elm.obj").unlink()
    (project / "assets").rmdir()
    (project / "assets").symlink_to(place)
    assert find_rules(str(project / "rules" / "house.cga")).assets == project / "rules"


def test_old_files_in_latin_1_are_read(tmp_path):
    (tmp_path / "a.cga").write_bytes("// Bâtiment.\n".encode("latin-1"))
    assert find_rules(str(tmp_path / "a.cga")).description() == "Bâtiment."


@pytest.mark.parametrize(
    ("argument", "hint"),
    [("bilding", "'building'"), ("Building.cga", "'building'"), ("skyscrapper", "'skyscraper'"), ("zzzz", "Shipped: ")],
)
def test_a_misspelt_name_is_answered_with_the_nearest(argument, hint):
    with pytest.raises(UsageError, match=hint):
        find_rules(argument)


def test_a_misspelt_path_is_answered_with_its_neighbour(tmp_path):
    (tmp_path / "house.cga").write_text("Lot --> X")
    with pytest.raises(UsageError, match=r"'house\.cga'"):
        find_rules(str(tmp_path / "hose.cga"))


def test_a_folder_or_missing_assets_are_refused(tmp_path):
    with pytest.raises(UsageError, match="is a folder"):
        find_rules(str(tmp_path))
    with pytest.raises(UsageError, match="assets"):
        find_rules("toy", tmp_path / "nowhere")
