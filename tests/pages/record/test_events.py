"""Events add up to what a naive model says, and a file gives the same again."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from grammarlab.errors import UsageError
from grammarlab.pages.record.events import Event, Record
from grammarlab.pages.record.judgements import Judgement, Scores
from grammarlab.pages.record.store import About, Store
from grammarlab.preference.labels import Kind

MODELS = [f"g5-{index}" for index in range(4)]
NAMES = ["overall", "height", "roof", "ä b"]
ABOUT = About("toy", "Lot --> extrude(3)", 5, 100)


class Naive:
    """Keeps the whole past."""

    def __init__(self) -> None:
        self.factors: dict[str, Scores] = {"overall": {}}
        self.past: list[dict[str, Scores]] = []
        self.future: list[dict[str, Scores]] = []

    def change(self, factors: dict[str, Scores]) -> None:
        self.past.append(self.factors)
        self.factors, self.future = factors, []

    def say(self, factor: str, said: Mapping[str, Judgement | None]) -> None:
        after = deepcopy(self.factors)
        for subject, value in said.items():
            after[factor].pop(subject, None)
            if value is not None:
                after[factor][subject] = value
        self.change(after)

    def undo(self) -> None:
        self.future.append(self.factors)
        self.factors = self.past.pop()

    def redo(self) -> None:
        self.past.append(self.factors)
        self.factors = self.future.pop()


class Sessions(RuleBasedStateMachine):
    """Two processes with one file open, beside the naive model."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.path = Path(self.folder.name, "s.db")
        self.stores = [Store.open(self.path, ABOUT), Store.open(self.path, ABOUT)]
        self.naive = Naive()

    def do(self, which: int, event: str, **body: Any) -> None:
        self.stores[which].append(event, body)

    @rule(
        which=st.integers(0, 1),
        factor=st.sampled_from(NAMES),
        models=st.lists(st.sampled_from(MODELS), min_size=1, unique=True),
        said=st.one_of(
            st.builds(Judgement, st.just(0.0)),
            st.builds(Judgement, st.integers(0, 100).map(float)),
            st.builds(Judgement, st.sampled_from([0.0, 25.0, 50.0, 75.0, 100.0]), st.just("stars")),
            st.builds(Judgement, st.sampled_from([0.0, 100.0]), st.just("thumb")),
            st.none(),
        ),
    )
    def score(self, which: int, factor: str, models: list[str], said: Judgement | None) -> None:
        body: dict[str, Any] = {"factor": factor, "models": models, "score": None}
        if said is not None:
            body |= {"score": said.score} | ({} if said.kind == "score" else {"kind": said.kind})
        if factor not in self.naive.factors:
            with pytest.raises(UsageError, match="no factor"):
                self.do(which, "score", **body)
            return
        self.do(which, "score", **body)
        self.naive.say(factor, dict.fromkeys(models, said))

    @rule(
        which=st.integers(0, 1),
        models=st.lists(st.sampled_from(MODELS), min_size=2, max_size=2, unique=True),
        kind=st.sampled_from(["rather", "tie", None]),
    )
    def compare(self, which: int, models: list[str], kind: Kind | None) -> None:
        factor = next(iter(self.naive.factors))
        self.do(which, "compare", factor=factor, models=models, kind=kind)
        score = 50.0 if kind == "tie" else 100.0 if models == sorted(models) else 0.0
        self.naive.say(factor, {" ".join(sorted(models)): Judgement(score, kind) if kind else None})

    @rule(
        which=st.integers(0, 1),
        factor=st.sampled_from(NAMES),
        scores=st.dictionaries(st.sampled_from(MODELS), st.floats(0, 100), min_size=1),
    )
    def read(self, which: int, factor: str, scores: dict[str, float]) -> None:
        self.do(which, "import", scores={factor: scores})
        after = deepcopy(self.naive.factors)
        after[factor] = after.get(factor, {}) | {model: Judgement(score) for model, score in scores.items()}
        self.naive.change(after)

    @rule(which=st.integers(0, 1), name=st.sampled_from(NAMES))
    def create(self, which: int, name: str) -> None:
        if name in self.naive.factors:
            with pytest.raises(UsageError, match="already"):
                self.do(which, "factor_create", name=name)
        else:
            self.do(which, "factor_create", name=name)
            self.naive.change({**deepcopy(self.naive.factors), name: {}})

    @rule(which=st.integers(0, 1), name=st.sampled_from(NAMES), to=st.sampled_from(NAMES))
    def rename(self, which: int, name: str, to: str) -> None:
        if name not in self.naive.factors or to in self.naive.factors:
            with pytest.raises(UsageError):
                self.do(which, "factor_rename", name=name, to=to)
        else:
            self.do(which, "factor_rename", name=name, to=to)
            renamed = {to if key == name else key: value for key, value in deepcopy(self.naive.factors).items()}
            self.naive.change(renamed)

    @rule(which=st.integers(0, 1), name=st.sampled_from(NAMES))
    def delete(self, which: int, name: str) -> None:
        if name not in self.naive.factors or len(self.naive.factors) == 1:
            with pytest.raises(UsageError):
                self.do(which, "factor_delete", name=name)
        else:
            self.do(which, "factor_delete", name=name)
            self.naive.change({key: value for key, value in deepcopy(self.naive.factors).items() if key != name})

    @rule(which=st.integers(0, 1))
    def undo(self, which: int) -> None:
        if self.naive.past:
            self.do(which, "undo")
            self.naive.undo()
        else:
            with pytest.raises(UsageError, match="nothing to undo"):
                self.do(which, "undo")

    @rule(which=st.integers(0, 1))
    def redo(self, which: int) -> None:
        if self.naive.future:
            self.do(which, "redo")
            self.naive.redo()
        else:
            with pytest.raises(UsageError, match="nothing to redo"):
                self.do(which, "redo")

    @rule(which=st.integers(0, 1), name=st.sampled_from(NAMES))
    def activate(self, which: int, name: str) -> None:
        if name in self.naive.factors:
            self.do(which, "factor_activate", name=name)
            assert self.stores[which].record.active == name

    @precondition(lambda self: self.stores[0].record.revision > 3)
    @rule(which=st.integers(0, 1))
    def reopen(self, which: int) -> None:
        before = self.stores[which]
        before.poll()
        self.stores[which] = Store.open(self.path)
        assert self.stores[which].record == before.record
        before.close()

    @invariant()
    def agree(self) -> None:
        for store in self.stores:
            store.poll()
            assert store.record.factors == self.naive.factors
            assert store.record.active in store.record.factors
            assert list(store.record.numbers) == list(store.record.factors)
            assert len(set(store.record.numbers.values())) == len(store.record.factors)
        assert self.stores[0].record == self.stores[1].record

    def teardown(self) -> None:
        for store in self.stores:
            store.close()
        self.folder.cleanup()


