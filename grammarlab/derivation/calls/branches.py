"""Choices over columns: the branch of a ``case`` or ``N%`` list that each shape takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.state.shapes import ARRAY, NUM_LANES, SITE_LANE, Shapes, Value, kind_of, number_column
from grammarlab.derivation.state.workspace import Code, Workspace
from grammarlab.errors import DerivationError, Location
from grammarlab.language.checking.percentages import weights_of_percentages
from grammarlab.randomness import uniforms

_Payload = TypeVar("_Payload")
Rows: TypeAlias = "NDArray[np.int64] | None"
"""Rows among the shapes of a choice; None for all of them."""


@dataclass(frozen=True, slots=True)
class Leaf(Generic[_Payload]):
    """The end of a choice."""

    payload: _Payload


@dataclass(frozen=True, slots=True)
class CaseChoice(Generic[_Payload]):
    """Conditions tried in order; None is ``else``."""

    conditions: tuple[Code | None, ...]
    branches: tuple[Branching[_Payload], ...]
    location: Location


@dataclass(frozen=True, slots=True)
class RandomChoice(Generic[_Payload]):
    """Percentages; None is ``else``, which has the rest to 100."""

    percentages: tuple[Code | None, ...]
    branches: tuple[Branching[_Payload], ...]
    address: int
    site: int
    location: Location


Branching: TypeAlias = Leaf[_Payload] | CaseChoice[_Payload] | RandomChoice[_Payload]


def route(
    choice: Branching[_Payload], shapes: Shapes, workspace: Workspace, rows: Rows = None
) -> Iterator[tuple[_Payload, Rows, Shapes]]:
    """Leaves of a choice, each with the rows and shapes that reach it.

    Shapes reach no leaf if no condition holds and there is no ``else``.
    """
    if isinstance(choice, Leaf):
        yield choice.payload, rows, shapes
    elif isinstance(choice, CaseChoice):
        yield from _route_case(choice, shapes, workspace, rows)
    else:
        yield from _route_random(choice, shapes, workspace, rows)


def _route_case(
    choice: CaseChoice[_Payload], shapes: Shapes, workspace: Workspace, rows: Rows
) -> Iterator[tuple[_Payload, Rows, Shapes]]:
    for condition, branch in zip(choice.conditions, choice.branches, strict=True):
        truth = True if condition is None else _truth(condition(shapes, workspace), choice.location)
        if not isinstance(truth, np.ndarray):
            if truth:
                yield from route(branch, shapes, workspace, rows)
                return
            continue
        chosen = np.flatnonzero(truth)
        if len(chosen) == len(truth):
            yield from route(branch, shapes, workspace, rows)
            return
        if len(chosen):
            yield from route(branch, shapes.take(chosen), workspace, _compose(rows, chosen))
            remaining = np.flatnonzero(~truth)
            shapes, rows = shapes.take(remaining), _compose(rows, remaining)


def _route_random(
    choice: RandomChoice[_Payload], shapes: Shapes, workspace: Workspace, rows: Rows
) -> Iterator[tuple[_Payload, Rows, Shapes]]:
    branch_indices = _draw(choice, shapes, workspace)
    first = branch_indices[0]
    if (branch_indices == first).all():
        yield from route(choice.branches[first], shapes, workspace, rows)
        return
    for index, branch in enumerate(choice.branches):
        chosen = np.flatnonzero(branch_indices == index)
        if len(chosen):
            yield from route(branch, shapes.take(chosen), workspace, _compose(rows, chosen))


def _draw(choice: RandomChoice[_Payload], shapes: Shapes, workspace: Workspace) -> NDArray[np.int64]:
    """The branch [N] each shape takes; the draw is recorded."""
    weights = _weights(choice, shapes, workspace)
    cumulative = np.cumsum(weights, axis=-1)
    total = cumulative[..., -1:]
    threshold = uniforms(shapes.random_key(), NUM_LANES * choice.address + SITE_LANE)
    with np.errstate(divide="ignore"):
        log_density = np.log(weights / total)
    if weights.ndim == 1:
        branch_indices = np.minimum(np.searchsorted(cumulative, threshold * total, side="right"), len(weights) - 1)
        densities = log_density[branch_indices]
    else:
        branch_indices = np.minimum((cumulative <= threshold[:, None] * total).sum(axis=1), weights.shape[1] - 1)
        densities = log_density[np.arange(len(branch_indices)), branch_indices]
    workspace.recorder.add_draw(shapes, choice.site, branch_indices.astype(np.float64), densities)
    return branch_indices


def _weights(choice: RandomChoice[_Payload], shapes: Shapes, workspace: Workspace) -> Floats:
    """Weights [B] of the branches, or [N, B] where they differ between shapes; their sums are finite.

    Raises:
        DerivationError: If a percentage is negative or not finite, or all are zero.
    """
    values: list[float | Floats] = []
    for code in choice.percentages:
        value = 0.0 if code is None else code(shapes, workspace)
        if kind_of(value) in ("string", ARRAY):
            raise DerivationError(f"expected a percentage, found a {kind_of(value)}", choice.location)
        values.append(value if isinstance(value, np.ndarray) else float(value))  # type: ignore[arg-type, ty:invalid-argument-type]
    if any(isinstance(value, np.ndarray) for value in values):
        percentages = np.stack([number_column(value, shapes.num) for value in values], axis=1)
    else:
        percentages = np.array(values)
    invalid = percentages[~(np.isfinite(percentages) & (percentages >= 0.0))]
    if len(invalid):
        raise DerivationError(f"expected finite percentages of at least 0, found {invalid[0]:g}", choice.location)
    with np.errstate(over="ignore"):
        weights = weights_of_percentages(percentages, choice.percentages[-1] is None)
        total = weights.sum(axis=-1, keepdims=True)
    if not (total > 0.0).all():
        raise DerivationError("expected a percentage above 0, found only 0", choice.location)
    if np.isfinite(total).all():
        return weights
    return np.where(np.isfinite(total), weights, weights / weights.max(axis=-1, keepdims=True))


def _truth(value: Value, location: Location) -> bool | NDArray[np.bool_]:
    if isinstance(value, np.ndarray) and value.dtype.kind == "b":
        return value  # type: ignore[return-value, ty:invalid-explicit-return]
    if isinstance(value, bool):
        return value
    raise DerivationError(f"expected a condition that is true or false, found a {kind_of(value)}", location)


def _compose(rows: Rows, chosen: NDArray[np.int64]) -> NDArray[np.int64]:
    return chosen if rows is None else rows[chosen]
