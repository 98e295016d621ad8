"""Questions about bounds: where a taste turns from liked to disliked is what is not known yet."""

import numpy as np

from grammarlab.features.patterns.pattern import Draw
from grammarlab.language.grammar import Grammar
from grammarlab.learning.answers import Answers
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.questions import ask
from grammarlab.learning.round import Study, init, step

BOXES = Grammar.parse("attr wide = rand(0, 1)\nattr deep = rand(0, 1)\nLot --> Box")
BOUND = 0.37


def test_most_questions_narrow_a_bound_between_scored_designs():
    space = GrammarSpace(BOXES)
    study = Study(space, Pool(0, 1000))
    designs = tuple(study.pool)
    (wide,) = space.values([space.make(designs[:1000])], (Draw("wide"),)).T
    some = np.flatnonzero(np.abs(wide - BOUND) > 0.1)[:40]
    answers = Answers("overall", tuple(designs[i] for i in some), np.where(wide[some] < BOUND, 80.0, 0.0))
    asked = ask(study, step(study, init(study), [answers]), 16, 0, factor="overall")
    between = np.abs(wide[[designs.index(design) for design in asked]] - BOUND) < 0.1
    # By chance a fifth would be.
    assert between.mean() >= 0.5