TestSessions = Sessions.TestCase
TestSessions.settings = settings(max_examples=20, stateful_step_count=25, deadline=None)


def added(*bodies: tuple[str, dict[str, Any]]) -> Record:
    record = Record()
    for number, (kind, body) in enumerate(bodies, 1):
        record.apply(Event(number, 0.0, kind, body))
    return record


def test_the_active_factor_comes_back_with_its_factor():
    deleted = added(("factor_create", {"name": "roof"}), ("factor_delete", {"name": "roof"}))
    assert deleted.active == "overall"
    deleted.apply(Event(3, 0.0, "undo", {}))
    assert deleted.active == "roof"


def test_a_factor_keeps_its_number_and_no_other_gets_it():
    record = added(
        ("factor_create", {"name": "roof"}),
        ("factor_rename", {"name": "roof", "to": "colour"}),
        ("factor_create", {"name": "roof"}),
        ("factor_delete", {"name": "colour"}),
        ("import", {"scores": {"wall": {"g1-1": 5}, "roof": {"g1-1": 5}, "door": {"g1-1": 5}}}),
    )
    assert record.numbers == {"overall": 1, "roof": 3, "wall": 4, "door": 5}
    for number in range(5):
        record.apply(Event(6 + number, 0.0, "undo", {}))
    assert record.numbers == {"overall": 1}
    record.apply(Event(11, 0.0, "redo", {}))
    record.apply(Event(12, 0.0, "redo", {}))
    assert record.numbers == {"overall": 1, "colour": 2}
    record.apply(Event(13, 0.0, "factor_create", {"name": "roof"}))
    assert record.numbers == {"overall": 1, "colour": 2, "roof": 6}


def test_undo_of_a_change_elsewhere_leaves_the_active_factor():
    record = added(
        ("factor_create", {"name": "roof"}),
        ("import", {"scores": {"overall": {"g1-1": 5}}}),
        ("factor_activate", {"name": "overall"}),
        ("undo", {}),
    )
    assert record.active == "overall"
    assert record.factors == {"overall": {}, "roof": {}}


