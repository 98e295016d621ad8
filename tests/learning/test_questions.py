"""Questions that narrow bounds on continuous draws."""

import numpy as np

from grammarlab.features.patterns.pattern import Draw, Threshold
from grammarlab.language.grammar import Grammar
from grammarlab.learning.answers import Answers
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.questions import ask
from grammarlab.learning.round import Study, init, step

BOXES = Grammar.parse("attr wide = rand(0, 1)\nattr deep = rand(0, 1)\nLot --> Box")
BOUND = 0.37


class Searching(GrammarSpace):
    """Models of which any search finds a relevant bound, and perhaps an irrelevant one."""

    found: tuple[Threshold, ...] = (Threshold("wide", BOUND),)

    def search(self, designs, scores, features):
        return self.found


class Misled(Searching):
    found = (Threshold("wide", BOUND), Threshold("deep", 0.5))


def test_no_question_narrows_a_bound_that_does_not_matter():
    narrowing = []
    for kind in (Searching, Misled):
        space = kind(BOXES)
        study = Study(space, Pool(0, 1000))
        designs = tuple(study.pool)
        wide, deep = space.values([space.make(designs[:1000])], (Draw("wide"), Draw("deep"))).T
        some = np.flatnonzero((np.abs(wide - BOUND) > 0.1) & (np.abs(deep - 0.5) > 0.3))[:40]
        answers = Answers("overall", tuple(designs[i] for i in some), np.where(wide[some] < BOUND, 80.0, 0.0))
        asked = ask(study, step(study, init(study), [answers]), 16, 0, factor="overall")
        narrowing.append(asked[8:])
    assert narrowing[0] == narrowing[1]
    assert (np.abs(wide[[designs.index(design) for design in narrowing[0]]] - BOUND) < 0.1).all()
