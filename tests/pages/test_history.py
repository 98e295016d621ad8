"""Undo and redo."""

from hypothesis import given
from hypothesis import strategies as st

from grammarlab.pages.desk import MAX_STEPS, History
from grammarlab.pages.editor.document import opened
from tests.facade.samples import windows

FIRST = opened(windows(1, 2))


@given(st.lists(st.sampled_from(["do", "undo", "redo"]), max_size=40))
def test_history_does_what_a_list_with_a_place_in_it_does(steps: list[str]):
    history, states, place = History(FIRST), [FIRST], 0
    for number, step in enumerate(steps):
        if step == "do":
            states, place = [*states[: place + 1], opened(FIRST.facade)], place + 1
            history.do(str(number), states[-1])
        elif step == "undo":
            assert bool(history.undo()) == (place > 0)
            place = max(place - 1, 0)
        else:
            assert bool(history.redo()) == (place < len(states) - 1)
            place = min(place + 1, len(states) - 1)
        assert history.present is states[place]
        assert (len(history.past), len(history.future)) == (place, len(states) - 1 - place)


def test_only_so_many_steps_are_kept():
    history = History(FIRST)
    for number in range(MAX_STEPS + 10):
        history.do(str(number), opened(FIRST.facade))
    assert len(history.past) == MAX_STEPS
    assert history.undo() == str(MAX_STEPS + 9)
