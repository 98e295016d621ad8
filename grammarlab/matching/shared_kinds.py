"""Kinds that refer to shared widths and heights, found by description length.

Minimised over K kinds that refer to A widths and B heights is
-sum_i log[.98 sum_k pi_ik M_i(W_a(k), H_b(k)) + .02] + K/2 log n + 1.5 log n (A + B)
by adding the best kind, EM, and then moving, merging and deleting kinds and values while that shortens the description.

Rows and columns of a facade are a prior, since elements of one row are often of one kind: pi_ik is proportional to
pi_k prod_g (n_gk + kappa_g pi_k) / ((n_g + kappa_g) pi_k), where n_gk is the number of the other elements of group g
that are of kind k; kappa is large for groups without information.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.matching.evidence_maps import Maps

_UNKNOWN_SHARE = 0.02
"""Fraction of elements without a kind."""
VALUE_COST = 1.5
"""Cost of a width or height, as a multiple of log n."""
_SWEEPS = 8
"""Number of updates of the posterior from that of the other elements."""
_MAX_EM_STEPS = 12
"""Largest number of EM steps."""
_TOLERANCE_NATS = 1e-3
"""Least gain of a step, nats; smaller ones end the search."""
_INITIAL_SHARES = (0.05, 0.15, 0.35)
"""Initial shares of a new kind."""
_FACTORS = 32
"""Number of likelihoods, from .02 to 40,000, whose product is far from the limits of floating-point numbers."""
_MAX_ROUNDS = 40
"""Budget of rounds of additions and of improvements."""


@dataclass(frozen=True, eq=False)
class Groups:
    """All rows, or all columns, of a facade."""

    index: Ints
    """[N] group of each element, -1 for none."""
    kappa: float
    """Weight of the shares of the whole facade relative to those of the group, as a number of elements."""

    @cached_property
    def others(self) -> Floats:
        """[N, N] 1 for two different elements of one group."""
        is_same = (self.index[:, None] == self.index) & (self.index >= 0)
        return is_same.astype(np.float64) - np.diag(self.index >= 0)


@dataclass(frozen=True, eq=False)
class Kinds:
    """K kinds, each with a width and a height; kinds share a size if they have the same index."""

    width: Ints
    """[K] index of the width on the axis of the maps."""
    height: Ints
    """[K] index of the height on the axis of the maps."""
    share: Floats
    """[K] pi: share of each kind in the elements."""

    def __len__(self) -> int:
        return len(self.width)


@dataclass(frozen=True, eq=False)
class Solution:
    """Kinds, and the posterior of N elements."""

    kinds: Kinds
    posterior: Floats
    """[N, K + 1] probability of each kind, with that of no kind last."""
    length: float
    """Description length, nats."""


def find_kinds(maps: Maps, groups: tuple[Groups, ...] = (), start: Kinds | None = None) -> Solution:
    """The kinds of shortest description that are reachable by adding, merging, moving and deleting.

    Args:
        maps: evidence maps of the elements.
        groups: rows and columns whose elements tend to agree.
        start: initial kinds; none by default.
    """
    empty = np.zeros(0, dtype=np.int64)
    best, improved = _solve(maps, groups, start or Kinds(empty, empty, np.zeros(0))), None
    for _ in range(_MAX_ROUNDS):
        before = best.length
        for proposed in _additions(maps, best):
            best = min(best, _solve(maps, groups, proposed), key=_length)
        # A solution that was improved before has no better neighbour.
        improved = best if best is improved else _improved(maps, groups, best)
        best = improved
        if best.length > before - _TOLERANCE_NATS:
            break
    return best


def nearby(maps: Maps, groups: tuple[Groups, ...], solution: Solution) -> Iterator[Solution]:
    """Different solutions one step away: one kind fewer, two values merged, another value, or one kind more."""
    keys = {_key(solution.kinds)}
    for proposed in (*_changes(solution.kinds), *_additions(maps, solution)):
        neighbour = _solve(maps, groups, proposed, 4)
        if _key(neighbour.kinds) not in keys:
            keys.add(_key(neighbour.kinds))
            yield neighbour


def _solve(maps: Maps, groups: tuple[Groups, ...], kinds: Kinds, steps: int = _MAX_EM_STEPS) -> Solution:
    """EM from given kinds: shares, and shared values, which move along their axes."""
    number = len(maps.evidence)
    solution = _evaluate(maps, groups, kinds)
    for _ in range(steps if len(kinds) else 0):
        weight = solution.posterior[:, :-1]
        total = weight.sum(axis=0)
        share = np.maximum(total, 1e-3) / max(float(np.maximum(total, 1e-3).sum()), 1e-9)
        moved = _settled(maps, Kinds(kinds.width, kinds.height, share), weight)
        better = _evaluate(maps, groups, moved)
        if better.length > solution.length - _TOLERANCE_NATS:
            break
        kinds, solution = moved, better
    is_used = solution.posterior[:, :-1].sum(axis=0) >= 0.5
    if len(kinds) and not is_used.all() and number:
        return _solve(maps, groups, _only(kinds, is_used), steps)
    return solution


def _evaluate(maps: Maps, groups: tuple[Groups, ...], kinds: Kinds) -> Solution:
    """Posterior of given kinds, and their description length."""
    number = len(maps.evidence)
    fit = maps.evidence[:, kinds.width, kinds.height]
    share = _shares(fit, kinds.share, groups, _UNKNOWN_SHARE)
    joint = np.concatenate([(1.0 - _UNKNOWN_SHARE) * share * fit, np.full((number, 1), _UNKNOWN_SHARE)], axis=1)
    total = joint.sum(axis=1)
    values = len(set(kinds.width.tolist())) + len(set(kinds.height.tolist()))
    cost = (0.5 * len(kinds) + VALUE_COST * values) * np.log(max(number, 2))
    return Solution(kinds, joint / total[:, None], float(cost - np.log(total).sum()))


def _shares(fit: Floats, share: Floats, groups: tuple[Groups, ...], unknown: float) -> Floats:
    """[N, K] prior of each kind for each element, from the posterior of the other elements of its groups.

    Args:
        fit: [N, K] evidence of each element for each kind.
        share: [K] shares of the kinds.
        groups: rows and columns; if empty, the prior of all elements is `share`.
        unknown: fraction of elements without a kind.
    """
    prior = np.broadcast_to(share, fit.shape)
    if not groups or not fit.shape[1]:
        return prior
    whole, floor = np.log(np.maximum(share, 1e-12)), 1.0 / np.maximum(share, 1e-12)
    likelihood = (1.0 - unknown) * fit
    for _ in range(_SWEEPS):
        joint = prior * likelihood
        posterior = joint / (joint.sum(axis=1, keepdims=True) + unknown)
        logs = whole
        for group in groups:
            counts = group.others @ posterior
            logs = logs + np.log((counts * floor + group.kappa) / (counts.sum(axis=1, keepdims=True) + group.kappa))
        odds = np.exp(logs - logs.max(axis=1, keepdims=True))
        prior = odds / odds.sum(axis=1, keepdims=True)
    return prior


def _settled(maps: Maps, kinds: Kinds, weight: Floats) -> Kinds:
    """Kinds with values moved to the best fit of their elements."""
    width, height = kinds.width.copy(), kinds.height.copy()
    for value in set(width.tolist()):
        members = np.flatnonzero(width == value).tolist()
        score = sum(weight[:, k] @ maps.logs_by_height[height[k]] for k in members)
        width[members] = int(np.argmax(score))
    for value in set(height.tolist()):
        members = np.flatnonzero(height == value).tolist()
        score = sum(weight[:, k] @ maps.logs_by_width[width[k]] for k in members)
        height[members] = int(np.argmax(score))
    return Kinds(width, height, kinds.share)


def _only(kinds: Kinds, is_selected: np.ndarray) -> Kinds:
    share = kinds.share[is_selected]
    return Kinds(kinds.width[is_selected], kinds.height[is_selected], share / max(float(share.sum()), 1e-9))


def _additions(maps: Maps, solution: Solution) -> Iterator[Kinds]:
    """Kinds with an additional best one: with new sizes, a known width or height, or both."""
    kinds = solution.kinds
    fit = maps.evidence[:, kinds.width, kinds.height] @ kinds.share if len(kinds) else np.zeros(len(maps.evidence))
    best: dict[str, tuple[float, Kinds]] = {}
    rows = np.unique(kinds.width)
    columns = np.unique(kinds.height)
    for guess in _INITIAL_SHARES if len(kinds) else (1.0,):
        gain = mixture_gain(maps.evidence, fit, guess)
        for name, across, up in (
            ("new", slice(None), slice(None)),
            ("width", rows, slice(None)),
            ("height", slice(None), columns),
            ("both", rows, columns),
        ):
            part = gain[across][:, up]
            if not part.size:
                continue
            cell = np.unravel_index(int(part.argmax()), part.shape)
            w = int(np.arange(gain.shape[0])[across][cell[0]])
            h = int(np.arange(gain.shape[1])[up][cell[1]])
            share = np.append(kinds.share * (1.0 - guess), guess)
            proposed = Kinds(np.append(kinds.width, w), np.append(kinds.height, h), share)
            if name not in best or part.max() > best[name][0]:
                best[name] = float(part.max()), proposed
    return iter([proposed for _, proposed in best.values()])


def mixture_gain(evidence: Floats, fit: Floats, guess: float) -> Floats:
    """[A, B] log-likelihood of all elements with a further kind of each size, whose share is `guess`.

    Factors are multiplied before the logarithm, element by element, so that what is worked on stays in the cache.
    """
    base = (1.0 - _UNKNOWN_SHARE) * (1.0 - guess) * fit + _UNKNOWN_SHARE
    gain, product, factor = np.zeros(evidence.shape[1:]), np.ones(evidence.shape[1:]), np.empty(evidence.shape[1:])
    for element, part in enumerate(evidence):
        np.multiply(part, (1.0 - _UNKNOWN_SHARE) * guess, out=factor)
        factor += base[element]
        product *= factor
        if (element + 1) % _FACTORS == 0 or element + 1 == len(evidence):
            gain += np.log(product)
            product.fill(1.0)
    return gain


def _length(solution: Solution) -> float:
    return solution.length


def _improved(maps: Maps, groups: tuple[Groups, ...], solution: Solution) -> Solution:
    """The solution after deleting and merging kinds and reusing values, while that shortens the description."""
    for _ in range(_MAX_ROUNDS):
        solutions = [_solve(maps, groups, proposed, 4) for proposed in _changes(solution.kinds)]
        best = min(solutions, key=_length, default=solution)
        if best.length > solution.length - _TOLERANCE_NATS:
            return solution
        solution = _solve(maps, groups, best.kinds)
    return solution


def _changes(kinds: Kinds) -> Iterator[Kinds]:
    """All kinds at a distance of one step: one kind deleted, two values merged, or one kind with another value."""
    number = len(kinds)
    for k in range(number if number > 1 else 0):
        yield _only(kinds, np.arange(number) != k)
    for axis in ("width", "height"):
        indices = getattr(kinds, axis)
        values = np.unique(indices)
        for first, second in pairwise(values.tolist()):
            for target in (first, second):
                yield _with(kinds, axis, np.where((indices == first) | (indices == second), target, indices))
        for k in range(number):
            for value in values:
                if value != indices[k] and (indices == indices[k]).sum() > 1:
                    changed = indices.copy()
                    changed[k] = value
                    yield _with(kinds, axis, changed)


def _with(kinds: Kinds, axis: str, values: Ints) -> Kinds:
    """Kinds with other widths or heights; equal ones are merged."""
    width, height = (values, kinds.height) if axis == "width" else (kinds.width, values)
    pairs, inverse = np.unique(np.stack([width, height], axis=1), axis=0, return_inverse=True)
    share = np.bincount(inverse.reshape(-1), weights=kinds.share, minlength=len(pairs)).astype(np.float64)
    return Kinds(pairs[:, 0], pairs[:, 1], share)


def _key(kinds: Kinds) -> tuple[tuple[int, int], ...]:
    return tuple(sorted(zip(kinds.width.tolist(), kinds.height.tolist(), strict=True)))
