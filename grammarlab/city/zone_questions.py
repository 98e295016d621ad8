"""Which parcels to ask about next: those whose answers are expected to tell most about the zones of the whole map.

The expected divergence of the learned probabilities from the true ones is, to second order, half the trace of the
Fisher information times the covariance of the log-odds, summed over the map. The next question is the parcel whose
answer makes this sum smallest; its answer is then taken as given, and so on (D. MacKay, "Information-based objective
functions for active data selection", 1992: the mean marginal information).

That expectation believes what is learned so far, and early on this may be wrong: on real zoning maps, such questions
alone are worse than random ones. So only one in four is of this kind; the others are about the parcel that is farthest
from all answers, among some.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from scipy.special import softmax
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.city.fields import ParcelFields
from grammarlab.city.softmax_process import contrasts, evidence_of, fisher_information
from grammarlab.city.zone_density import places_km, text_words
from grammarlab.city.zone_design import spread_order
from grammarlab.city.zone_learning import LearnedZones

_SAMPLE = 512
"""Parcels, chosen by their ids, that may be asked about, and that stand for the map. A budget: half a second."""
_MAX_SIZE = 1_500_000
"""Most numbers of the covariance between them; with many zones there are fewer parcels."""
_SPREAD = 192
"""Parcels among which the farthest is chosen; of all parcels, most would be at the rim of the map."""
_INFORMED = 4
"""One question in so many is chosen by expected information. A prior: how far to believe what is learned so far."""
_JITTER = 1e-9


def first_questions(fields: ParcelFields, num: int) -> NDArray[np.object_]:
    """[q] ids of at most `num` parcels to begin with: each the farthest from those before, among some chosen by id.

    Args:
        fields: fields of the parcels of the map.
        num: number of questions.
    """
    sample = fields.take(_sample(fields, _SAMPLE))
    return sample.id[spread_order(places_km(sample, sample.frame), num)] if len(sample) else sample.id


def next_questions(learned: LearnedZones, fields: ParcelFields, num: int) -> NDArray[np.object_]:
    """[q] ids of at most `num` parcels without an answer, the most informative first.

    Args:
        learned: the zones learned so far.
        fields: fields of the parcels of the map.
        num: number of questions.
    """
    size = len(learned.density.zones) - 1
    most = min(_SAMPLE, int(np.sqrt(_MAX_SIZE) / size))
    unasked = np.flatnonzero(~np.isin(fields.id.astype(str), learned.fields.id.astype(str)))
    if not len(unasked):
        return fields.id[:0]
    sample = fields.take(unasked[_sample(fields.take(unasked), most)])
    with threadpool_limits(1, "blas"):
        rows = learned.design.rows(sample)
        covariance = _covariance(learned, rows)
        distance = _distances(learned, sample)
        odds = rows @ learned.mode.weights @ contrasts(size + 1).T
        information = fisher_information(softmax(odds, axis=1), np.ones(len(sample)))
        chosen = _chosen(covariance, information, distance, min(num, len(sample)))
    return sample.id[chosen]


def _sample(fields: ParcelFields, most: int) -> Ints:
    """Rows of at most `most` parcels, chosen by their ids, in the order of the ids."""
    rows = np.argsort(text_words(fields.id), kind="stable")[:most]
    return rows[np.argsort(fields.id[rows].astype(str), kind="stable")]


def _covariance(learned: LearnedZones, rows: Floats) -> Floats:
    """[S, K - 1, S, K - 1] covariance of the log-odds of parcels with rows [S, D], in contrasts."""
    design = learned.design.rows(learned.fields)
    covariance = evidence_of(design, learned.counts, learned.mode.weights).covariance
    return np.einsum("id,adbe,je->iajb", rows, covariance, rows, optimize=True)


def _distances(learned: LearnedZones, sample: ParcelFields) -> Floats:
    """[S, A + S] distances in km from the answered parcels and from each other; -1 for parcels not to be spread."""
    u = places_km(sample, learned.design.frame)
    distance = np.asarray(cdist(u, np.concatenate([places_km(learned.fields, learned.design.frame), u])), np.float64)
    distance[np.argsort(text_words(sample.id), kind="stable")[_SPREAD:]] = -1.0
    return distance


def _chosen(covariance: Floats, information: Floats, distance: Floats, num: int) -> Ints:
    """Indices of parcels: the one that makes the expected divergence smallest, then the farthest ones, and again.

    Args:
        covariance: [S, k, S, k] of the log-odds.
        information: [S, k, k] of an answer about each parcel.
        distance: [S, A + S] distances from the answered parcels and from each other.
        num: number of indices.
    """
    size, num_answered = information.shape[1], distance.shape[1] - len(distance)
    factor = np.linalg.cholesky(information + _JITTER * np.eye(size))
    # In units in which an answer has the error 1: the divergence is half the trace of the covariance.
    scaled = np.einsum("iap,iajb,jbq->ipjq", factor, covariance, factor, optimize=True)
    index, nearest = np.arange(len(scaled)), distance[:, :num_answered].min(axis=1)
    chosen = list[int]()
    for turn in range(num):
        own = scaled[index, :, index] + np.eye(size)
        gain = (
            nearest
            if turn % _INFORMED
            else np.einsum("ipjq,jqr,ipjr->j", scaled, np.linalg.inv(own), scaled, optimize=True)
        )
        best = int(np.where(np.isin(index, chosen), -np.inf, gain).argmax())
        chosen.append(best)
        nearest = np.minimum(nearest, distance[:, num_answered + best])
        column = scaled[:, :, best]
        scaled = scaled - np.einsum("ipq,qr,jsr->ipjs", column, np.linalg.inv(own[best]), column, optimize=True)
    return np.array(chosen, np.int64)
