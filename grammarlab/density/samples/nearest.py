"""Best grammar for a target density: an exact one, or otherwise a near one with the reason."""

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
"""Candidate numbers of ranges of a drawn number; the first one that is not too large is used."""

Header = Callable[[str], Sequence[str]]
"""Function from the name of a method to the comment lines at the top of a file."""


def compile_nearest(
    target: Target,
    forest: Forest,
    header: Header = lambda method: (),
    *,
    num_samples: int = sampled.NUM_SAMPLES,
    seed: int = 0,
    on_progress: Progress = silent,
) -> LearnedGrammar:
    """Exact grammar of a density; otherwise one of sub-ranges or from samples, with a finding that states the reason.

    Args:
        target: the target density.
        forest: derivations of its grammar that show how often successors inside blocks occur.
        header: header of the new file.
        num_samples: number of samples if there is no exact grammar.
        seed: seed of these samples.
        on_progress: called with the progress of these samples.

    Raises:
        GrammarlabError: If the preference is 0 for every model.
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
    """Grammar of the narrowest sub-ranges that is not too large; None if drawn numbers are not the reason."""
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
