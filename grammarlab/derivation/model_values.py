"""Values of models by name: attributes, and what rules report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, Literal, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.lots import Values
from grammarlab.derivation.state.shapes import Value
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.derivation.strings import StringTable
from grammarlab.errors import DerivationError, UsageError, check_type

Statistic: TypeAlias = Literal["sum", "mean", "min", "max", "count"]
"""What becomes of several values that one model reports with one key."""

_EXAMPLE = "gl.derive(grammar, 100, seed=1)"


def attribute(forest: Forest, name: str) -> NDArray[Any]:
    """The values [models] of an attribute or constant: numbers, truth values or texts.

    Args:
        forest: the models, as `derive` made them.
        name: name of the attribute. Where rules set another value for a part of a model, it is the one before.

    Raises:
        UsageError: If the grammar has no attribute of that name; it names the nearest. Also if the value of the
            attribute is an array, or cannot be evaluated.

    >>> import grammarlab as gl
    >>> grammar = gl.Grammar.parse("attr h = rand(3, 9)  attr storeys = floor(h / 3)  Lot --> extrude(h)")
    >>> forest = gl.derive(grammar, 4, seed=1)
    >>> gl.attribute(forest, "storeys").tolist()
    [1.0, 2.0, 2.0, 1.0]
    """
    check_type("forest", forest, Forest, _EXAMPLE)
    if name not in forest.attributes:
        if not forest.attributes:
            raise UsageError(f"the models have no attributes, so none is called {name!r:.80}.")
        raise UsageError(f"the models have no attribute {_unknown(name, list(forest.attributes))}")
    return forest.attributes[name]


def report(forest: Forest, key: str, statistic: Statistic = "sum") -> Floats:
    """What the rules of models report with a key, as a column [models].

    Args:
        forest: the models.
        key: key of the operation ``report(key, value)``.
        statistic: ``sum`` (0 for a model without the key) or ``count`` (also 0) of the values of a model; or their
            ``mean``, ``min`` or ``max`` (NaN for a model without the key). Truth values count 0 and 1, texts NaN; a key
            of a model that has numbers as well has the statistics of the numbers.

    Raises:
        UsageError: If no model reports the key; it names the nearest. Also if the statistic is unknown.

    >>> import grammarlab as gl
    >>> grammar = gl.Grammar.parse('Lot --> A A  A --> 50% : s(2, 0, 3) report("area", geometry.area) X else : NIL')
    >>> forest = gl.derive(grammar, 4, seed=1)
    >>> gl.report(forest, "area").tolist(), gl.report(forest, "area", "count").tolist()
    ([0.0, 6.0, 6.0, 6.0], [0.0, 1.0, 1.0, 1.0])
    """
    check_type("forest", forest, Forest, _EXAMPLE)
    reports = forest.reports
    if statistic not in get_args(Statistic):
        raise UsageError(f"statistic: expected one of {', '.join(get_args(Statistic))}, found {statistic!r:.80}.")
    if key not in reports.keys:
        if not reports.keys:
            raise UsageError(f"no model reports anything, so nothing is called {key!r:.80}.")
        raise UsageError(f"no model reports {_unknown(key, reports.keys)}")
    is_taken = reports.key == reports.keys.index(key)
    rows = np.flatnonzero(is_taken if statistic == "count" else is_taken & forest.is_in_statistics())
    model, values = forest.nodes.model[reports.node[rows]], reports.value[rows]
    num = np.bincount(model, minlength=forest.num_models).astype(np.float64)
    if statistic == "count":
        return num
    if statistic in ("sum", "mean"):
        total = np.bincount(model, weights=values, minlength=forest.num_models).astype(np.float64)
        return total if statistic == "sum" else np.divide(total, num, out=np.full_like(num, np.nan), where=num > 0.0)
    extreme, neutral = (np.minimum, np.inf) if statistic == "min" else (np.maximum, -np.inf)
    column = np.full(forest.num_models, neutral)
    with np.errstate(invalid="ignore"):  # texts are NaN
        extreme.at(column, model, values)
    return np.where(num > 0.0, column, np.nan)


def attributes_of_models(workspace: Workspace) -> Mapping[str, Values]:
    """`Forest.attributes` after a derivation.

    What no rule reads is evaluated here, so that the result does not depend on the rules that some batch happened to
    apply; it is left out if it cannot be evaluated.
    """
    columns: dict[str, Values] = {}
    for name in workspace.attributes if workspace.roots.num else ():
        try:
            with np.errstate(all="ignore"):
                value = workspace.attribute(name)
        except DerivationError:
            continue
        column = _column(value, workspace.roots.num, workspace.strings)
        if column is not None:
            columns[name] = column
    return columns


def _column(value: Value, count: int, strings: StringTable) -> Values | None:
    """A value as a column [count]; None for arrays."""
    if not isinstance(value, np.ndarray):
        return np.broadcast_to(np.array(value), count)
    if value.dtype == np.int32:
        different, inverse = np.unique(value, return_inverse=True)
        return np.array([strings[index] for index in different.tolist()], dtype=np.str_)[inverse]
    return None if value.dtype == np.uint32 else cast("Values", value)


def _unknown(name: str, names: Sequence[str]) -> str:
    near = get_close_matches(name, names, n=3, cutoff=0.6)
    if near:
        return f"{name!r:.80}; did you mean {' or '.join(map(repr, near))}?"
    return f"{name!r:.80}; expected one of {', '.join(names[:12])}{', …' if len(names) > 12 else ''}."
