"""Any labels at all become a file that samples: contradictory, constant, adversarial, few and many."""

import os
import random

import numpy as np
import pytest

from grammarlab.density.exact.learned import num_alternatives
from grammarlab.density.sampler import GrammarSampler
from grammarlab.errors import UsageError
from grammarlab.features.acceptance import Acceptance
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.pool import Pool
from grammarlab.runs.learn.from_labels import learn_from_labels
from grammarlab.runs.sample.checks import grammar_to_run
from grammarlab.runs.sample.shipped import find_rules, shipped_examples
from tests.cases import some
from tests.preference.labelling import label_models

EXAMPLES = int(os.environ.get("GRAMMARLAB_EXAMPLES", "4"))
"""How many of them; any number may be asked for."""
NUMBERS = (1, 2, 7, 60, 400)
SEED = 5


def random_grammar(random_source):
    """A grammar of a few rules with choices, conditions, draws and repeats."""
    names = [f"S{number}" for number in range(random_source.randint(1, 5))]
    lines = ["attr width = rand(2, 9)", "attr style = 30% : 1 else : 2", "@StartRule", "Lot --> s(width, 0, 8) S0"]
    for number, name in enumerate(names):
        after = names[number + 1 :] or ["Leaf"]
        ends = [
            f"extrude({random_source.randint(1, 9)}) {' '.join(random_source.choices(after, k=2))}",
            f"split(x) {{ 1.3 : {random_source.choice(after)} }}*",
            f"color(rand(1), 0, 0) {random_source.choice(after)}",
        ]
        first, second = random_source.sample(ends, 2)
        kind = random_source.randint(0, 2)
        head = (f"{random_source.randint(1, 99)}% : ", "case style == 1 : ", "case scope.sx > 4 : ")[kind]
        lines.append(f"{name} --> {head}{first} else : {second}")
    return "\n".join([*lines, "Leaf --> 50% : Red. else : Blue."])


def scores_of(kind, number, source):
    """Scores of models, which of these models are scored, and none of it makes sense."""
    models = np.arange(number)
    scores = {
        "constant": np.full(number, 37.0),
        "random": source.uniform(0.0, 100.0, number),
        "contradictory": np.where(np.arange(number) % 2, 100.0, 0.0),
        "adversarial": 100.0 * (source.integers(0, 2**31, number) * 2_654_435_761 % 97 < 3),
        "tiny": source.uniform(0.0, 1e-6, number),
    }[kind]
    if kind == "contradictory":
        models = models // 2
    if not scores.any():
        scores[0] = 1e-3
    return models, scores


KINDS = ("constant", "random", "contradictory", "adversarial", "tiny")


@pytest.mark.parametrize("example", some(range(EXAMPLES)))
def test_any_labels_of_any_grammar_become_a_file_that_samples(tmp_path, example):
    source = random.Random(example)
    name, assets = str(tmp_path / "house.cga"), None
    if example % 2:
        (tmp_path / "house.cga").write_text(random_grammar(source))
    else:
        name = source.choice([rules.name for rules in shipped_examples()])
        assets = find_rules(name).assets
    kind, number = KINDS[example % len(KINDS)], source.choice(NUMBERS)
    models, scores = scores_of(kind, number, np.random.default_rng(example))
    before = Grammar.parse(find_rules(name).text())
    labels = label_models(before.hash, SEED, models.tolist(), scores.tolist())
    found = learn_from_labels(name, labels, tmp_path / "new.cga", labels_from="labels.csv", pool=Pool(0, 300))
    text = (tmp_path / "new.cga").read_text()
    after = grammar_to_run(text, "new.cga")
    assert num_alternatives(after) <= 2 * num_alternatives(before)
    rate = found.learned.accept_rate
    assert (Acceptance.of(after.tree) is None) == (rate is None)
    assert rate is None or rate > 1e-3
    assert GrammarSampler(after, assets).sample(5, 1).num_models == 5


def test_scores_that_are_all_0_are_refused_in_words(tmp_path):
    grammar = Grammar.parse(find_rules("toy").text())
    labels = label_models(grammar.hash, SEED, range(9), [0.0] * 9)
    with pytest.raises(UsageError, match="all 9 scores of 'overall' are 0"):
        learn_from_labels("toy", labels, tmp_path / "new.cga", labels_from="labels.csv", pool=Pool(0, 300))
