"""Zone densities learned from right zones of some parcels.

The scales of the constant, the slopes and the kernel, the kernel's length and a centre are learned by the evidence
(`grammarlab.city.softmax_process`), the weights by the mode. A field that the answers do not depend on is left out.

A map often has a centre from which zones change in all directions (J. H. von Thünen, *Der isolierte Staat*, 1826;
W. Alonso, *Location and Land Use*, 1964), and nobody says where it is. So the distance to an unknown point is one more
field; it is used if the evidence, less the price of its two coordinates (G. Schwarz, "Estimating the dimension of a
model", 1978), is larger with it.

The result depends on the answers and the fields of their parcels, and neither on other parcels nor on any order.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize
from scipy.stats import skew
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.city.fields import ParcelFields
from grammarlab.city.softmax_process import Evidence, Mode, evidence_of, mode_of
from grammarlab.city.zone_density import Feature, ZoneDensity, places_km, standardised, text_words
from grammarlab.city.zone_design import ZoneDesign, rounded, spread_order, whitened_kernels
from grammarlab.errors import UsageError

MAX_PLACES = 256
"""Most inducing places."""
MAX_ZONES = 32
"""Most zones of a density."""
_MAX_WEIGHTS = 4096
"""Most inducing places times zones: a file of at most 100 kB."""
_SEARCH_PLACES, _SEARCH_ANSWERS = 64, 1024
"""Inducing places and answers by which scales, length and centre are chosen. Budgets: a second for three zones."""
_PRIOR_RATE = 1.0
"""Rate of the exponential prior of each scale, per unit of log-odds: 5 % are larger than 3 (D. Simpson et al.,
"Penalising model component complexity", 2017). Its highest density is at 0: no effect."""
_SCALES = (0.01, 20.0)
"""Smallest and largest scale, in log-odds. Fields of the smallest one are left out."""
_FIRST_SCALE = 1.0
_LENGTHS = 2.0 ** np.arange(-2, 3)
"""Candidate lengths of the kernel, by the spread of the answers."""
_CENTRES_PER_SIDE, _CENTRE_REACH = 7, 1.5
"""Candidate centres: a grid that reaches so many standard deviations of the answers to each side of their middle."""
_MAX_STEPS = 25
DISTANCE = "distance to a centre"
"""Name of the distance to the learned centre; with blanks, so that no field of a plan has it."""


@dataclass(frozen=True, eq=False, kw_only=True)
class LearnedZones:
    """A density with its uncertainty."""

    density: ZoneDensity
    design: ZoneDesign
    mode: Mode
    fields: ParcelFields
    """Fields of the n parcels with answers, ordered by id."""
    counts: Floats
    """[n, K] answers for each zone."""
    evidence: float
    """Logarithm of the evidence."""


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A design with its evidence, less the prices of its hyperparameters."""

    value: float
    design: ZoneDesign