@pytest.mark.parametrize(
    ("kind", "body", "expected"),
    [
        ("nonsense", {}, "unknown event 'nonsense'"),
        ("score", [], "expected an object"),
        ("score", {"factor": "overall", "models": [], "score": 5}, "at least one"),
        ("score", {"factor": "overall", "models": "g1-1", "score": 5}, "expected a list"),
        ("score", {"factor": "overall", "models": ["g1-1", "g1-1"], "score": 5}, "twice"),
        ("score", {"factor": "overall", "models": ["g1-01"], "score": 5}, "expected a model"),
        ("score", {"factor": "overall", "models": [f"g{1 << 64}-1"], "score": 5}, "expected a model"),
        ("score", {"factor": "overall", "models": [{}], "score": 5}, "expected a model"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": 101}, "from 0 to 100"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": True}, "from 0 to 100"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": float("nan")}, "from 0 to 100"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": 5, "key": 5}, "key"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": 5, "key": "x" * 61}, "key"),
        ("score", {"factor": "roof", "models": ["g1-1"], "score": 5}, "no factor 'roof'"),
        ("score", {"factor": {}, "models": ["g1-1"], "score": 5}, "no factor"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": 50, "kind": "thumb"}, "one of 0, 100 for"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": 30, "kind": "stars"}, "one of 0, 25, 50, 75, 100"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": 50, "kind": "tie"}, "kind: expected one of score"),
        ("score", {"factor": "overall", "models": ["g1-1"], "score": 50, "kind": []}, "kind: expected one of score"),
        ("score", {"factor": "overall", "models": ["g1-1 g1-2"], "score": 50}, "expected a model"),
        ("compare", {"factor": "overall", "models": ["g1-1"], "kind": "tie"}, "two different"),
        ("compare", {"factor": "overall", "models": ["g1-1", "g1-1"], "kind": "tie"}, "two different"),
        ("compare", {"factor": "overall", "models": ["g1-1", 5], "kind": "tie"}, "expected a model"),
        ("compare", {"factor": "overall", "models": "ab", "kind": "tie"}, "two different"),
        ("compare", {"factor": "overall", "models": ["g1-1", "g1-2"], "kind": "score"}, "kind: expected rather, tie"),
        ("compare", {"factor": "overall", "models": ["g1-1", "g1-2"], "kind": {}}, "kind: expected rather, tie"),
        ("compare", {"factor": "overall", "models": ["g1-1", "g1-2"], "kind": "tie", "key": 5}, "key"),
        ("compare", {"factor": "roof", "models": ["g1-1", "g1-2"], "kind": "tie"}, "no factor 'roof'"),
        ("import", {"scores": {"a": {"g1-1": ["stars", 30]}}}, "one of 0, 25, 50, 75, 100"),
        ("import", {"scores": {"a": {"g1-1": ["rather", 100]}}}, "kind: expected one of score"),
        ("import", {"scores": {"a": {"g1-1 g1-2": 100}}}, "expected a comparison"),
        ("import", {"scores": {"a": {"g1-1 g1-2": ["rather", 50]}}}, "expected a comparison"),
        ("import", {"scores": {"a": {"g1-2 g1-1": ["rather", 100]}}}, "expected a comparison"),
        ("import", {"scores": {"a": {"g1-1 g1-1": ["tie", 50]}}}, "two different"),
        ("import", {"scores": {"a": {"g1-1 g1-2 g1-3": ["tie", 50]}}}, "expected a model"),
        ("import", {"scores": {}}, "scores by factor"),
        ("import", {"scores": {"a": {"g1-1": None}}}, "from 0 to 100"),
        ("import", {"scores": {f"n{k}": {"g1-1": 1} for k in range(30)}}, "more than 24"),
        ("factor_create", {"name": " "}, "expected one line"),
        ("factor_create", {"name": "a\nb"}, "expected one line"),
        ("factor_create", {"name": "x" * 61}, "expected one line"),
        ("factor_delete", {"name": "overall"}, "another factor to remain"),
        ("view", {"kind": "all"}, "active or product"),
        ("layout", {"grids": 3, "rows": 1, "columns": 1}, "grids: expected a number from 1 to 2"),
        ("layout", {"grids": 1, "rows": 11, "columns": 1}, "rows"),
        ("layout", {"grids": 1, "rows": 1.0, "columns": 1}, "rows"),
        ("shown", {"way": "x", "grids": [{"title": 5, "models": []}]}, "a title and models"),
        ("shown", {"way": "x", "grids": [[]]}, "a title and models"),
        ("shown", {"way": "pairs", "grids": []}, "two of as many"),
        ("shown", {"way": "pairs", "grids": [{"title": "", "models": []}]}, "two of as many"),
        (
            "shown",
            {"way": "pairs", "grids": [{"title": "", "models": ["g1-1"]}, {"title": "", "models": []}]},
            "two of as",
        ),
        ("shown", {"way": "pairs", "grids": [{"title": "", "models": ["g1-1"]}] * 2}, "twice"),
        ("learned", {"labels": -1, "js": 0.1}, "expected a count"),
        ("learned", {"labels": 1, "js": 0.8}, "ln 2"),
        ("learned", {"labels": 1, "js": 0.1, "wide": 1}, "true or false"),
    ],
)
def test_what_cannot_have_happened_is_refused_and_changes_nothing(kind: str, body: Any, expected: str):
    record = Record()
    with pytest.raises(UsageError, match=expected):
        record.apply(Event(1, 0.0, kind, body))
    assert record == Record()


def test_the_product_is_not_looked_at_where_one_factor_is_left():
    record = Record()
    kinds: list[tuple[str, dict[str, Any]]] = [
        ("factor_create", {"name": "roof"}),
        ("view", {"kind": "product"}),
        ("factor_delete", {"name": "roof"}),
    ]
    for number, (kind, body) in enumerate(kinds, 1):
        record.apply(Event(number, 0.0, kind, body))
    assert record.view == "active"
