"""The protocol, through a session itself, without pictures."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from grammarlab.errors import AssetError, GrammarlabError, UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.language.presets import RuleChoices, preset
from grammarlab.pages.record.judgements import Judgement
from grammarlab.pages.record.store import Store
from grammarlab.pages.scoring.display import MAX_WARNINGS
from grammarlab.pages.scoring.session import Session
from tests.pages.scoring.tower import TOWER
from tests.pages.scoring.windows import BrokenWindow, Window, shown_models


def test_the_first_grid_shows_samples_of_the_grammar(session: Session):
    state, _ = session.call("state")
    models = shown_models(state)
    assert len(set(models)) == 32
    assert {model[0] for model in models} == {"g"}
    assert set(state["models"]) == set(models)
    assert (state["title"], state["learns"]) == ("tower", "grammar")
    assert state["session"] == "towers.db"
    assert state["layout"] == {"grids": 2, "rows": 4, "columns": 4}
    assert state["factors"] == [{"id": 1, "name": "overall", "labels": 0}]
    assert not state["can_undo"]


def test_a_score_is_in_the_file_when_it_is_answered(session: Session, tmp_path: Path):
    models = shown_models(session.call("state")[0])[:3]
    result, _ = session.call("score", models=models, score=70)
    with closing(Store.open(tmp_path / "towers.db")) as store:
        assert store.record.factors["overall"] == dict.fromkeys(models, Judgement(70.0))
        assert result == {"saved": True, "revision": store.record.revision}


def test_all_windows_agree(session: Session):
    one, other = Window(session), Window(session)
    model = shown_models(session.call("state")[0])[0]
    one.ask({"id": "a", "command": "score", "models": [model], "score": 5})
    answer, _ = one.wait(lambda message: message.get("id") == "a")
    revision = answer["result"]["revision"]
    assert one.state(lambda state: state["revision"] == revision) == other.state(
        lambda state: state["revision"] == revision
    )
    other.close()
    other.forget()
    session.call("undo")
    one.state(lambda state: state["can_redo"])
    session.call("redo")
    assert not other.heard


def test_a_window_that_fails_keeps_no_other_from_hearing(session: Session):
    broken = BrokenWindow(answers=2)
    session.listen(broken.send)
    window = Window(session)
    models = shown_models(session.call("state")[0])
    for number, model in enumerate(models[:3]):
        session.handle({"id": number, "command": "score", "models": [model], "score": 70}, (), broken.send)
    assert window.state(lambda state: state["scored"] == 3)
    assert session.call("state")[0]["scored"] == 3
    window.forget()
    session.call("undo")
    assert window.state(lambda state: state["scored"] == 2)
    assert "state" not in [message.get("event") for message in broken.heard[3:]]


def test_a_closed_session_says_so(session: Session):
    window = Window(session)
    session.close()
    with pytest.raises(GrammarlabError, match="has been closed"):
        session.call("state")
    window.ask({"id": 5, "command": "state"})
    assert not window.wait(lambda message: message.get("id") == 5)[0]["ok"]
    session.listen(window.send)
    session.close()


def test_files_of_any_name_begin_sessions(tmp_path: Path):
    rules = tmp_path / "my 'tower' [2].cga"
    rules.write_text(TOWER)
    with closing(Session(str(rules), tmp_path / "a b.db", jobs=0)) as session:
        assert session.call("state")[0]["title"] == "my _tower_ _2_"
    Session(str(rules), tmp_path / "a b.db", jobs=0).close()


def test_a_session_of_trees_learns_a_species(tmp_path: Path):
    with closing(Session("shrub", tmp_path / "shrubs.db", jobs=0)) as session:
        assert session.call("state")[0]["learns"] == "species"


def test_features_that_are_still_being_counted_are_no_mistake(tmp_path: Path):
    with closing(Session("toy", tmp_path / "toys.db", jobs=0)) as session:
        assert session.call("features", query="")[0] == {"features": None}


def test_another_process_on_the_file_is_seen(session: Session, tmp_path: Path, rules: str):
    window = Window(session)
    model = shown_models(session.call("state")[0])[0]
    with closing(Session(rules, tmp_path / "towers.db", jobs=0)) as other:
        assert other.call("state")[0]["grids"] == session.call("state")[0]["grids"]
        other.call("score", models=[model], score=12)
        state = window.state(lambda state: state["scored"] == 1)
        assert state["models"][model]["score"] == 12.0
        session.call("undo")
        with pytest.raises(GrammarlabError, match="nothing to undo"):
            other.call("undo")


def test_sessions_go_on_where_they_ended(session: Session, tmp_path: Path, rules: str):
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:2], score=40)
    session.call("factor_create", name="roof")
    session.call("layout", grids=1, rows=2, columns=5)
    session.call("new_models", way="grammar")
    before, _ = session.call("state")
    session.close()
    with closing(Session(rules, tmp_path / "towers.db", jobs=0)) as again:
        after, _ = again.call("state")
    assert after == before | {"message": None}
    assert len(shown_models(after)) == 10


def test_a_changed_grammar_is_refused_with_a_way_on(session: Session, tmp_path: Path, rules: str):
    before, _ = session.call("state")
    session.close()
    Path(rules).write_text(TOWER.replace("12", "15"))
    with pytest.raises(UsageError, match=r"another grammar.*--stored-grammar"):
        Session(rules, tmp_path / "towers.db", jobs=0)
    with closing(Session(rules, tmp_path / "towers.db", jobs=0, stored_grammar=True)) as again:
        assert again.call("state")[0]["grids"] == before["grids"]
    with pytest.raises(UsageError, match="no stored grammar"):
        Session(rules, tmp_path / "new.db", jobs=0, stored_grammar=True)
    with pytest.raises(UsageError, match="leave out either these choices or"):
        Session(rules, tmp_path / "towers.db", choices=RuleChoices(start_rule="Side"), jobs=0, stored_grammar=True)


def test_choices_are_those_of_an_ordinary_grammar_and_a_reopened_session_says_which_differ(tmp_path: Path, rules: str):
    path = tmp_path / "towers.db"
    choices = RuleChoices(start_rule="Side", attributes={"floors": 3})
    with closing(Session(rules, path, choices=choices, seed=3, size=60, jobs=0)) as session:
        before, _ = session.call("state")
    text = preset(Grammar.parse(TOWER), "Side", {"floors": 3}).text
    with closing(Store.open(path)) as store:
        assert store.about.grammar == text
    Path(rules).write_text(text)
    with closing(Session(rules, path, jobs=0)) as again:
        assert again.call("state")[0]["grids"] == before["grids"]
    Path(rules).write_text(TOWER)
    differ = r"start rule Side, now Lot; attribute floors = 3, now 50% : 2 else : 5\."
    with pytest.raises(UsageError, match=differ):
        Session(rules, path, jobs=0)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"path": "a.sqlite"}, "ends in .db"),
        ({"path": "missing/a.db"}, "no folder"),
        ({"seed": -1}, "seed is -1"),
        ({"seed": 1 << 64}, "seed is"),
        ({"size": 0}, "size is 0"),
    ],
)
def test_arguments_out_of_range_are_refused(tmp_path: Path, rules: str, arguments: dict[str, Any], expected: str):
    path = tmp_path / arguments.pop("path", "a.db")
    with pytest.raises(UsageError, match=expected):
        Session(rules, path, jobs=0, **arguments)
    assert not path.exists()


def test_a_grammar_with_errors_makes_no_file(tmp_path: Path):
    rules = tmp_path / "bad.cga"
    rules.write_text("Lot --> nonsense(")
    with pytest.raises(GrammarlabError, match=r"bad\.cga:1"):
        Session(str(rules), tmp_path / "a.db", jobs=1)
    assert not (tmp_path / "a.db").exists()


def test_scores_belong_to_the_active_factor(session: Session):
    model = shown_models(session.call("state")[0])[0]
    session.call("score", models=[model], score=10)
    session.call("factor_create", name="roof")
    session.call("score", models=[model], score=90)
    assert session.call("state")[0]["models"][model]["score"] == 90.0
    session.call("factor_activate", name="overall")
    assert session.call("state")[0]["models"][model]["score"] == 10.0
    session.call("view", kind="product")
    with pytest.raises(GrammarlabError, match="the product of all factors"):
        session.call("score", models=[model], score=10)


def test_what_is_meant_for_a_factor_goes_to_it_whatever_another_window_does(
    session: Session, tmp_path: Path, rules: str
):
    """The other window is another process, of which this one has not heard yet."""
    model = shown_models(session.call("state")[0])[0]
    session.call("factor_create", name="roof")
    roof = session.call("state")[0]["factors"][1]["id"]
    with closing(Store.open(tmp_path / "towers.db")) as other:
        other.append("factor_rename", {"name": "roof", "to": "colour"})
        other.append("factor_create", {"name": "roof"})
        session.call("score", models=[model], score=30, factor=roof)
        other.append("factor_rename", {"name": "colour", "to": "wall"})
        session.call("factor_rename", name=roof, to="door")
        other.poll()
        assert other.record.factors == {"overall": {}, "door": {model: Judgement(30.0)}, "roof": {}}
        other.append("factor_rename", {"name": "door", "to": "gate"})
        session.call("factor_activate", name=roof)
        other.poll()
        assert other.record.active == "gate"
        other.append("factor_rename", {"name": "gate", "to": "stair"})
        session.call("factor_delete", name=roof)
        other.poll()
        assert list(other.record.factors) == ["overall", "roof"]
        acts: list[tuple[str, dict[str, Any]]] = [
            ("score", {"models": [model], "score": 30, "factor": roof}),
            ("factor_rename", {"name": roof, "to": "x"}),
            ("factor_delete", {"name": roof}),
            ("factor_activate", {"name": roof}),
        ]
        for command, arguments in acts:
            with pytest.raises(GrammarlabError, match="has been deleted; Undo brings it"):
                session.call(command, **arguments)
        other.append("undo", {})
        session.call("score", models=[model], score=40, factor=roof)
        other.poll()
        assert other.record.factors["stair"] == {model: Judgement(40.0)}


def test_a_score_that_is_sent_again_counts_once(session: Session, tmp_path: Path, rules: str):
    models = shown_models(session.call("state")[0])
    session.call("factor_create", name="roof")
    sent: dict[str, Any] = {"models": models[:1], "score": 10, "factor": "overall", "key": "abc"}
    session.call("view", kind="product")
    first, _ = session.call("score", **sent)
    session.call("score", models=models[:1], score=20, factor="overall", key="def")
    again, _ = session.call("score", **sent)
    assert again == first | {"revision": first["revision"] + 1}
    session.call("undo")
    session.close()
    with closing(Session(rules, tmp_path / "towers.db", jobs=0)) as later:
        assert later.call("score", **sent)[0]["revision"] == first["revision"] + 2
        later.call("view", kind="active")
        later.call("factor_activate", name="overall")
        assert later.call("state")[0]["models"][models[0]]["score"] == 10.0


def test_new_models_leave_scored_models_and_shows_others(session: Session):
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:4], score=1)
    seen = set(models)
    for _ in range(4):
        session.call("new_models", way="grammar")
        new = shown_models(session.call("state")[0])
        assert len(new) == 32
        assert seen.isdisjoint(new)
        seen.update(new)
    session.call("new_models", way="grammar")
    rest = shown_models(session.call("state")[0])
    assert set(models[:4]).isdisjoint(rest)
    assert len(set(rest)) == len(rest) == 32


def test_grids_are_cut_and_filled(session: Session):
    before = session.call("state")[0]["grids"]
    session.call("layout", grids=2, rows=2, columns=3)
    cut = session.call("state")[0]["grids"]
    assert [grid["models"] for grid in cut] == [grid["models"][:6] for grid in before]
    session.call("layout", grids=2, rows=10, columns=8)
    assert len(shown_models(session.call("state")[0])) == 148  # all samples but the twelve that were shown


def test_sorting_without_knowledge(session: Session):
    state, _ = session.call("state")
    models = shown_models(state)
    session.call("score", models=[models[5]], score=30)
    session.call("score", models=[models[20]], score=60)
    session.call("sort", by="score")
    grids = session.call("state")[0]["grids"]
    assert [grid["models"][0] for grid in grids] == [models[5], models[20]]
    session.call("sort", by="random")
    mixed = session.call("state")[0]["grids"]
    assert mixed != grids
    session.call("sort", by="shown")
    assert session.call("state")[0]["grids"] == state["grids"]
    with pytest.raises(GrammarlabError, match="nothing has been learned"):
        session.call("sort", by="uncertainty")
    with pytest.raises(GrammarlabError, match="still being counted"):
        session.call("sort", by="feature", feature="x")


@pytest.mark.parametrize(
    "message",
    [
        None,
        5,
        "text",
        [],
        {},
        {"id": {}},
        {"id": 1, "command": None},
        {"id": 1, "command": "close"},
        {"id": 1, "command": ["score"]},
        {"id": 1, "command": "score"},
        {"id": 1, "command": "score", "models": ["g1-1"], "score": "80"},
        {"id": 1, "command": "score", "models": ["g1-1"] * 2, "score": 5},
        {"id": 1, "command": "score", "models": [f"g1-{k}" for k in range(20_001)], "score": 5},
        {"id": 1, "command": "score", "models": ["../../etc/passwd"], "score": 5},
        {"id": 1, "command": "factor_create", "name": {"a": 1}},
        {"id": 1, "command": "factor_rename", "name": "overall"},
        {"id": 1, "command": "layout", "grids": 1, "rows": "4", "columns": 4},
        {"id": 1, "command": "new_models", "way": "nonsense"},
        {"id": 1, "command": "new_models", "way": 5},
        {"id": 1, "command": "sort"},
        {"id": 1, "command": "sort", "by": "nonsense"},
        {"id": 1, "command": "pictures", "models": ["g1-1"], "size": 10_000},
        {"id": 1, "command": "pictures", "models": [f"g1-{k}" for k in range(1001)], "size": 160},
        {"id": 1, "command": "model", "model": "nonsense"},
        {"id": 1, "command": "export", "format": "exe"},
        {"id": 1, "command": "import", "format": "csv"},
        {"id": 1, "command": "sheet", "num": 10_000},
        {"id": 1, "command": "update"},
    ],
    ids=lambda message: json.dumps(message)[:60],
)
def test_what_is_no_request_is_answered_in_words(session: Session, message: Any):
    before = session.call("state")[0]["revision"]
    window = Window(session)
    window.ask(message)
    answer, _ = window.wait(lambda said: "ok" in said)
    assert answer["ok"] is False
    assert "unexpected" not in answer["error"]
    assert 10 < len(answer["error"]) < 600
    assert session.call("state")[0]["revision"] == before


def test_what_happens_to_the_file_is_told_and_nothing_is_claimed_saved(session: Session, tmp_path: Path):
    model = shown_models(session.call("state")[0])[0]
    with closing(Store.open(tmp_path / "towers.db")) as other:
        other._connection.execute("UPDATE events SET body = 'x', number = 5 WHERE number = 1")
    window = Window(session)
    with pytest.raises(GrammarlabError, match="broken"):
        session.call("score", models=[model], score=5)
    assert "broken" in window.state(lambda state: state["message"])["message"]


def test_a_session_needs_a_folder_it_can_write_to(tmp_path: Path, rules: str):
    (tmp_path / "a.db").mkdir()
    with pytest.raises(AssetError, match="a folder"):
        Session(rules, tmp_path / "a.db", jobs=0)


def test_labels_go_out_and_come_back(session: Session, tmp_path: Path, rules: str):
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:3], score=40)
    session.call("factor_create", name="roof, steep")
    session.call("score", models=models[2:6], score=12.5)
    scores = [{"id": 1, "name": "overall", "labels": 3}, {"id": 2, "name": "roof, steep", "labels": 4}]
    for kind in ("csv", "jsonl", "parquet"):
        result, buffers = session.call("export", format=kind)
        assert result == {"file": f"towers.{kind}"}
        with closing(Session(rules, tmp_path / f"{kind}.db", jobs=0)) as other:
            assert other.call("import", buffers=buffers, format=kind)[0] == {"added": 7}
            assert other.call("state")[0]["factors"] == scores
            assert other.call("export", format=kind)[1] == buffers
            other.call("undo")
            assert other.call("state")[0]["factors"] == [{"id": 1, "name": "overall", "labels": 0}]


def test_an_import_tells_what_it_understood_of_the_file(session: Session):
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:3], score=40)
    header, *rows = session.call("export", format="csv")[1][0].decode().splitlines()
    rows = [row.replace("40.0", score) for row, score in zip(rows, ("0.5", "1", ""), strict=True)]
    rows.append(rows[0].replace("0.5", "0.25"))
    file = "\n".join([header, *rows]).replace(",", "\t").encode()
    result, _ = session.call("import", buffers=[file], format="tsv")
    assert result["added"] == 2
    assert [note.split(":")[0] for note in result["notes"]] == [
        "1 row without a score is left out",
        "all scores are from 0 to 1 and are read as fractions of 100",
        "1 label is left out",
    ]


def test_labels_of_other_models_are_refused(session: Session):
    model = shown_models(session.call("state")[0])[0]
    session.call("score", models=[model], score=40)
    text = session.call("export", format="csv")[1][0].decode()
    header, row = text.splitlines()
    place = header.split(",").index("footprint")
    foreign = [
        ("labels about another grammar", row.replace(row.split(",")[4], "0" * 64)),
        ("footprint of their own", ",".join([*row.split(",")[:place], "20x12", *row.split(",")[place + 1 :]])),
        ("score", row.replace("40.0", "140")),
        ("^the file: .*cells", row + ",,,x"),
    ]
    for expected, line in foreign:
        with pytest.raises(GrammarlabError, match=expected):
            session.call("import", buffers=[f"{header}\n{line}\n".encode()], format="csv")
    with pytest.raises(GrammarlabError, match="no labels"):
        session.call("import", buffers=[f"{header}\n".encode()], format="csv")
    with pytest.raises(GrammarlabError):
        session.call("import", buffers=[b"\xff" * 1000], format="parquet")
    assert session.call("state")[0]["scored"] == 1


def test_meshes_that_are_not_there_are_told_once_with_their_places(tmp_path: Path):
    rules = tmp_path / "house.cga"
    rules.write_text('Lot --> extrude(3) comp(f) { side : i("win" + "dow.glb") A | top : i("oak.obj") i("oak.obj") B }')
    with closing(Session(str(rules), tmp_path / "a.db", size=40, jobs=2)) as session:
        window = Window(session)
        models = shown_models(session.call("state")[0])
        assert session.call("state")[0]["warnings"] == []
        window.ask({"id": 1, "command": "pictures", "models": models, "size": 32})
        for model in models:
            window.wait(lambda said, model=model: said.get("event") == "pictures" and model in said["models"])
        places = {"oak.obj": "1:68", "window.glb": "1:37"}
        assert session.call("state")[0]["warnings"] == [
            f'house.cga:{place}: warning: there is no asset "{name}" in the asset folder {tmp_path}; '
            "a box stands in its place [missing-asset]\n  hint: say where the meshes are with `assets=DIR`"
            for name, place in places.items()
        ]


def test_no_more_than_so_many_warnings_are_told(tmp_path: Path):
    rules = tmp_path / "house.cga"
    rules.write_text("Lot --> " + " ".join(f'i("{k}.obj")' for k in range(30)))
    with closing(Session(str(rules), tmp_path / "a.db", size=4, jobs=1)) as session:
        window = Window(session)
        window.ask({"id": 1, "command": "pictures", "models": shown_models(session.call("state")[0]), "size": 32})
        assert len(window.state(lambda state: state["warnings"])["warnings"]) == MAX_WARNINGS
