"""Equalities of choices in words: ``same choice at Tower > Block@0 and Tower > Block@1``."""

from __future__ import annotations

from dataclasses import replace

from grammarlab.features.patterns.pattern import Below, Pattern, Total


def equality(total: Total) -> str:
    """What a total says that counts choices made alike; empty for other totals.

    >>> from grammarlab.features.patterns.text import parse
    >>> equality(Total(((parse("Tower[Block@0:0, Block@1:0]"), 1), (parse("Tower[Block@0:1, Block@1:1]"), 1))))
    'same choice at Tower > Block@0 and Tower > Block@1'
    >>> equality(Total(((parse("*[Block > A:0 + Block > A:0]"), 1), (parse("*[Block > A:2 + Block > A:2]"), 1))))
    'adjacent Block with the same choice at A'
    >>> equality(Total(((parse("Tower:0"), 1), (parse("Tower:1"), 1))))
    ''
    """
    patterns = [feature for feature, weight in total.terms if isinstance(feature, Pattern) and weight == 1]
    bare = {_without_branch(pattern) for pattern in patterns}
    if len(patterns) < max(len(total.terms), 2) or len(bare) != 1:
        return ""
    pattern = bare.pop()
    match pattern.below:
        case (Below(run=(_,)) as one, Below(run=(_,)) as other):
            return f"same choice at {_place(pattern, one)} and {_place(pattern, other)}"
        case (Below(run=(one, other)),) if one == other:
            inner = f" at {one.below[0].run_text()}" if one.below else ""
            return f"adjacent {one.symbol or 'parts'} with the same choice{inner}"
        case _:
            return ""


def _without_branch(pattern: Pattern) -> Pattern:
    """A pattern without the branch of its lowest nodes."""
    below = tuple(replace(each, run=tuple(map(_without_branch, each.run))) for each in pattern.below)
    return replace(pattern, below=below, branch=pattern.branch if below else None)


def _place(top: Pattern, below: Below) -> str:
    return below.run_text() if below.deep else str(replace(top, below=(below,)))
