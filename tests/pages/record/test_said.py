"""What was said is the same in events, in labels and in label files."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import Address, hashes_of
from grammarlab.pages.record.judgements import Judgement, as_label, checked_entry, compared, models_of, of_label
from grammarlab.pages.record.label_exchange import labels_of, scores_of
from grammarlab.preference.labels import Kind, Labels

GRAMMAR = "ab" * 32
HASHES = hashes_of(GRAMMAR)
ADDRESSES = st.builds(Address, st.booleans(), st.integers(0, 2**64 - 1), st.integers(0, 2**64 - 1)).map(str)
STARS = st.sampled_from([0.0, 25.0, 50.0, 75.0, 100.0])
ONE = st.one_of(
    st.builds(Judgement, st.floats(0, 100)),
    st.builds(Judgement, STARS, st.just("stars")),
    st.builds(Judgement, st.sampled_from([0.0, 100.0]), st.just("thumb")),
)
KINDS: st.SearchStrategy[Kind] = st.sampled_from(("rather", "tie"))
PAIRS = st.lists(ADDRESSES, min_size=2, max_size=2, unique=True)
ENTRIES = st.one_of(st.tuples(ADDRESSES, ONE), st.builds(compared, PAIRS, KINDS))


@given(entry=ENTRIES)
def test_an_entry_survives_events_and_labels(entry: tuple[str, Judgement]):
    subject, said = entry
    assert checked_entry(subject, json.loads(json.dumps(said.as_json()))) == entry
    label = as_label(subject, said, "roof", HASHES)
    assert (label.kind, label.factor) == (said.kind, "roof")
    assert of_label(label, HASHES) == entry


@given(scores=st.dictionaries(st.sampled_from(["overall", "a b"]), st.lists(ENTRIES, min_size=1).map(dict)))
def test_whole_sessions_survive_label_files(scores: dict[str, dict[str, Judgement]]):
    if scores:
        assert scores_of(labels_of(scores, GRAMMAR), GRAMMAR) == scores


@given(models=PAIRS)
def test_the_order_of_a_pair_says_which_model_is_preferred_and_nothing_else(models: list[str]):
    subject, first = compared(models, "rather")
    other, second = compared(models[::-1], "rather")
    assert subject == other
    assert {first.score, second.score} == {0.0, 100.0}
    assert compared(models, "tie") == compared(models[::-1], "tie")
    assert list(models_of([subject])) == sorted(models, key=Address.parse)
    for said, preferred in ((first, models[0]), (second, models[1])):
        label = as_label(subject, said, "overall", HASHES)
        assert str(Address.of(label, HASHES)) == preferred
        assert label.score == 100.0


@pytest.mark.parametrize(
    "said", [Judgement(0.0), Judgement(0.0, "stars"), Judgement(0.0, "thumb"), Judgement(50.0, "tie")]
)
def test_what_likes_nothing(said: Judgement):
    assert not said.is_positive
    assert Judgement(100.0, said.kind).is_positive != (said.kind == "tie")


def test_models_with_a_footprint_cannot_be_compared_in_a_session():
    subject, said = compared(["g1-1", "g1-2"], "rather")
    label = as_label(subject, said, "overall", HASHES)
    foreign = labels_of({"overall": {subject: said}}, GRAMMAR)
    assert scores_of(foreign, GRAMMAR) == {"overall": {subject: said}}
    for other, expected in (
        ('{"seed":1,"model":2,"footprint":"20x12"}', "footprint of their own"),
        (f'{{"seed":1,"model":2,"grammar":"{"0" * 64}"}}', "another grammar"),
    ):
        with pytest.raises(UsageError, match=expected):
            scores_of(Labels((replace(label, other=other),)), GRAMMAR)
