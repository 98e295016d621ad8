"""Strength of the prior of rows and columns, by likelihood."""

from __future__ import annotations

from itertools import product

from grammarlab.facade.templates.elements import Ints
from grammarlab.facade.templates.evidence.averaging import averaged
from grammarlab.facade.templates.evidence.kinds import Solution, find_kinds
from grammarlab.facade.templates.evidence.maps import Maps
from grammarlab.facade.templates.evidence.neighbours import Groups

STRENGTHS = (0.25, 1.0, 4.0, 16.0)
"""Values of kappa to try, in addition to no prior."""
_FEWEST = 2
"""Least number of groups with several elements for a prior."""


def find_kinds_with(maps: Maps, row: Ints, column: Ints) -> tuple[Solution, int]:
    """The kinds of shortest description, with the prior of rows or columns if it helps; and the number of trials.

    Args:
        maps: evidence maps of N elements.
        row: [N] row of the facade, -1 for none.
        column: [N] column of the facade, -1 for none.
    """
    best = plain = find_kinds(maps)
    sides = [index for index in (row, column) if _grouped(index)]
    priors: list[tuple[Groups, ...]] = [(Groups(index, kappa),) for index, kappa in product(sides, STRENGTHS)]
    if len(sides) > 1:
        priors.append(tuple(Groups(index, STRENGTHS[2]) for index in sides))
    chosen: tuple[Groups, ...] = ()
    for groups in priors:
        found = find_kinds(maps, groups, plain.kinds)
        if found.length < best.length:
            best, chosen = found, groups
    return averaged(maps, chosen, best), 1 + len(priors)


def _grouped(index: Ints) -> bool:
    known = index[index >= 0].tolist()
    return sum(known.count(each) > 1 for each in set(known)) >= _FEWEST
