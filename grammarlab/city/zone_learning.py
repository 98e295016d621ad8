"""Zone densities learned from right zones of some parcels.

The scales of the constant, the slopes and the kernel, the kernel's length and a centre are learned by the evidence
(`grammarlab.city.softmax_process`), the weights by the mode. A field stays only if the evidence, less the price of its
choice among all fields, is larger with it; so does the kernel.

A map often has a centre from which zones change in all directions (J. H. von Thünen, *Der isolierte Staat*, 1826;
W. Alonso, *Location and Land Use*, 1964), and nobody says where it is. So the distance to an unknown point is one more
field, whose price is that of its two coordinates (G. Schwarz, "Estimating the dimension of a model", 1978).

The result depends on the answers and the fields of their parcels, and neither on other parcels nor on any order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.city.fields import ParcelFields
from grammarlab.city.softmax_process import Mode, evidence_of, mode_of
from grammarlab.city.zone_density import MAX_WEIGHTS, Feature, ZoneDensity, places_km, standardised, text_words
from grammarlab.city.zone_design import ZoneDesign, rounded, spread_order, whitened_kernels
from grammarlab.errors import UsageError

MAX_PLACES = 256
"""Most inducing places."""
MAX_ZONES = 32
"""Most zones of a density."""
_SEARCH_PLACES, _SEARCH_ANSWERS = 64, 1024
"""Inducing places and answers by which scales, length and centre are chosen. Budgets: a second for three zones."""
_PRIOR_RATE = 1.0
"""Rate of the exponential prior of each scale, per unit of log-odds: 5 % are larger than 3 (D. Simpson et al.,
"Penalising model component complexity", 2017). Its highest density is at 0: no effect."""
_CONSTANT_RATE = 0.1
"""The same of the constant: zones may be rare everywhere."""
_SCALES = (0.01, 20.0)
"""Smallest and largest scale, in log-odds. What has the smallest one has no effect."""
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
    """Logarithm of the evidence, less the prices of choices."""


@dataclass(frozen=True, eq=False)
class _Explanation:
    """What the answers may depend on."""

    scales: Floats
    """[F + 3] scales of the constant, the slopes of F fields, the slope of the distance to a centre, and the kernel;
    0 for what has no effect."""
    centre: Floats
    """[2] km."""
    length: float
    """Length of the kernel in km."""
    value: float = -np.inf
    """Logarithm of the evidence, with the priors of the scales and less the prices of choices."""


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
        search = _Search(fields, counts)
        explanation = search.explained()
        design = search.design(explanation)
        if len(design.places):
            u = places_km(fields, fields.frame)
            places = u[spread_order(u, min(MAX_PLACES, MAX_WEIGHTS // len(zones)))]
            design = replace(design, places=rounded(places))
        mode = mode_of(design.rows(fields), counts)
    density = design.density(mode, fields, counts, zones, answers)
    return LearnedZones(
        density=density, design=design, mode=mode, fields=fields, counts=counts, evidence=explanation.value
    )


class _Search:
    """The answers by which a design is chosen: at most `_SEARCH_ANSWERS`, chosen by their ids."""

    def __init__(self, fields: ParcelFields, counts: Floats) -> None:
        rows = np.sort(np.argsort(text_words(fields.id))[:_SEARCH_ANSWERS])
        self.frame, self.counts = fields.frame, counts[rows]
        self.u = places_km(fields, fields.frame)[rows]
        self.places = self.u[spread_order(self.u, _SEARCH_PLACES)]
        self.spread = max(float(rounded(np.sqrt(self.u.var(axis=0).sum()))), 1e-3)
        """Root mean square distance of the answers from their middle in km, at least one metre."""
        self.features = _features(fields.take(rows))
        self.x = standardised(fields.take(rows), self.u, self.features)
        self.rates = np.full(len(self.features) + 3, _PRIOR_RATE)
        self.rates[0] = _CONSTANT_RATE
        self.prices = np.full(len(self.rates), np.log(1.0 + len(self.features)))
        """[F + 3] price of each scale that is not 0, in nats."""
        self.prices[[0, -2, -1]] = 0.0, np.log(max(counts.sum(), 1.0)), np.log(len(_LENGTHS))

    def explained(self) -> _Explanation:
        """The best explanation."""
        lengths = [float(rounded(length)) for length in _LENGTHS * self.spread]
        plain = np.ones(len(self.rates))
        plain[-2] = 0.0
        centre = max(self._centres(), key=self._evidence_at)
        without_kernel = np.where(np.arange(len(plain)) == len(plain) - 1, 0.0, 1.0)
        centred = self.improved(_Explanation(without_kernel, centre, lengths[0]))
        centred = replace(centred, scales=np.append(centred.scales[:-1], 1.0))
        starts = (_Explanation(plain, centre, lengths[0]), centred)
        return max((self._pruned(self._with_length(start, lengths)) for start in starts), key=_value)

    def improved(self, start: _Explanation) -> _Explanation:
        """The explanation with the best scales, of those that are not 0, and the best centre near the given one."""
        used = np.flatnonzero(start.scales)
        num, has_centre = len(used), bool(start.scales[-2])
        kernels = np.zeros((len(self.u), 0))
        if start.scales[-1]:
            kernels = whitened_kernels(self.u, self.places, start.length)
        fixed = np.column_stack([np.ones(len(self.u)), self.x])
        columns = used[used < fixed.shape[1]]
        group = np.concatenate([np.arange(num - bool(start.scales[-1])), np.full(kernels.shape[1], num - 1)])
        weights = np.zeros((len(group), self.counts.shape[1] - 1))

        def negative(flat: Floats) -> tuple[float, Floats]:
            nonlocal weights
            scales, centre = np.exp(flat[:num]), flat[num:] * self.spread
            parts = [fixed[:, columns], kernels]
            if has_centre:
                parts.insert(1, self._distance(centre)[:, None])
            design = np.hstack(parts) * scales[group]
            evidence = evidence_of(design, self.counts, weights)
            weights = evidence.mode.weights
            slope = np.bincount(group, (evidence.slope * design).sum(axis=0), num).astype(np.float64)
            slope -= self.rates[used] * scales
            if has_centre:
                offset = centre - self.u
                direction = offset / np.maximum(np.hypot(*offset.T), 1e-9)[:, None]
                slope = np.append(slope, evidence.slope[:, len(columns)] @ direction * scales[len(columns)])
            return float(self.rates[used] @ scales) - evidence.value, -slope

        first = np.log(np.clip(start.scales[used], 10 * _SCALES[0], _SCALES[1]))
        bounds: list[tuple[float | None, float | None]] = [(np.log(_SCALES[0]), np.log(_SCALES[1]))] * num
        if has_centre:
            first, bounds = np.append(first, start.centre / self.spread), [*bounds, (None, None), (None, None)]
        options = {"maxiter": _MAX_STEPS, "ftol": 1e-4, "gtol": 1e-2}
        result = minimize(negative, first, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
        scales = np.zeros(len(start.scales))
        scales[used] = np.exp(result.x[:num])
        centre = result.x[num:] * self.spread if has_centre else start.centre
        return replace(start, scales=scales, centre=centre, value=-float(result.fun) - self.prices[used].sum())

    def design(self, explanation: _Explanation) -> ZoneDesign:
        """The design of an explanation; without a kernel it has no places."""
        scales = rounded(explanation.scales)
        east, north = rounded(explanation.centre).tolist()
        distance = Feature(DISTANCE, "km", self.spread, self.spread, centre=(east, north))
        used = scales[1:-1] > 0.0
        features = [feature for feature, useful in zip((*self.features, distance), used, strict=True) if useful]
        return ZoneDesign(
            frame=self.frame,
            features=tuple(features),
            places=self.places if scales[-1] else self.places[:0],
            length=explanation.length,
            scales=np.concatenate([scales[:1], scales[1:-1][used], scales[-1:]]),
        )

    def _with_length(self, start: _Explanation, lengths: Sequence[float]) -> _Explanation:
        """The best of explanations with each length of the kernel; each starts from the scales of the one before."""
        explanations = [start]
        for length in lengths:
            explanations.append(self.improved(replace(explanations[-1], length=length)))
        return max(explanations[1:], key=_value)

    def _pruned(self, start: _Explanation) -> _Explanation:
        """An explanation without what is not worth its price, the smallest scales first."""
        best = start
        for index in np.argsort(start.scales).tolist():
            if index and start.scales[index]:
                scales = best.scales.copy()
                scales[index] = 0.0
                shorter = self.improved(replace(best, scales=scales))
                best = max(best, shorter, key=_value)
        return best

    def _centres(self) -> list[Floats]:
        """Candidate centres in km."""
        steps = np.linspace(-_CENTRE_REACH, _CENTRE_REACH, _CENTRES_PER_SIDE)
        grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        return list(self.u.mean(axis=0) + grid * np.maximum(self.u.std(axis=0), 1e-3))

    def _evidence_at(self, centre: Floats) -> float:
        """Evidence of the fields and the distance to a point with scales of 1, without a kernel."""
        design = np.column_stack([np.ones(len(self.u)), self.x, self._distance(centre)])
        return evidence_of(design, self.counts).value

    def _distance(self, centre: Floats) -> Floats:
        return np.hypot(*(self.u - centre).T) / self.spread - 1.0


def _value(explanation: _Explanation) -> float:
    return explanation.value


def _features(fields: ParcelFields) -> tuple[Feature, ...]:
    """Fields with their means and standard deviations over the answers; constant and unknown ones are left out.

    Numbers >= 0 with a long tail are taken as logarithms, so that a few large parcels do not decide.
    """
    # Imported here, since it takes as long as half of JAX and only answers about zones need it.
    from scipy.stats import skew  # noqa: PLC0415

    features = list[Feature]()
    for name, unit, values in zip(fields.name, fields.unit, fields.values.T, strict=True):
        present = values[np.isfinite(values)]
        if len(present) < 2 or np.ptp(present) <= 1e-9 * np.abs(present).max():
            continue
        is_log = bool(present.min() >= 0.0 and abs(skew(np.log1p(present))) < abs(skew(present)))
        numbers = np.log1p(present) if is_log else present
        features.append(Feature(name, unit, float(numbers.mean()), float(numbers.std()), is_log))
    return tuple(features)


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
    for number in np.unique(folds):
        out = folds == number
        with threadpool_limits(1, "blas"):
            mode = mode_of(rows[~out], learned.counts[~out], learned.mode.weights)
        others, answers = learned.fields.take(~out), learned.counts[~out]
        density = learned.design.density(mode, others, answers, learned.density.zones, "")
        chances[out] = density.probabilities(learned.fields.take(out))
    return chances
