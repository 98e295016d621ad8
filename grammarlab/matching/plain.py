"""Matches from labels without evidence, the choice of templates, and agreement of kinds with the ground truth.

Labels are those of the paper's loop, of single fits, and of k-means. As few templates are used as explain the elements,
each at a cost.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
from scipy.optimize import linear_sum_assignment

from grammarlab.arrays import Floats, Ints
from grammarlab.matching.elements import Clouds, Elements, Truth, clouds_of, too_poor
from grammarlab.matching.fit import Fits, background_cost, fit_all
from grammarlab.matching.match import SURE, UNKNOWN, Clock, Match
from grammarlab.matching.match_assembly import replicas, similarity_threshold
from grammarlab.matching.template import Template, stack

_NO_FIT = "no template fits it better than random points in its box"
"""Reason of an element without a template."""
_OCCLUSION_COST = 4.0
"""Cost of an occluding half-plane, nats."""
_MIN_GAIN = 6.0
"""Least gain of a template over points that are uniform in the box, nats."""
_MIN_INLIER_SHARE = 0.5
"""Least fraction of inliers of a fit."""
_TEMPLATE_COST = 4.0
"""Cost of a template, as a multiple of the logarithm of the number of elements."""
_MAX_SIZE_RATIO = 2.0
"""Ratio to the largest template from which the unit is in doubt."""
_MAX_KINDS = 12
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
    indices = np.array([element for element in range(len(elements)) if element not in reasons], dtype=np.int64)
    clouds = clouds_of(elements, indices)
    fits = fit_all(clouds, stack(templates))
    costs = description(clouds, templates, fits)
    fine = costs.argmin(axis=1) < len(templates)
    reasons |= unfit(clouds, templates, ~fine)
    indices, fits, costs = indices[fine], fits.subset(fine), costs[fine, :-1]
    rows = np.arange(len(indices))
    owner = costs.argmin(axis=1) if len(indices) else np.zeros(0, dtype=np.int64)
    if kinds is not None and len(indices):
        owner = np.full(len(indices), np.bincount(owner).argmax())
    values, corner = fits.parameters[rows, owner], fits.corner[rows, owner]
    clock.lap("fitting")
    if kinds is None:
        threshold = similarity_threshold(elements)
        kind = replicas(owner, values, threshold)
    else:
        kind = _clustered(values[:, : len(templates[int(owner[0])].parameters)], kinds) if len(indices) else owner
    clock.lap("kinds")
    return from_labels(
        elements, templates, indices, kind, owner, values, corner, fits, reasons, iterations=1, clock=clock
    )


def description(clouds: Clouds, templates: Sequence[Template], fits: Fits) -> Floats:
    """[N, T + 1] description length of each element by each template, and by none last, nats."""
    points = clouds.weight.sum(axis=1)
    number = np.array([len(template.parameters) for template in templates])
    cost = fits.cost + 0.5 * number * np.log(np.maximum(points, 2.0))[:, None] + _OCCLUSION_COST * (fits.hidden > 0.0)
    cost = np.where(fits.inside < _MIN_INLIER_SHARE, 1e6, cost)
    return np.concatenate([cost, background_cost(clouds)[:, None] - _MIN_GAIN], axis=1)


def unfit(clouds: Clouds, templates: Sequence[Template], is_unfit: np.ndarray) -> dict[int, str]:
    """Reasons why no template fits the elements of a mask [N]."""
    low, high = (np.array([getattr(template, end)[:2] for template in templates]) for end in ("low", "high"))
    size = clouds.reach[:, 1] - clouds.reach[:, 0]
    reasons = {}
    for index in np.flatnonzero(is_unfit).tolist():
        reasons[int(clouds.element[index])] = _NO_FIT
        too_large = (size[index] > _MAX_SIZE_RATIO * high.max(axis=0)).any()
        if too_large or (size[index] < low.min(axis=0) / _MAX_SIZE_RATIO).all():
            across, up = size[index].tolist()
            reasons[int(clouds.element[index])] = (
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
    indices: Ints,
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
        indices: [M] indices of the labelled elements.
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
    names = [templates[index] for index in used.tolist()]
    kinds = [np.flatnonzero(label == value) for value in np.unique(label)]
    kinds.sort(key=lambda members: (int(np.searchsorted(used, owner[members[0]])), -len(members), int(members[0])))
    template = np.array([int(np.searchsorted(used, owner[members[0]])) for members in kinds], dtype=np.int64)
    size = [len(names[index].parameters) for index in template.tolist()]
    means = [values[members, :count].mean(axis=0) for members, count in zip(kinds, size, strict=True)]
    rows = np.arange(len(indices))
    covariance = fits.covariance[rows, owner]
    spread = [
        np.sqrt(
            np.array([np.diag(covariance[member])[:count] for member in members]).mean(axis=0) / len(members)
            + elements.common_error**2
        )
        for members, count in zip(kinds, size, strict=True)
    ]
    kind = np.full(number, UNKNOWN, dtype=np.int64)
    parameters: list[Floats] = [np.zeros(0)] * number
    deviations: list[Floats] = [np.zeros(0)] * number
    corners, hidden = elements.low.copy(), np.zeros(number)
    middle = (elements.low + elements.high) / 2
    posterior = np.zeros((number, len(kinds) + 1))
    posterior[:, -1] = 1.0
    threshold = similarity_threshold(elements)
    for kind_index, members in enumerate(kinds):
        for row in members.tolist():
            element = int(indices[row])
            kind[element] = kind_index
            parameters[element] = values[row, : size[kind_index]]
            error = np.sqrt(np.diag(covariance[row])[: size[kind_index]])
            deviations[element] = np.hypot(error, elements.common_error)
            corners[element] = middle[element] + corner[row]
            hidden[element] = fits.hidden[row, owner[row]]
            precision = 1.0 / (error**2 + threshold**2)
            rivals = [other for other in range(len(kinds)) if template[other] == template[kind_index]]
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
        corner=corners,
        hidden=hidden,
        reasons=reasons,
        iterations=iterations,
        seconds=clock.seconds,
    )


def used_templates(costs: Floats) -> Ints:
    """Indices of the templates with the shortest description of all elements, ascending; empty if none fits.

    Greedy: the best one is added, removed or exchanged as long as that shortens the description.
    """
    price = _TEMPLATE_COST * np.log(len(costs) + 1.0)
    number = costs.shape[1] - 1
    used: frozenset[int] = frozenset()
    best = _total(costs, used, price)
    while True:
        steps = [used ^ {template} for template in range(number)]
        steps += [(used - {old}) | {new} for old in used for new in range(number) if new not in used]
        totals = [_total(costs, step, price) for step in steps]
        index = int(np.argmin(totals))
        if totals[index] >= best - 1e-9:
            return np.array(sorted(used), dtype=np.int64)
        used, best = steps[index], totals[index]


def compare(match: Match, truth: Truth) -> dict[str, Any]:
    """Adjusted mutual information, number of mislabelled elements, and correct ones among the sure results.

    Kinds of match and truth are paired so that most elements agree; elements of other pairs are mislabelled.
    """
    from sklearn.metrics import adjusted_mutual_info_score  # noqa: PLC0415 scikit-learn takes a second to load

    right, labels = agreeing(match, truth)
    sure = (match.probability >= SURE) & (match.kind != UNKNOWN)
    return {
        "adjusted_mutual_information": float(adjusted_mutual_info_score(truth.kind, labels)),
        "mislabelled": int((~right).sum()),
        "kinds": len(np.unique(truth.kind)),
        "kinds_found": len(match.values),
        "sure": int(sure.sum()),
        "sure_and_right": int((sure & right).sum()),
    }


def agreeing(match: Match, truth: Truth) -> tuple[np.ndarray, Ints]:
    """[N] whether the kind of each element is correct, and [N] its kind; unknown elements have a kind of their own."""
    labels = np.where(match.kind == UNKNOWN, match.kind.max() + 1, match.kind)
    table = np.zeros((labels.max() + 1, truth.kind.max() + 1))
    np.add.at(table, (labels, truth.kind), 1.0)
    table[match.kind.max() + 1 :] = 0.0
    rows, columns = linear_sum_assignment(-table)
    partner = np.full(len(table), -1)
    partner[rows] = columns
    right = (partner[labels] == truth.kind) & (match.kind != UNKNOWN)
    return right, labels


def _clustered(values: Floats, kinds: int) -> Ints:
    from sklearn.cluster import KMeans  # noqa: PLC0415 scikit-learn takes a second to load
    from sklearn.metrics import silhouette_score  # noqa: PLC0415

    number = len(np.unique(values, axis=0))

    def cluster(count: int) -> Ints:
        return KMeans(min(count, number), n_init=cast("Any", 10), random_state=0).fit_predict(values).astype(np.int64)

    if kinds:
        return cluster(kinds)
    labellings = [cluster(count) for count in range(2, min(_MAX_KINDS, number - 1) + 1)]
    return max(
        labellings, key=lambda labels: silhouette_score(values, labels), default=np.zeros(len(values), dtype=np.int64)
    )


def _shared(means: list[Floats], template: Ints, threshold: float) -> list[Floats]:
    """Values of kinds; those that differ by less than a threshold become equal, so that kinds share them."""
    shared = [mean.copy() for mean in means]
    for owner in np.unique(template):
        members = np.flatnonzero(template == owner).tolist()
        for parameter in range(len(means[members[0]])):
            values = np.array([[means[member][parameter]] for member in members])
            groups = replicas(np.zeros(len(members), dtype=np.int64), values, threshold)
            for group in np.unique(groups):
                mean = float(values[groups == group].mean())
                for member in np.array(members)[groups == group].tolist():
                    shared[member][parameter] = mean
    return shared


def _total(costs: Floats, used: frozenset[int], price: float) -> float:
    return float(costs[:, [*sorted(used), -1]].min(axis=1).sum() + price * len(used))
