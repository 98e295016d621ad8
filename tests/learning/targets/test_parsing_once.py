"""A learner parses no rule file twice."""

from __future__ import annotations

from collections import Counter

import grammarlab as gl
from grammarlab.language import grammar as grammars
from tests.cases import takes_turns

TOWERS = """
Lot --> Tower Tower
Tower --> 50% : extrude(3) Low else : extrude(9) High
Low --> 50% : Brick 30% : Glass else : Steel
High --> 50% : Brick 30% : Glass else : Steel
"""


@takes_turns
def test_no_text_is_parsed_twice_while_a_grammar_is_learned(monkeypatch):
    parsed, parse = Counter[str](), grammars.parse

    def counted(text, file):
        parsed[text] += 1
        return parse(text, file)

    grammar = gl.Grammar.parse(TOWERS)
    pattern = gl.pattern("High > Brick@0")
    monkeypatch.setattr(grammars, "parse", counted)
    learned = gl.learn(grammar, lambda forest: 50.0 * gl.count(forest, [pattern])[:, 0], budget=16).learned
    assert learned.rules_after > 0
    assert parsed
    assert set(parsed.values()) == {1}
