"""`count` for people: features may be texts, and names that a grammar lacks are errors instead of zeros."""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError, check_type
from grammarlab.features.counting import counts
from grammarlab.features.counting.counts import Floats
from grammarlab.features.counting.trees import Trees
from grammarlab.features.patterns.checking import check
from grammarlab.features.patterns.pattern import Feature
from grammarlab.features.patterns.text import parse


def count(forest: Forest | Trees, features: Sequence[Feature | str]) -> Floats:
    """The values [models, F] of features.

    Args:
        forest: the models; `Trees` caches intermediate results for further calls.
        features: the features; a text is that of a pattern. A symbol that the grammar has but no model contains is
            counted 0 times.

    Raises:
        UsageError: If a feature is of another type, or the grammar lacks its symbol, branch or random expression; it
            names the nearest. Also if the columns of the forest are not trees.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> 50% : A else : B B"), 3, seed=1)
    >>> gl.count(forest, ["A", gl.pattern("Lot > B")]).tolist()
    [[1.0, 0.0], [0.0, 2.0], [0.0, 2.0]]
    """
    parsed = _parsed(features)
    if not isinstance(forest, Trees):
        check_type("forest", forest, Forest, "gl.derive(grammar, 100, seed=1)")
        forest = Trees(forest)
    check(parsed, forest.forest.symbols, forest.forest.rules, forest.forest.sites)
    return counts.count(forest, parsed)


def _parsed(features: object) -> list[Feature]:
    if isinstance(features, str | Feature) or not isinstance(features, Sequence):
        found = repr(features)[:60] if isinstance(features, str) else type(features).__name__
        raise UsageError(f'features: expected a list such as ["Porch", gl.pattern("Porch > Post")], found {found}.')
    for number, feature in enumerate(features):
        if not isinstance(feature, str | Feature):
            raise UsageError(
                f'features[{number}]: expected a pattern such as gl.pattern("Porch"), or its text, '
                f"found {type(feature).__name__}."
            )
    return [parse(feature) if isinstance(feature, str) else feature for feature in features]
