"""Which branches read an attribute: where none is taken, another value of it changes nothing."""

import numpy as np

from grammarlab.derivation.derive import derive
from grammarlab.features.patterns.counts import count
from grammarlab.language.grammar import Grammar
from grammarlab.tastes.attribute_readers import readers_of
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.choice_places import MAX_CHOICES

TEXT = """
attr low = rand(1, 2)
attr high = 2 * low
attr loop = rand(1, 2)
attr unread = rand(1, 2)
attr shadowed = rand(1, 2)
attr local = rand(1, 2)
attr asked = rand(0, 10)
attr passed = rand(1, 2)
twice(x) = 2 * x
tall = twice(high)
same(n) = case n <= 0: loop else: same(n - 1)
Lot --> extrude(3) A(1) A(2) B
A(shadowed) --> case asked > 5 : s('1, shadowed, '1) Box else : 50% : s('1, tall, '1) Box else : Box
B --> 40% : 50% : s('1, same(2), '1) Box else : s('1, low, '1) Box else : C
C --> s('1, local, '1) D(passed)
D(x) --> 50% : s('1, '1, x) Box else : NIL
"""


def test_the_branches_that_read_an_attribute_are_named():
    found = {name: {str(pattern) for pattern in readers} for name, readers in readers_of(Grammar.parse(TEXT)).items()}
    assert found == {
        "low": {"A:1.0", "B:0.1"},
        "high": {"A:1.0"},
        "loop": {"B:0.0"},
        "unread": set(),
        "shadowed": set(),
        "local": {"C:*"},
        "asked": {"A:*"},
        "passed": {"C:*"},
    }


def test_models_without_them_are_the_same_whatever_the_value():
    grammar = Grammar.parse(TEXT)
    forest = derive(grammar, 200, 1)
    for name in ("low", "high", "loop", "unread", "shadowed", "local", "passed"):
        value = "2 * low" if name == "high" else "rand(1, 2)"
        other = derive(Grammar.parse(TEXT.replace(f"attr {name} = {value}", f"attr {name} = 7 + {value}")), 200, 1)
        patterns = readers_of(grammar)[name]
        reads = count(forest, patterns).sum(axis=1) > 0.0
        changed = np.array([not same for same in map(_same, _sizes(forest), _sizes(other))])
        assert not changed[~reads].any()
        assert (name in ("unread", "shadowed")) or changed[reads].any()


def _sizes(forest):
    """Of each model the sizes of its leaves."""
    model = forest.nodes.model[forest.leaves.node]
    return [forest.leaves.size[model == number] for number in range(forest.num_models)]


def _same(one, other):
    return one.shape == other.shape and np.allclose(one, other)


def test_choices_outside_rules_are_as_many_as_those_at_places_at_most():
    attributes = "".join(f"attr a{number} = 50% : 1 else : 2\n" for number in range(MAX_CHOICES + 9))
    grammar = Grammar.parse(f"{attributes}Lot --> A")
    elements = Elements.of([derive(grammar, 9, 1)])
    assert len(elements.outcomes) == MAX_CHOICES
