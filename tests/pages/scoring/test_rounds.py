"""Rounds of scoring, with everything that takes part in them but pictures."""

from __future__ import annotations

import math
from contextlib import closing
from pathlib import Path

import pytest

from grammarlab.errors import GrammarlabError
from grammarlab.learning.designs.addresses import Address
from grammarlab.pages.record.label_exchange import read_labels_or_session
from grammarlab.pages.scoring.learning import NUM_BEHIND
from grammarlab.pages.scoring.session import Session
from grammarlab.pages.windows import Message
from grammarlab.preference.label_files import read_labels
from tests.cases import takes_turns
from tests.pages.scoring.tower import kind_of
from tests.pages.scoring.windows import Window, shown_models
from tests.waiting import wait_until


def test_an_update_can_be_cancelled_and_scores_are_saved_meanwhile(session: Session):
    window = Window(session)
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:4], score=90)
    session.call("update")
    assert session.call("state")[0]["updating"]
    with pytest.raises(GrammarlabError, match="under way"):
        session.call("update")
    # The thread that answers is not the one that learns.
    assert session.call("score", models=models[:1], score=20)[0]["saved"]
    for order in ("score", "random", "shown"):
        session.call("sort", by=order)
    session.call("new_models", way="grammar")
    session.call("factor_create", name="roof")
    session.call("undo")
    assert session.call("state")[0]["updating"]
    session.call("cancel")
    state, _ = session.call("state")
    assert "cancelled" in state["message"]
    assert not state["chart"]
    window.forget()
    session.call("update")
    state = window.state(lambda state: state["fresh"] and not state["updating"])
    assert state["chart"][0]["labels"] == 4
    assert window.wait(lambda message: message.get("event") == "progress")[0]["of"] == "update"


def test_of_two_wishes_for_other_models_the_later_one_counts(session: Session):
    window = Window(session)
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:4], score=90)
    for way in ("uniform", "already ranked"):
        session.call("new_models", way=way)
    state = window.state(lambda state: state["way"] != "default" and not state["updating"])
    assert state["way"] == "already ranked"
    assert set(shown_models(state)) == set(models[:4])
    session.call("new_models", way="uniform")
    session.call("new_models", way="grammar")
    state, _ = session.call("state")
    assert (state["way"], state["updating"]) == ("grammar", None)
    session.call("sort", by="random")
    assert not state["message"]


def test_models_stay_where_the_person_went_on_during_an_update(session: Session):
    window = Window(session)
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:4], score=90)
    session.call("update")
    session.call("score", models=models[4:5], score=0)
    state = window.state(lambda state: not state["updating"] and state["chart"])
    assert shown_models(state) == models
    assert not state["fresh"]
    assert "predictions are updated" in state["message"]


def test_enough_new_scores_are_learned_from_behind_the_person(session: Session):
    window = Window(session)
    models = shown_models(session.call("state")[0])
    with pytest.raises(GrammarlabError, match="nothing has been learned yet"):
        session.call("new_models", way="liked")
    session.post(session.desk.learning.prepare)
    for model in models[:NUM_BEHIND]:
        window.forget()
        session.post(session.desk.learning.learn_behind)
        session.call("score", models=[model], score=100 if kind_of(model) == "Flat" else 0)
    wait_until(lambda: session.desk.display.knowledge.features)
    session.post(session.desk.learning.learn_behind)
    state = window.state(lambda state: state["fresh"])
    # Nothing on the page but the predictions is another one.
    assert (shown_models(state), state["chart"], state["updating"], state["message"]) == (models, [], None, None)
    assert state["recent"] == models[:NUM_BEHIND][::-1]
    assert all(known["mean"] is not None for known in state["models"].values())
    # More of them come below what is shown, without a wait; new ones are those in line.
    line = state["line"]
    assert line
    assert not set(line) & set(models)
    session.call("more")
    state, _ = session.call("state")
    assert [grid["models"][:16] for grid in state["grids"]] == [models[:16], models[16:]]
    assert set(line) <= set(shown_models(state)) - set(models)
    assert (state["updating"], [point["labels"] for point in state["chart"]]) == (None, [NUM_BEHIND])
    line = state["line"]
    session.call("new_models", way="default")
    state, _ = session.call("state")
    assert (state["updating"], shown_models(state)[: len(line)]) == (None, line)
    session.call("new_models", way="scored")
    state, _ = session.call("state")
    assert shown_models(state) == state["recent"]
    session.call("more")
    assert "all models of this kind" in session.call("state")[0]["message"]
    session.call("new_models", way="liked")
    state, _ = session.call("state")
    means = [state["models"][model]["mean"] for model in shown_models(state)]
    assert means == sorted(means, reverse=True)
    assert kind_of(shown_models(state)[0]) == "Flat"


