"""What a GRAMMAR argument means."""

import pytest

from grammarlab.errors import UsageError
from grammarlab.runs.examples import find_rules, shipped_examples


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
    assert find_rules(str(rules)).assets == tmp_path / "assets"
    (tmp_path / "mine").mkdir()
    assert find_rules(str(rules), tmp_path / "mine").assets == tmp_path / "mine"


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
