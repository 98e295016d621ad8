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
from grammarlab.preference.base import MANY_LABELS
from grammarlab.preference.cells.splits import Splits, different
from grammarlab.preference.person import Singles

Evidence: TypeAlias = Callable[[Singles], Floats]
"""[k] log-evidence of parts from the sums [k, W] of the terms of their labels; an empty part has 0."""

_NUM_LIKELY, _NUM_GAINING = 120, 60
"""Numbers of splits into two that are combined: those with the largest prior mass, after those that gain most alone."""
_NUM_MULTIWAY = 8
"""Number of splits into more parts of either kind whose parts are divided once more."""


class Ranked(NamedTuple):
    """Splits of a cell, without duplicates."""

    log_posterior: Floats
    """[K] log of prior mass and evidence of the parts."""
    log_mass: Floats
    """[K] log of the prior mass."""
    member: Ints
    """[J] index into the splits of all labels: first `Splits.halves`, then `Splits.many`."""
    group: Ints
    """[J] index of the split among the K different ones."""


def rank(splits: Splits, cell: Ints, terms: Singles, evidence: Evidence, *, ahead: bool) -> Ranked | None:
    """Splits of a cell; None if there are none.

    Args:
        splits: splits of all labels.
        cell: [c] indices of labels.
        terms: [c, W] terms of the labels, whose sums give the evidence of a part.
        evidence: evidence of parts of the cell.
        ahead: whether to look one step ahead.
    """
    halves = splits.halves.take(cell, axis=1)
    # The side of the first label does not matter.
    halves ^= halves[:, :1].copy()
    in_two = np.flatnonzero(halves.any(axis=1))
    halves = halves[in_two]
    first, group = different(halves)
    inside = halves[first].astype(np.float32)
    log_mass = [np.log(np.bincount(group, np.exp(splits.log_mass[in_two])))]
    log_evidence, member, index = [_divided(inside, terms, evidence)], [in_two], [group]
    parts: list[Singles] = []
    if len(splits.many):
        members = splits.members[:, cell]
        occupied = np.add.reduceat(members.any(axis=1).astype(np.int64), splits.starts)
        several = np.flatnonzero(occupied > 1)
        log_evidence.append(np.add.reduceat(evidence(members @ terms), splits.starts)[several])
        log_mass.append(splits.log_prior[splits.many[several]])
        member.append(len(splits.halves) + several)
        index.append(len(first) + np.arange(len(several)))
        ends = np.append(splits.starts[1:], len(members))
        parts = [members[splits.starts[split] : ends[split]] for split in several.tolist()]
    mass = np.concatenate(log_mass)
    if not len(mass):
        return None
    posterior = np.concatenate(log_evidence) + mass
    if ahead and len(inside):
        posterior = np.maximum(posterior, mass + _after_two(inside, parts, mass, posterior, terms, evidence))
    return Ranked(posterior, mass, np.concatenate(member), np.concatenate(index))


def _divided(inside: Singles, terms: Singles, evidence: Evidence) -> Floats:
    """[k] total evidence of both halves of labels [k, c]."""
    sums = inside @ terms
    return evidence(np.concatenate([sums, terms.sum(axis=0) - sums])).reshape(2, -1).sum(axis=0)


def _after_two(
    inside: Singles, parts: list[Singles], mass: Floats, posterior: Floats, terms: Singles, evidence: Evidence
) -> Floats:
    """[K] evidence of the parts of splits, each divided once more where this gains; minus infinity if not examined.

    Args:
        inside: [k, c] halves of the cell.
        parts: the parts of each of K - k further splits, as members [parts, c].
        mass: [K] log of the prior mass of all splits.
        posterior: [K] their log-posterior alone.
        terms: [c, W] terms of the labels, whose sums give the evidence of a part.
        evidence: evidence of parts of the cell.
    """
    best, number = np.full(len(mass), -np.inf), len(inside)
    likely, gaining = (num if len(terms) <= MANY_LABELS else num - num // 3 for num in (_NUM_LIKELY, _NUM_GAINING))
    # Of equal masses, those that gain more alone come first.
    by_mass = np.lexsort((-posterior[:number], -mass[:number]))
    first = _highest(posterior[:number], gaining)
    selected = np.union1d(first, by_mass[~np.isin(by_mass, first)][:likely])
    seconds, price = inside[selected], mass[selected]
    best[selected] = _halves_divided(seconds, price, terms, evidence)
    for split in np.union1d(
        _highest(mass[number:], _NUM_MULTIWAY), _highest(posterior[number:], _NUM_MULTIWAY)
    ).tolist():
        part_terms = [terms * part[:, None] for part in parts[split] if part.any()]
        undivided = evidence(np.array([member_terms.sum(axis=0) for member_terms in part_terms]))
        divided = [float((_divided(seconds, member_terms, evidence) + price).max()) for member_terms in part_terms]
        best[number + split] = np.maximum(undivided, divided).sum()
    return best


def _highest(values: Floats, num: int) -> Ints:
    return np.argsort(-values, kind="stable")[:num]


def _halves_divided(inside: Singles, price: Floats, terms: Singles, evidence: Evidence) -> Floats:
    """[t] evidence of both halves of splits [t, c], each left or divided by the best of the splits at its price [t]."""
    sums, total = inside @ terms, terms.sum(axis=0)
    inner, outer = evidence(sums), evidence(total - sums)
    for index, half in enumerate(inside):
        # Two splits make the same quarters in either order.
        both, second = inside[index:] @ (terms * half[:, None]), sums[index:]
        quarters = (both, sums[index] - both, second - both, total - second - sums[index] + both)
        a, b, c, d = evidence(np.concatenate(quarters)).reshape(4, -1)
        inner[index] = max(inner[index], float((a + b + price[index:]).max()))
        outer[index] = max(outer[index], float((c + d + price[index:]).max()))
        inner[index:] = np.maximum(inner[index:], a + c + price[index])
        outer[index:] = np.maximum(outer[index:], b + d + price[index])
    return inner + outer
