"""Matches from labels without evidence: of the paper's loop, of single fits, and of k-means.

Choice of templates: as few as explain the elements, each at a cost.

Agreement of kinds with the ground truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
from scipy.optimize import linear_sum_assignment

from grammarlab.matching.elements import Clouds, Elements, Floats, Ints, Truth, clouds_of, too_poor
from grammarlab.matching.fit import Fits, background_cost, fit_all
from grammarlab.matching.match import SURE, UNKNOWN, Clock, Match
from grammarlab.matching.match_assembly import THRESHOLD, replicas
from grammarlab.matching.template import Template, stack

_HIDING = 4.0
"""Cost of an occluding half-plane, nats."""
_FITTING = 6.0
"""Least gain of a template over points that are uniform in the box, nats."""
_LEAST_INSIDE = 0.5
"""Least fraction of inliers of a fit."""
_TEMPLATE = 4.0
"""Cost of a template, as a multiple of the logarithm of the number of elements."""


def description(clouds: Clouds, templates: Sequence[Template], fits: Fits) -> Floats:
    """[N, T + 1] description length of each element by each template, and by none last, nats."""
    points = clouds.weight.sum(axis=1)
    number = np.array([len(template.parameters) for template in templates])
    cost = fits.cost + 0.5 * number * np.log(np.maximum(points, 2.0))[:, None] + _HIDING * (fits.hidden > 0.0)
    cost = np.where(fits.inside < _LEAST_INSIDE, 1e6, cost)
    return np.concatenate([cost, background_cost(clouds)[:, None] - _FITTING], axis=1)


def used_templates(costs: Floats) -> Ints:
    """Indices of the templates with the shortest description of all elements, ascending; empty if none fits.

    Greedy: the best one is added, removed or exchanged as long as that shortens the description.
    """
    price = _TEMPLATE * np.log(len(costs) + 1.0)
    number = costs.shape[1] - 1
    used: frozenset[int] = frozenset()
    best = _total(costs, used, price)
    while True:
        steps = [used ^ {each} for each in range(number)]
        steps += [(used - {old}) | {new} for old in used for new in range(number) if new not in used]
        totals = [_total(costs, each, price) for each in steps]
        place = int(np.argmin(totals))
        if totals[place] >= best - 1e-9:
            return np.array(sorted(used), dtype=np.int64)
        used, best = steps[place], totals[place]


def _total(costs: Floats, used: frozenset[int], price: float) -> float:
    return float(costs[:, [*sorted(used), -1]].min(axis=1).sum() + price * len(used))


def agreeing(match: Match, truth: Truth) -> tuple[np.ndarray, Ints]:
    """[N] whether the kind of each element is correct, and [N] its kind; unknown elements have a kind of their own."""
    found = np.where(match.kind == UNKNOWN, match.kind.max() + 1, match.kind)
    table = np.zeros((found.max() + 1, truth.kind.max() + 1))
    np.add.at(table, (found, truth.kind), 1.0)
    table[match.kind.max() + 1 :] = 0.0
    rows, columns = linear_sum_assignment(-table)
    partner = np.full(len(table), -1)
    partner[rows] = columns
    right = (partner[found] == truth.kind) & (match.kind != UNKNOWN)
    return right, found


def compare(match: Match, truth: Truth) -> dict[str, Any]:
    """Adjusted mutual information, number of mislabelled elements, and correct ones among the sure results.

    Kinds of match and truth are paired so that most elements agree; elements of other pairs are mislabelled.
    """
    from sklearn.metrics import adjusted_mutual_info_score  # noqa: PLC0415 scikit-learn takes a second to load

    right, found = agreeing(match, truth)
    sure = (match.probability >= SURE) & (match.kind != UNKNOWN)
    return {
        "adjusted_mutual_information": float(adjusted_mutual_info_score(truth.kind, found)),
        "mislabelled": int((~right).sum()),
        "kinds": len(np.unique(truth.kind)),
        "kinds_found": len(match.values),
        "sure": int(sure.sum()),
        "sure_and_right": int((sure & right).sum()),
    }


NO_FIT = "no template fits it better than random points in its box"
_TOO_LARGE = 2.0
"""Ratio to the largest template from which the unit is in doubt."""
_MOST_KINDS = 12
"""Largest number of clusters of k-means if none is given."""


def match_alone(elements: Elements, templates: Sequence[Template], kinds: int | None) -> Match:
    """Kinds from fits of single elements.

    Args:
        elements: the elements.
        templates: the possible templates.
        kinds: None for `independent`: fits whose parameters differ by less than the paper's threshold are of one kind;
            for `kmeans` the number of clusters, or 0 for the number with the best silhouette.
    """
    clock = Clock()
    reasons = too_poor(elements)
    which = np.array([each for each in range(len(elements)) if each not in reasons], dtype=np.int64)
    clouds = clouds_of(elements, which)
    fits = fit_all(clouds, stack(templates))
    costs = description(clouds, templates, fits)
    fine = costs.argmin(axis=1) < len(templates)
    reasons |= unfit(clouds, templates, ~fine)
    which, fits, costs = which[fine], fits.of(fine), costs[fine, :-1]
    every = np.arange(len(which))
    owner = costs.argmin(axis=1) if len(which) else np.zeros(0, dtype=np.int64)
    if kinds is not None and len(which):
        owner = np.full(len(which), np.bincount(owner).argmax())
    values, corner = fits.parameters[every, owner], fits.corner[every, owner]
    clock.lap("fitting")
    if kinds is None:
        threshold = THRESHOLD * float(np.linalg.norm(elements.high - elements.low, axis=1).max())
        kind = replicas(owner, values, threshold)
    else:
        kind = _clustered(values[:, : len(templates[int(owner[0])].parameters)], kinds) if len(which) else owner
    clock.lap("kinds")
    return from_labels(
        elements, templates, which, kind, owner, values, corner, fits, reasons, iterations=1, clock=clock
    )


def _clustered(values: Floats, kinds: int) -> Ints:
    from sklearn.cluster import KMeans  # noqa: PLC0415 scikit-learn takes a second to load
    from sklearn.metrics import silhouette_score  # noqa: PLC0415

    number = len(np.unique(values, axis=0))

    def of(count: int) -> Ints:
        return KMeans(min(count, number), n_init=cast("Any", 10), random_state=0).fit_predict(values).astype(np.int64)

    if kinds:
        return of(kinds)
    tried = [of(count) for count in range(2, min(_MOST_KINDS, number - 1) + 1)]
    return max(tried, key=lambda each: silhouette_score(values, each), default=np.zeros(len(values), dtype=np.int64))


def unfit(clouds: Clouds, templates: Sequence[Template], which: np.ndarray) -> dict[int, str]:
    """Reasons why no template fits the elements of a mask [N]."""
    low, high = (np.array([getattr(each, end)[:2] for each in templates]) for end in ("low", "high"))
    size = clouds.reach[:, 1] - clouds.reach[:, 0]
    reasons = {}
    for place in np.flatnonzero(which).tolist():
        reasons[int(clouds.element[place])] = NO_FIT
        if (size[place] > _TOO_LARGE * high.max(axis=0)).any() or (size[place] < low.min(axis=0) / _TOO_LARGE).all():
            across, up = size[place].tolist()
            reasons[int(clouds.element[place])] = (
                f"its points span {across:.3g} x {up:.3g} m, and templates have sizes from {low.min():.3g} to "
                f"{high.max():.3g} m; check that its unit is the metre"
            )
    return reasons


def fitting(clouds: Clouds, templates: Sequence[Template], fits: Fits) -> np.ndarray:
    """[N] whether any template fits."""
    return description(clouds, templates, fits).argmin(axis=1) < len(templates)


def from_labels(
    elements: Elements,
    templates: Sequence[Template],
    which: Ints,
    label: Ints,
    owner: Ints,
    values: Floats,
    corner: Floats,
    fits: Fits,
    reasons: dict[int, str],
    *,
    iterations: int,
    clock: Clock,
) -> Match:
    """A match of M elements with labels.

    Args:
        elements: all N elements.
        templates: the possible templates.
        which: [M] indices of the labelled elements.
        label: [M] labels, equal for elements of one kind.
        owner: [M] template of each element.
        values: [M, D] parameters.
        corner: [M, 2] lower left corners from the centres of the boxes.
        fits: fits of the M elements.
        reasons: reasons for the other elements.
        iterations: number of iterations of the method.
        clock: clock of the method.
    """
    number = len(elements)
    used = np.unique(owner)
    names = [templates[each] for each in used.tolist()]
    kinds = [np.flatnonzero(label == each) for each in np.unique(label)]
    kinds.sort(key=lambda members: (int(np.searchsorted(used, owner[members[0]])), -len(members), int(members[0])))
    template = np.array([int(np.searchsorted(used, owner[members[0]])) for members in kinds], dtype=np.int64)
    size = [len(names[each].parameters) for each in template.tolist()]
    means = [values[members, :count].mean(axis=0) for members, count in zip(kinds, size, strict=True)]
    every = np.arange(len(which))
    covariance = fits.covariance[every, owner]
    spread = [
        np.sqrt(
            np.array([np.diag(covariance[each])[:count] for each in members]).mean(axis=0) / len(members)
            + elements.common_error**2
        )
        for members, count in zip(kinds, size, strict=True)
    ]
    kind = np.full(number, UNKNOWN, dtype=np.int64)
    parameters: list[Floats] = [np.zeros(0)] * number
    deviations: list[Floats] = [np.zeros(0)] * number
    place, hidden = elements.low.copy(), np.zeros(number)
    middle = (elements.low + elements.high) / 2
    posterior = np.zeros((number, len(kinds) + 1))
    posterior[:, -1] = 1.0
    threshold = THRESHOLD * float(np.linalg.norm(elements.high - elements.low, axis=1).max())
    for own, members in enumerate(kinds):
        for row in members.tolist():
            element = int(which[row])
            kind[element] = own
            parameters[element] = values[row, : size[own]]
            own_error = np.sqrt(np.diag(covariance[row])[: size[own]])
            deviations[element] = np.hypot(own_error, elements.common_error)
            place[element] = middle[element] + corner[row]
            hidden[element] = fits.hidden[row, owner[row]]
            precision = 1.0 / (own_error**2 + threshold**2)
            rivals = [other for other in range(len(kinds)) if template[other] == template[own]]
            square = np.array([0.5 * precision @ (means[other] - parameters[element]) ** 2 for other in rivals])
            odds = np.exp(square.min() - square)
            posterior[element] = 0.0
            posterior[element, rivals] = odds / odds.sum()
    return Match(
        elements=elements,
        templates=tuple(names),
        kind=kind,
        kind_template=template,
        values=tuple(_shared(means, template, threshold)),
        spread=tuple(spread),
        posterior=posterior,
        parameters=tuple(parameters),
        deviations=tuple(deviations),
        corner=place,
        hidden=hidden,
        reasons=reasons,
        iterations=iterations,
        seconds=clock.seconds,
    )


def _shared(means: list[Floats], template: Ints, threshold: float) -> list[Floats]:
    """Values of kinds; those that differ by less than a threshold become equal, so that kinds share them."""
    made = [each.copy() for each in means]
    for owner in np.unique(template):
        own = np.flatnonzero(template == owner).tolist()
        for parameter in range(len(means[own[0]])):
            values = np.array([[means[each][parameter]] for each in own])
            groups = replicas(np.zeros(len(own), dtype=np.int64), values, threshold)
            for group in np.unique(groups):
                mean = float(values[groups == group].mean())
                for each in np.array(own)[groups == group].tolist():
                    made[each][parameter] = mean
    return made
