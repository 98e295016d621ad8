"""Features by their texts, for people: what a grammar lacks is an error that names the nearest, not a zero."""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.arrays import Floats
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError, check_type
from grammarlab.features.expression import Expression
from grammarlab.features.patterns import counts, pattern_text
from grammarlab.features.patterns.pattern import Draw, Feature, Formula, Measure, Pattern
from grammarlab.features.patterns.pattern_checks import check
from grammarlab.features.patterns.tree_index import Trees

_OF_EXPRESSIONS = "${"
"""Characters that only expressions have."""
_OF_COMPARISONS = "<=!"
"""Characters that neither patterns nor names have, but comparisons that lack a ``$`` or braces."""


def pattern(text: str) -> Pattern | Draw | Formula:
    """Feature from a text: a pattern of derivation trees, a random draw, or an expression of both.

    Args:
        text: a pattern such as ``"Tower > Window"``; a draw such as ``"$height"``; or an expression with patterns in
            braces, such as ``"$height < 5"`` or ``"{Window} / {Wall}"``, which is 1 or 0 if it is a comparison.

    Raises:
        UsageError: If the text is none of these; it names the expected text and its place.

    >>> import grammarlab as gl
    >>> grammar = gl.Grammar.parse("attr h = rand(3, 9)  Lot --> extrude(h) split(y) { { 3 : Storey }* }")
    >>> forest = gl.derive(grammar, 3, seed=1)
    >>> gl.count(forest, [gl.pattern("Storey"), gl.pattern("$h < 5")]).tolist()
    [[2.0, 1.0], [3.0, 0.0], [3.0, 0.0]]
    """
    check_type("text", text, str, '"Tower > Window" or "$height < 5"')
    if not any(sign in text for sign in _OF_EXPRESSIONS):
        try:
            return pattern_text.parse(text)
        except UsageError as error:
            if not any(sign in text for sign in _OF_COMPARISONS):
                raise
            hint = "in an expression, draws begin with $ and patterns are in braces: $height < 5, {Window} == 2"
            raise UsageError(f"{error}\n  hint: {hint}") from None
    formula = Expression.parse(text).formula
    match formula.steps:
        case (Measure(Pattern() | Draw() as feature),):
            return feature
        case _:
            return formula


def count(forest: Forest | Trees, features: Sequence[Feature | str]) -> Floats:
    """The values [models, F] of features.

    Args:
        forest: the models; `Trees` caches intermediate results for further calls.
        features: the features; a text is that of `pattern`. A symbol that the grammar has but no model contains is
            counted 0 times.

    Raises:
        UsageError: If a feature is of another type, or the grammar lacks its symbol, branch or random expression; it
            names the nearest. Also if the columns of the forest are not trees.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> 50% : A else : B B"), 3, seed=1)
    >>> gl.count(forest, ["A", "Lot > B"]).tolist()
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
        description = repr(features)[:60] if isinstance(features, str) else type(features).__name__
        raise UsageError(f'features: expected a list such as ["Porch", "$height < 5"], found {description}.')
    for number, feature in enumerate(features):
        if not isinstance(feature, str | Feature):
            raise UsageError(
                f'features[{number}]: expected a pattern such as gl.pattern("Porch"), or its text, '
                f"found {type(feature).__name__}."
            )
    return [pattern(feature) if isinstance(feature, str) else feature for feature in features]