def learned_zones(fields: ParcelFields, counts: Floats, zones: tuple[str, ...], answers: str) -> LearnedZones:
    """The density of zones from answers.

    Args:
        fields: fields of n parcels with different ids, n >= 1.
        counts: [n, K] how often each zone is the answer for a parcel, >= 0; fractions are weights.
        zones: [K] names, 2 <= K <= `MAX_ZONES`.
        answers: hash of the answers.

    Raises:
        UsageError: If there are no answers, or too few or too many zones.
    """
    if not 2 <= len(zones) <= MAX_ZONES:
        raise UsageError(f"zones: expected 2 to {MAX_ZONES}, found {len(zones)}.")
    if not counts.sum() > 0.0:
        raise UsageError("answers: expected at least one.")
    order = np.argsort(fields.id.astype(str), kind="stable")
    order = order[counts[order].sum(axis=1) > 0.0]
    fields, counts = fields.take(order), counts[order]
    with threadpool_limits(1, "blas"):
        candidate = _chosen(_Search(fields, counts))
        order = spread_order(places_km(fields, fields.frame), min(MAX_PLACES, _MAX_WEIGHTS // len(zones)))
        places = rounded(places_km(fields, fields.frame)[order])
        design = _without_idle_fields(replace(candidate.design, places=places))
        mode = mode_of(design.rows(fields), counts)
    density = design.density(mode, zones, answers)
    return LearnedZones(
        density=density, design=design, mode=mode, fields=fields, counts=counts, evidence=candidate.value
    )


class _Search:
    """The answers by which a design is chosen: at most `_SEARCH_ANSWERS`, chosen by their ids."""

    def __init__(self, fields: ParcelFields, counts: Floats) -> None:
        rows = np.sort(np.argsort(text_words(fields.id))[:_SEARCH_ANSWERS])
        self.fields, self.counts = fields.take(rows), counts[rows]
        self.u = places_km(self.fields, fields.frame)
        self.places = self.u[spread_order(self.u, _SEARCH_PLACES)]
        self.spread = max(float(rounded(np.sqrt(self.u.var(axis=0).sum()))), 1e-3)
        """Root mean square distance of the answers from their middle in km, at least one metre."""
        self.features = _features(self.fields)
        self.x = standardised(self.fields, self.u, self.features)

    def improved(self, length: float | None, start: Floats, centre: Floats | None) -> _Candidate:
        """The best scales, and the best centre near one, for a length of the kernel, or without a kernel.

        Args:
            length: km.
            start: scales of the constant, the slopes and the kernel to start from.
            centre: [2] km; None without the distance to a centre.
        """
        kernels = np.zeros((len(self.u), 0)) if length is None else whitened_kernels(self.u, self.places, length)
        num_scales = 2 + self.x.shape[1] + (centre is not None)
        group = np.minimum(np.arange(num_scales - 1 + kernels.shape[1]), num_scales - 1)
        last = Evidence(Mode(np.zeros((len(group), self.counts.shape[1] - 1)), 0.0), 0.0, kernels, kernels)

        def negative(flat: Floats) -> tuple[float, Floats]:
            nonlocal last
            scales, position = np.exp(flat[:num_scales]), flat[num_scales:] * self.spread
            columns = [np.ones((len(self.u), 1)), self.x]
            if centre is not None:
                columns.append(self._distance(position)[:, None])
            design = np.hstack([*columns, kernels]) * scales[group]
            last = evidence_of(design, self.counts, last.mode.weights)
            slope = np.bincount(group, (last.slope * design).sum(axis=0), num_scales) - _PRIOR_RATE * scales
            if centre is not None:
                index = num_scales - 2
                offset = position - self.u
                distance = np.maximum(np.hypot(*offset.T), 1e-9)[:, None]
                slope = np.append(slope, last.slope[:, index] @ (scales[index] * offset / distance))
            return _PRIOR_RATE * scales.sum() - last.value, -slope

        first = np.log(np.clip(start, 10 * _SCALES[0], _SCALES[1]))
        bounds = [tuple(np.log(_SCALES))] * num_scales
        if centre is not None:
            first, bounds = np.append(first, centre / self.spread), [*bounds, (None, None), (None, None)]
        options = {"maxiter": _MAX_STEPS, "ftol": 1e-5, "gtol": 1e-2}
        result = minimize(negative, first, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
        features, value = self.features, -float(result.fun)
        if centre is not None:
            features = (*features, self._feature(result.x[num_scales:] * self.spread))
            value -= np.log(self.counts.sum())  # half the logarithm of the number of answers, for each coordinate
        scales = rounded(np.exp(result.x[:num_scales]))
        places = self.places if length is not None else self.places[:0]
        design = ZoneDesign(
            frame=self.fields.frame, features=features, places=places, length=length or self.spread, scales=scales
        )
        return _Candidate(value, design)

    def centres(self) -> Floats:
        """[c, 2] candidate centres in km."""
        steps = np.linspace(-_CENTRE_REACH, _CENTRE_REACH, _CENTRES_PER_SIDE)
        grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        return self.u.mean(axis=0) + grid * np.maximum(self.u.std(axis=0), 1e-3)

    def evidence_at(self, centre: Floats) -> float:
        """Evidence of the distance to a point, without a kernel."""
        design = np.column_stack([np.ones(len(self.u)), self.x, self._distance(centre)])
        return evidence_of(design * _FIRST_SCALE, self.counts).value

    def _feature(self, centre: Floats) -> Feature:
        east, north = rounded(centre).tolist()
        return Feature(DISTANCE, "km", self.spread, self.spread, centre=(east, north))

    def _distance(self, centre: Floats) -> Floats:
        return np.hypot(*(self.u - centre).T) / self.spread - 1.0


def _chosen(search: _Search) -> _Candidate:
    """The best candidate with a centre or without."""
    num = 2 + len(search.features)
    plain = _best_length(search, np.full(num, _FIRST_SCALE), None)
    centres = search.centres()
    centre = centres[int(np.argmax([search.evidence_at(centre) for centre in centres]))]
    around = search.improved(None, np.full(num + 1, _FIRST_SCALE), centre)
    centred = _best_length(search, around.design.scales, np.array(around.design.features[-1].centre))
    return max(plain, centred, key=lambda candidate: candidate.value)


def _best_length(search: _Search, start: Floats, centre: Floats | None) -> _Candidate:
    """The best candidate of all lengths; each starts from the scales of the one before."""
    candidates = list[_Candidate]()
    for length in _LENGTHS * search.spread:
        candidates.append(search.improved(float(rounded(length)), start, centre))
        start = candidates[-1].design.scales
    return max(candidates, key=lambda candidate: candidate.value)


def _features(fields: ParcelFields) -> tuple[Feature, ...]:
    """Fields with their means and standard deviations over the answers; constant and unknown ones are left out.

    Numbers >= 0 with a long tail are taken as logarithms, so that a few large parcels do not decide.
    """
    features = list[Feature]()
    for name, unit, values in zip(fields.name, fields.unit, fields.values.T, strict=True):
        present = values[np.isfinite(values)]
        if len(present) < 2 or np.ptp(present) <= 1e-9 * np.abs(present).max():
            continue
        is_log = bool(present.min() >= 0.0 and abs(skew(np.log1p(present))) < abs(skew(present)))
        numbers = np.log1p(present) if is_log else present
        features.append(Feature(name, unit, float(numbers.mean()), float(numbers.std()), is_log))
    return tuple(features)


def _without_idle_fields(design: ZoneDesign) -> ZoneDesign:
    """A design without the fields, or the kernel, whose scales are the smallest."""
    decides = design.scales > 2 * _SCALES[0]
    features = tuple(feature for feature, useful in zip(design.features, decides[1:-1], strict=True) if useful)
    scales = np.concatenate([design.scales[:1], design.scales[1:-1][decides[1:-1]], design.scales[-1:]])
    return replace(design, features=features, scales=scales, places=design.places if decides[-1] else design.places[:0])


def shares_of_log_odds(learned: LearnedZones) -> dict[str, float]:
    """Part of each field, and of the ``place``, in the variance of the log-odds at the answers; largest first."""
    rows = learned.design.rows(learned.fields)
    num = 1 + len(learned.design.features)
    names = [*(feature.name for feature in learned.design.features), "place"]
    column_of = [slice(index, index + 1) for index in range(1, num)] + [slice(num, None)]
    parts = [(rows[:, columns] @ learned.mode.weights[columns]).var(axis=0).sum() for columns in column_of]
    total = max(float(np.sum(parts)), 1e-12)
    return {names[index]: float(parts[index] / total) for index in np.argsort(parts)[::-1]}


def held_out_chances(learned: LearnedZones, folds: Ints) -> Floats:
    """[n, K] probabilities of each parcel by the answers of the other folds, with the same design.

    Args:
        learned: the density.
        folds: [n] number of the fold of each parcel.
    """
    rows = learned.design.rows(learned.fields)
    chances = np.empty_like(learned.counts)
    for fold in np.unique(folds):
        out = folds == fold
        mode = mode_of(rows[~out], learned.counts[~out], learned.mode.weights)
        density = learned.design.density(mode, learned.density.zones, "")
        chances[out] = density.probabilities(learned.fields.take(out))
    return chances
