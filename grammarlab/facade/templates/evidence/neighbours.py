"""Rows and columns of a facade as a prior: elements of one row are often of one kind.

pi_ik is proportional to pi_k prod_g (n_gk + kappa_g pi_k) / ((n_g + kappa_g) pi_k), where n_gk is the number of the
other elements of group g that are of kind k; kappa is large for groups without information.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.templates.elements import Floats, Ints

_SWEEPS = 8


@dataclass(frozen=True, eq=False)
class Groups:
    """All rows, or all columns, of a facade."""

    index: Ints
    """[N] group of each element, -1 for none."""
    kappa: float
    """Weight of the shares of the whole facade relative to those of the group, as a number of elements."""


def shares(fit: Floats, share: Floats, groups: tuple[Groups, ...], unknown: float) -> Floats:
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
    indicators = [_indicator(each.index) for each in groups]
    for _ in range(_SWEEPS):
        joint = (1.0 - unknown) * prior * fit
        posterior = joint / (joint.sum(axis=1, keepdims=True) + unknown)
        logs = np.log(np.maximum(share, 1e-12))[None, :].repeat(len(fit), axis=0)
        for each, member in zip(groups, indicators, strict=True):
            of_kind = member.T @ (member @ posterior) - (member.sum(axis=0)[:, None] > 0) * posterior
            total = of_kind.sum(axis=1, keepdims=True)
            logs += np.log(of_kind / np.maximum(share, 1e-12) + each.kappa) - np.log(total + each.kappa)
        odds = np.exp(logs - logs.max(axis=1, keepdims=True))
        prior = odds / odds.sum(axis=1, keepdims=True)
    return prior


def _indicator(index: Ints) -> Floats:
    """[G, N] 1 for the members of each group."""
    return (index[None, :] == np.unique(index[index >= 0])[:, None]).astype(np.float64)
