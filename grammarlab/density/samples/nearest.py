"""The best grammar for a wanted density: an exact one, or where there is none, one that comes near, with the reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from grammarlab.density.samples import sampled
from grammarlab.density.splits.learned import LearnedGrammar
from grammarlab.density.targets.ranges import with_ranges
from grammarlab.density.targets.target import Target
from grammarlab.density.targets.thinning import Progress, silent
from grammarlab.derivation.forest import Forest
from grammarlab.errors import InexactError

RANGES = (24, 16, 12, 8, 6, 4)
"""Into how many ranges a number is cut, the first number that is not too many."""

Header = Callable[[str], Sequence[str]]
"""Lines of a comment at the top of a file, for the name of a method."""


def compile_nearest(
    target: Target,
    forest: Forest,
    header: Header = lambda method: (),
    *,
    num_samples: int = sampled.NUM_SAMPLES,
    seed: int = 0,
    on_progress: Progress = silent,
) -> LearnedGrammar:
    """The exact grammar of a density; else, with a finding that says why, one of sub-ranges or one of samples.

    Args:
        target: the wanted density.
        forest: derivations of its grammar that show how often successors inside blocks occur.
        header: of the new file.
        num_samples: to learn from, where there is no exact grammar.
        seed: of these samples.
        on_progress: told about these samples.

    Raises:
        GrammarlabError: when the preference is 0 for every model.
    """
    try:
        return target.compiled(forest, header("compile"))
    except InexactError as error:
        reason = str(error)
    nearer = _with_ranges(target, forest, header("ranges"))
    if nearer is not None:
        return _explained(nearer, "numbers are drawn from ranges instead", reason)
    learned = sampled.learn(
        target, "tied", num_samples=num_samples, seed=seed, header=header("tied"), on_progress=on_progress
    )
    return _explained(learned, "one was learned from samples instead", reason)


def _with_ranges(target: Target, forest: Forest, header: Sequence[str]) -> LearnedGrammar | None:
    """The grammar of the narrowest sub-ranges that is not too large; None where no drawn number is in the way."""
    for number in RANGES:
        try:
            reads, preference = with_ranges(target.grammar, target.reads, target.preference, number)
            if preference is target.preference:
                return None
            learned = replace(target, reads=reads, preference=preference).compiled(forest, header)
        except InexactError:
            continue
        return replace(learned, method="ranges")
    return None


def _explained(learned: LearnedGrammar, what: str, reason: str) -> LearnedGrammar:
    return replace(learned, findings=(f"no exact grammar, so {what}: {reason}", *learned.findings))
