import pytest

from grammarlab.errors import UsageError
from grammarlab.runs.evaluate.request import find_scenarios, named_scenarios, scenarios_folder, shipped_scenarios


def test_a_scenario_is_a_file_a_folder_or_a_shipped_name(tmp_path):
    for name in ("b.toml", "a.toml", "other.txt"):
        (tmp_path / name).touch()
    assert find_scenarios(str(tmp_path / "b.toml")) == (tmp_path / "b.toml",)
    assert find_scenarios(str(tmp_path)) == (tmp_path / "a.toml", tmp_path / "b.toml")
    assert find_scenarios("F1") == (shipped_scenarios()["F1"],)
    assert find_scenarios(f"F1,{tmp_path}") == (shipped_scenarios()["F1"], tmp_path / "a.toml", tmp_path / "b.toml")
    assert find_scenarios("xor_furniture,F1") == (named_scenarios()["xor_furniture"], shipped_scenarios()["F1"])
    many = list(named_scenarios())
    assert find_scenarios(",".join(many)) == tuple(named_scenarios().values())
    assert {"F1", "F2", "F3", "F4", "B1", "B2", "B3", "B4", "S1", "S2", "A1"} <= set(shipped_scenarios())


def test_the_folder_of_all_scenarios_is_without_the_tastes():
    assert find_scenarios(str(scenarios_folder())) == tuple(shipped_scenarios().values())
    assert named_scenarios().keys() > shipped_scenarios().keys()


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("f1", "Did you mean 'F1'"),
        ("B1,f1", "Did you mean 'F1'"),
        ("scenarios/F1.tml", "Did you mean 'F1'"),
        ("xor_furnitur", "Did you mean 'xor_furniture'"),
        ("nothing", "Shipped: A1, B1"),
        ("", "has no scenario"),
    ],
)
def test_what_does_not_exist_is_answered_with_the_nearest(argument, message, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match=message):
        find_scenarios(argument)


def test_a_folder_without_scenarios_says_so(tmp_path):
    with pytest.raises(UsageError, match="has no scenario"):
        find_scenarios(str(tmp_path))
