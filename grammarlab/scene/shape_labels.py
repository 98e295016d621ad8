"""Labels of a scene: what its instances and models are called in files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.lots import Values


@dataclass(frozen=True, slots=True)
class ShapeLabels:
    """Symbols of I instances, and values of the models of their scene."""

    symbols: tuple[str, ...]
    symbol: NDArray[np.int32]
    """[I] index into `symbols`."""
    line: NDArray[np.int32]
    """[I] line in the rule file, from 1, of the rule that made the instance; 0 if it is the initial shape."""
    attributes: Mapping[str, Values]
    """[num_models] values by name of attributes and constants."""
    reports: Mapping[str, Floats]
    """[num_models] sum of the reported values of each key, NaN for a model without any."""

    def take(self, rows: slice | NDArray[np.integer] | NDArray[np.bool_]) -> ShapeLabels:
        """Labels of selected instances, with the values of all models."""
        return ShapeLabels(self.symbols, self.symbol[rows], self.line[rows], self.attributes, self.reports)

    def of_models(self, models: slice | NDArray[np.integer]) -> ShapeLabels:
        """The same instances with the values of selected models."""
        attributes = {name: column[models] for name, column in self.attributes.items()}
        reports = {name: column[models] for name, column in self.reports.items()}
        return ShapeLabels(self.symbols, self.symbol, self.line, attributes, reports)


def labels_of(forest: Forest, leaves: NDArray[np.integer]) -> ShapeLabels:
    """Labels of the leaves of a forest at some rows.

    Args:
        forest: the forest.
        leaves: [I] rows of `Forest.leaves`.
    """
    nodes, node = forest.nodes, forest.leaves.node[leaves]
    line_of_rule = np.array([*(rule.line for rule in forest.rules), 0], dtype=np.int32)
    parent = nodes.parent[node]
    rule = np.where(parent < 0, -1, nodes.rule[parent])
    return ShapeLabels(
        symbols=forest.symbols,
        symbol=nodes.symbol[node].astype(np.int32),
        line=line_of_rule[rule],
        attributes=forest.attributes,
        reports=_report_sums(forest),
    )


def joined_labels(parts: list[ShapeLabels | None]) -> ShapeLabels | None:
    """Labels of the instances of several scenes, in order, without values of models; None if a scene has none."""
    labels = [part for part in parts if part is not None]
    if len(labels) < len(parts):
        return None
    symbols = tuple(dict.fromkeys(symbol for part in labels for symbol in part.symbols))
    number = {symbol: index for index, symbol in enumerate(symbols)}
    renamed = [np.array([number[symbol] for symbol in part.symbols], np.int32)[part.symbol] for part in labels]
    return ShapeLabels(symbols, np.concatenate(renamed), np.concatenate([part.line for part in labels]), {}, {})


def _report_sums(forest: Forest) -> dict[str, Floats]:
    reports = forest.reports
    model, is_in_statistics = forest.nodes.model[reports.node], forest.is_in_statistics()
    sums = {}
    for index, key in enumerate(reports.keys):
        rows = np.flatnonzero((reports.key == index) & is_in_statistics)
        counts = np.bincount(model[rows], minlength=forest.num_models)
        totals = np.bincount(model[rows], reports.value[rows], forest.num_models)
        sums[key] = np.where(counts > 0, totals, np.nan)
    return sums