@takes_turns
def test_imported_models_that_are_not_of_the_pool_are_shown_predicted_and_sorted(
    session: Session, tmp_path: Path, rules: str
):
    with closing(Session(rules, tmp_path / "elsewhere.db", seed=4, size=200, jobs=0)) as other:
        elsewhere = shown_models(other.call("state")[0])
        for model in elsewhere:
            other.call("score", models=[model], score=100 if kind_of(model) == "Flat" else 0)
        _, file = other.call("export", format="csv")
    window = Window(session)
    assert session.call("import", file, format="csv")[0] == {"added": 32}
    session.call("new_models", way="already ranked")
    state = window.state(lambda state: state["way"] == "already ranked" and not state["updating"])
    assert set(shown_models(state)) == set(elsewhere)
    seed = Address.parse(elsewhere[0]).seed
    assert all(known["label"].endswith(f" of seed {seed}") for known in state["models"].values())
    window.forget()
    session.call("update")
    state = window.state(lambda state: state["fresh"] and not state["updating"])
    assert set(shown_models(state)) == set(elsewhere)
    for model, known in state["models"].items():
        assert known["score"] == (100 if kind_of(model) == "Flat" else 0)
        assert known["mean"] == pytest.approx(known["score"], abs=15)
    session.call("sort", by="uncertainty")
    state, _ = session.call("state")
    deviations = [known["std"] for known in map(state["models"].get, state["grids"][0]["models"]) if known]
    assert deviations == sorted(deviations, reverse=True)
    liked = state["grids"][0]["models"][5]
    session.call("sort", by="similarity", models=[liked])
    assert kind_of(session.call("state")[0]["grids"][0]["models"][0]) == kind_of(liked)


@takes_turns
def test_predictions_stay_with_a_factor_that_is_called_otherwise_and_go_to_no_other(session: Session):
    window = Window(session)
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:16], score=90)
    session.call("update")
    before = window.state(lambda state: state["fresh"] and not state["updating"])
    session.call("factor_rename", name="overall", to="style")
    session.call("sort", by="uncertainty")
    after, _ = session.call("state")
    assert {model: known["mean"] for model, known in after["models"].items()} == {
        model: known["mean"] for model, known in before["models"].items()
    }
    session.call("factor_create", name="overall")
    session.call("sort", by="score")
    after, _ = session.call("state")
    assert {known["mean"] for known in after["models"].values()} == {None}
    assert not after["relevance"]


def test_what_was_learned_is_there_again_after_a_restart(session: Session, tmp_path: Path, rules: str):
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:16], score=90)
    session.call("update")
    before = Window(session).state(lambda state: state["fresh"] and not state["updating"])
    session.close()
    with closing(Session(rules, tmp_path / "towers.db", jobs=1)) as again:
        window = Window(again)
        again.handle({"id": 1, "command": "pictures", "models": models[:1], "size": 32}, (), window.send)
        state = window.state(lambda state: state["fresh"])
        known = [state["models"][model]["mean"] for model in shown_models(state)]
        assert known == pytest.approx([before["models"][model]["mean"] for model in shown_models(before)], abs=1.0)
        assert shown_models(state) == shown_models(before)
        # What is learned again from the same scores is no change.
        again.call("new_models", way="default")
        state, _ = again.call("state")
        assert shown_models(state) != shown_models(before)
        assert state["chart"] == before["chart"]
        assert len(state["chart"]) == 1


