"""Splits of a cell by their posterior, looking one step ahead.

Some splits gain only together with a second one: of "either but not both", of "both of the same style", or of several
conditions of which one alone leaves liked and disliked designs mixed. Looking ahead, a split is worth the evidence of
its parts after the best second split of each part, with the price of these splits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.cells.splits import Splits, different
from grammarlab.preference.likelihood import Singles

Evidence: TypeAlias = Callable[[Singles], Floats]
"""[k] log-evidence of parts from the sums [k, W] of what their labels tell; an empty part has 0."""

_LIKELY, _GAINING = 120, 60
"""Numbers of splits into two that are combined: those with the largest prior mass, after those that gain most alone."""
MANY = 160
"""Number of labels above which a less careful search is enough: a third of its splits, trees and rounds is left out."""
_MANY_WAYS = 8
"""Number of splits into more parts of either kind whose parts are divided once more."""


class Ranked(NamedTuple):
    """Splits of a cell, without duplicates."""

    log_posterior: Floats
    """[K] log of prior mass and evidence of the parts."""
    log_mass: Floats
    """[K] log of the prior mass."""
    member: Ints
    """[J] index into the splits of all labels: first `Splits.halves`, then `Splits.many`."""
    of: Ints
    """[J] index of each among the K."""


def rank(splits: Splits, cell: Ints, told: Singles, evidence: Evidence, *, ahead: bool) -> Ranked | None:
    """Splits of a cell; None if there are none.

    Args:
        splits: splits of all labels.
        cell: [c] indices of labels.
        told: [c, W] what the labels tell.
        evidence: evidence of parts of the cell.
        ahead: whether to look one step ahead.
    """
    halves = splits.halves.take(cell, axis=1)
    # The side of the first label does not matter.
    halves ^= halves[:, :1].copy()
    in_two = np.flatnonzero(halves.any(axis=1))
    halves = halves[in_two]
    first, of = different(halves)
    inside = halves[first].astype(np.float32)
    log_mass = [np.log(np.bincount(of, np.exp(splits.log_mass[in_two])))]
    found, member, index = [_divided(inside, told, evidence)], [in_two], [of]
    parts: list[Singles] = []
    if len(splits.many):
        members = splits.members[:, cell]
        occupied = np.add.reduceat(members.any(axis=1).astype(np.int64), splits.starts)
        several = np.flatnonzero(occupied > 1)
        found.append(np.add.reduceat(evidence(members @ told), splits.starts)[several])
        log_mass.append(splits.log_prior[splits.many[several]])
        member.append(len(splits.halves) + several)
        index.append(len(first) + np.arange(len(several)))
        ends = np.append(splits.starts[1:], len(members))
        parts = [members[splits.starts[split] : ends[split]] for split in several.tolist()]
    mass = np.concatenate(log_mass)
    if not len(mass):
        return None
    posterior = np.concatenate(found) + mass
    if ahead and len(inside):
        posterior = np.maximum(posterior, mass + _after_two(inside, parts, mass, posterior, told, evidence))
    return Ranked(posterior, mass, np.concatenate(member), np.concatenate(index))


def _divided(inside: Singles, told: Singles, evidence: Evidence) -> Floats:
    """[k] total evidence of both halves of labels [k, c]."""
    sums = inside @ told
    return evidence(np.concatenate([sums, told.sum(axis=0) - sums])).reshape(2, -1).sum(axis=0)


def _after_two(
    inside: Singles, parts: list[Singles], mass: Floats, posterior: Floats, told: Singles, evidence: Evidence
) -> Floats:
    """[K] evidence of the parts of splits, each divided once more where this gains; minus infinity if not tried.

    Args:
        inside: [k, c] halves of the cell.
        parts: the parts of each of K - k further splits, as members [parts, c].
        mass: [K] log of the prior mass of all splits.
        posterior: [K] their log-posterior alone.
        told: [c, W] what the labels tell.
        evidence: evidence of parts of the cell.
    """
    best, number = np.full(len(mass), -np.inf), len(inside)
    likely, gaining = (num if len(told) <= MANY else num - num // 3 for num in (_LIKELY, _GAINING))
    # Of equal masses, those that gain more alone come first.
    by_mass = np.lexsort((-posterior[:number], -mass[:number]))
    first = _highest(posterior[:number], gaining)
    tried = np.union1d(first, by_mass[~np.isin(by_mass, first)][:likely])
    seconds, price = inside[tried], mass[tried]
    best[tried] = _halves_divided(seconds, price, told, evidence)
    for split in np.union1d(_highest(mass[number:], _MANY_WAYS), _highest(posterior[number:], _MANY_WAYS)).tolist():
        own = [told * part[:, None] for part in parts[split] if part.any()]
        left = evidence(np.array([each.sum(axis=0) for each in own]))
        divided = [float((_divided(seconds, each, evidence) + price).max()) for each in own]
        best[number + split] = np.maximum(left, divided).sum()
    return best


def _highest(values: Floats, num: int) -> Ints:
    return np.argsort(-values, kind="stable")[:num]


def _halves_divided(inside: Singles, price: Floats, told: Singles, evidence: Evidence) -> Floats:
    """[t] evidence of both halves of splits [t, c], each left or divided by the best of the splits at its price [t]."""
    sums, total = inside @ told, told.sum(axis=0)
    one, other = evidence(sums), evidence(total - sums)
    for place, half in enumerate(inside):
        # Two splits make the same quarters in either order.
        both, second = inside[place:] @ (told * half[:, None]), sums[place:]
        quarters = (both, sums[place] - both, second - both, total - second - sums[place] + both)
        a, b, c, d = evidence(np.concatenate(quarters)).reshape(4, -1)
        one[place] = max(one[place], float((a + b + price[place:]).max()))
        other[place] = max(other[place], float((c + d + price[place:]).max()))
        one[place:] = np.maximum(one[place:], a + c + price[place])
        other[place:] = np.maximum(other[place:], b + d + price[place])
    return one + other
