"""The progress of learning, as a person sees it."""

import io
import re
import sys

import pytest

import grammarlab as gl
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.progress_line import shown_progress

GRAMMAR = gl.Grammar.parse("Lot --> 50% : extrude(3) Low else : extrude(9) High")


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def learn(**options):
    return gl.learn(
        GRAMMAR, lambda forest: gl.count(forest, ["High"])[:, 0] > 0, 16, pool=Pool(0, 200), **options
    ).learned.text


def test_a_function_hears_every_round_and_learning_does_not_depend_on_it(capsys):
    heard = []
    text = learn(progress=lambda *now: heard.append(now))
    assert [now for now in heard if now[0] == "scores"] == [("scores", done, 16) for done in (0, 8, 16)]
    assert heard[0][0].startswith("making ")
    assert heard[-1][0] == "writing the file"
    assert learn(progress=None) == learn() == text
    assert capsys.readouterr() == ("", "")


def test_a_terminal_shows_one_line_that_is_gone_at_the_end(monkeypatch):
    monkeypatch.setattr(sys, "stderr", stderr := Terminal())
    learn()
    lines = stderr.getvalue().split("\r\x1b[2K")
    assert lines[0] == lines[-1] == ""
    assert any(re.fullmatch(r"scores: 8/16 \|█{12} {12}\| \d+ s", line) for line in lines)
    assert "\n" not in stderr.getvalue()


def test_the_line_is_gone_after_an_error(monkeypatch):
    monkeypatch.setattr(sys, "stderr", stderr := Terminal())
    with pytest.raises(gl.GrammarlabError, match="nothing is liked"):
        gl.learn(GRAMMAR, lambda forest: [0.0] * forest.num_models, 8)
    assert stderr.getvalue().endswith("\r\x1b[2K")


def test_what_is_no_function_is_refused():
    with pytest.raises(gl.GrammarlabError, match="expected 'auto', None or a function such as print, found 3"):
        learn(progress=3)
    with shown_progress(print) as progress:
        assert progress is print