@takes_turns
def test_rounds_of_scoring_move_the_density_less_and_less(session: Session, tmp_path: Path):
    """The simplest person: likes flat models."""
    liked = {"Flat"}
    window = Window(session)
    state, _ = session.call("state")
    for _ in range(3):
        window.forget()
        for model in shown_models(state):
            session.call("score", models=[model], score=100 if kind_of(model) in liked else 0)
        session.call("update")
        state = window.state(lambda state: state["fresh"] and not state["updating"])
    assert [point["labels"] for point in state["chart"]] == [32, 64, 96]
    assert state["chart"][0]["js"] > 0.05 > state["chart"][-1]["js"]
    assert state["chart"][0]["js"] <= math.log(2)
    assert 1 <= len(state["relevance"]) <= 8
    assert state["relevance"][0]["level"] in ("strong", "medium")
    assert state["words"][0].startswith("Likes: ")
    assert 0.0 <= state["gain"] < 0.7
    for model, known in state["models"].items():
        expected = 100 if kind_of(model) in liked else 0
        assert abs(known["mean"] - expected) < 15
        assert known["std"] >= 0
        assert known["product"] == pytest.approx(max(known["mean"], 0.0), abs=0.02)
    features, _ = session.call("features", query="lot")
    assert features["features"]
    assert session.call("features", query="no such feature")[0] == {"features": []}
    session.call("sort", by="feature", feature=features["features"][0])
    session.call("sort", by="uncertainty")
    first = session.call("state")[0]["grids"][0]["models"]
    deviations = [session.call("state")[0]["models"][model]["std"] for model in first]
    assert deviations == sorted(deviations, reverse=True)
    session.call("sort", by="similarity", models=[first[3]])
    assert kind_of(session.call("state")[0]["grids"][0]["models"][0]) == kind_of(first[3])
    for way in ("default", "uniform", "density", "uncertainty", "already ranked"):
        window.forget()
        session.call("new_models", way=way)
        state = window.state(lambda state, way=way: state["way"] == way and not state["updating"])
        assert len(shown_models(state)) in (32, 96)
    window.forget()
    window.ask({"id": 1, "command": "learn"})
    stages = []

    def is_writing(message: Message) -> bool:
        stages.extend([message["stage"]] if message.get("of") == "learn" else [])
        return stages[-1:] == ["learning overall"]

    window.wait(is_writing)
    session.call("cancel", of="result")
    assert "cancelled" in window.wait(lambda message: message.get("id") == 1)[0]["error"]
    assert len(set(stages)) >= 3
    assert not (tmp_path / "towers-learned.cga").exists()
    result, _ = session.call("learn")
    assert result["file"] == "towers-learned.cga"
    assert (tmp_path / result["file"]).read_text() == result["text"]
    assert result["js"] < 0.02
    _, (picture,) = session.call("sheet", num=2)
    assert picture.startswith(b"\x89PNG")


def test_pairs_are_shown_answered_and_learned_from(session: Session):
    window = Window(session)
    session.call("new_models", way="pairs")
    state, _ = session.call("state")
    before = {frozenset(pair["models"]) for pair in state["pairs"]}
    assert len(before) == 8
    assert len(set(shown_models(state))) == 16
    said = []
    for pair in state["pairs"]:
        first, second = (kind_of(model) == "Flat" for model in pair["models"])
        said.append("alike" if first == second else "first" if first else "second")
        kind, order = "tie" if first == second else "rather", 1 if first >= second else -1
        assert session.call("compare", models=pair["models"][::order], kind=kind)[0]["saved"]
    assert len(set(said)) > 1
    assert [pair["said"] for pair in session.call("state")[0]["pairs"]] == said
    session.call("update")
    state = window.state(lambda state: state["fresh"] and not state["updating"])
    assert (state["way"], state["scored"], state["compared"], state["factors"][0]["labels"]) == ("pairs", 0, 8, 8)
    assert state["chart"][0]["labels"] == 8
    assert [pair["said"] for pair in state["pairs"]] == [None] * 8
    pairs = {frozenset(pair["models"]) for pair in state["pairs"]}
    assert not before & pairs
    # Those that are shown are not in line again.
    line = window.state(lambda state: state["line"])["line"]
    assert not pairs & set(map(frozenset, zip(line[::2], line[1::2], strict=True)))
    with pytest.raises(GrammarlabError, match="one after the other"):
        session.call("sort", by="random")
    session.call("layout", grids=1, rows=2, columns=2)
    assert session.call("state")[0]["pairs"] == state["pairs"]
    session.call("new_models", way="grammar")
    state, _ = session.call("state")
    assert (state["pairs"], len(shown_models(state))) == (None, 4)


def test_pairs_belong_to_the_active_factor(session: Session):
    session.call("factor_create", name="roof")
    session.call("view", kind="product")
    session.call("new_models", way="pairs")
    pair = session.call("state")[0]["pairs"][0]["models"]
    with pytest.raises(GrammarlabError, match="the product of all factors"):
        session.call("compare", models=pair, kind="tie")
    session.call("compare", models=pair, kind="rather", factor="overall")
    assert session.call("state")[0]["pairs"][0]["said"] is None
    session.call("factor_activate", name="overall")
    assert session.call("state")[0]["pairs"][0]["said"] == "first"
    session.call("compare", models=pair[::-1], kind="rather", factor="overall", key="x")
    session.call("compare", models=pair, kind="tie", factor="overall", key="x")
    assert session.call("state")[0]["pairs"][0]["said"] == "second"
    session.call("undo")
    assert session.call("state")[0]["pairs"][0]["said"] == "first"
    session.call("compare", models=pair, kind=None, factor="overall")
    assert session.call("state")[0]["pairs"][0]["said"] is None


def test_all_kinds_go_out_and_come_back(session: Session, tmp_path: Path, rules: str):
    models = shown_models(session.call("state")[0])
    session.call("score", models=models[:2], score=75, kind="stars")
    session.call("score", models=models[2:3], score=0, kind="thumb")
    session.call("compare", models=models[:2], kind="rather")
    session.call("compare", models=[models[4], models[3]], kind="tie")
    state = session.call("state")[0]
    assert [(state["models"][model]["score"], state["models"][model]["kind"]) for model in models[1:4]] == [
        (75, "stars"),
        (0, "thumb"),
        (None, None),
    ]
    for suffix in ("csv", "jsonl", "parquet"):
        file = session.call("export", format=suffix)[1]
        with closing(Session(rules, tmp_path / f"{suffix}.db", jobs=0)) as other:
            assert other.call("import", buffers=file, format=suffix)[0] == {"added": 5}
            assert other.call("export", format=suffix)[1] == file
    (tmp_path / "again.csv").write_bytes(session.call("export", format="csv")[1][0])
    assert read_labels(tmp_path / "again.csv") == read_labels_or_session(tmp_path / "towers.db")[0]


@pytest.mark.parametrize("size", [1, 2, 9])
def test_of_few_models_there_are_few_pairs_or_none(tmp_path: Path, rules: str, size: int):
    with closing(Session(rules, tmp_path / "few.db", size=size, jobs=0)) as session:
        session.call("new_models", way="pairs")
        state, _ = session.call("state")
        assert (state["way"] == "pairs") == bool(state["pairs"])
        assert state["pairs"] or "no models to show" in state["message"]
        assert all(len(set(pair["models"])) == 2 for pair in state["pairs"] or [])
