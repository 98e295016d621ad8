"""Rows of models without their geometry: what their derivations drew, made and reported.

Columns of all models: seed, model (index under the seed), footprint (index, if there are several), log_density (natural
logarithm of the density of all draws, or null), tries and accepted (candidates of an acceptance rule).

Columns of models of rule files:
    shapes: number of nodes of the derivation tree.
    count.SYMBOL: number of shapes of a symbol.
    draws: list of site (index into the list of sites), value and log_density, in the order of the derivation.
    reports: list of key, count, sum, min and max, keys in alphabetical order.

Columns of trees: kind (index into the list of kinds), heading (radians), position.x, .y and .z (metres), and the
parameters by name, as ``parameter.NAME``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from grammarlab.arrays import Flags, Ints, offsets_from_counts
from grammarlab.derivation.forest import Forest, MissingAsset, Reports
from grammarlab.errors import Finding
from grammarlab.runs.sample.request import SampleRequest

FORMAT = 1
"""Version of the columns above."""


@dataclass(frozen=True, kw_only=True)
class ModelRows:
    """Consecutive models of a run."""

    columns: Mapping[str, pa.Array]
    """[n] each, those of all models not included (`table_of`)."""
    log_density: pa.Array
    """[n] float64, null where it is unknown."""
    tries: Ints
    """[n] number of candidates."""
    accepted: Flags
    """[n] whether a candidate was accepted."""
    num_shapes: int = 0
    """Number of shapes of all models; 0 if they take little memory."""
    prints: tuple[str, ...] = ()
    missing_assets: tuple[MissingAsset, ...] = ()
    warnings: tuple[Finding, ...] = ()


def table_of(request: SampleRequest, first_model: int, rows: ModelRows) -> pa.Table:
    """Rows as a table with the columns of all models.

    Args:
        request: the request of the run.
        first_model: index of the first row under the seed.
        rows: the rows.
    """
    count = len(rows.tries)
    model = np.arange(first_model, first_model + count, dtype=np.uint64)
    columns = {"seed": pa.array(np.full(count, request.seed, np.uint64)), "model": pa.array(model)}
    if len(request.footprints) > 1:
        columns["footprint"] = pa.array((model // np.uint64(request.num_models)).astype(np.int32))
    columns |= {
        "log_density": rows.log_density,
        "tries": pa.array(rows.tries.astype(np.int32)),
        "accepted": pa.array(rows.accepted),
    }
    return pa.table({**columns, **rows.columns})


def forest_rows(forest: Forest, tries: Ints, accepted: Flags) -> ModelRows:
    """The models of a forest.

    Args:
        forest: the forest of n models.
        tries: [n] number of candidates.
        accepted: [n] whether a candidate was accepted.
    """
    return ModelRows(
        columns=forest_columns(forest),
        num_shapes=len(forest.nodes),
        log_density=pa.array(forest.log_probability()),
        tries=tries,
        accepted=accepted,
        prints=forest.prints,
        missing_assets=forest.missing_assets,
        warnings=forest.warnings,
    )


def forest_columns(forest: Forest) -> dict[str, pa.Array]:
    """Columns of the models of a forest."""
    num_models, num_symbols = forest.num_models, len(forest.symbols)
    pair = forest.nodes.model.astype(np.int64) * num_symbols + forest.nodes.symbol
    counts = np.bincount(pair, minlength=num_models * num_symbols).reshape(num_models, num_symbols).astype(np.int32)
    return {
        "shapes": pa.array(forest.shapes_per_model().astype(np.int32)),
        **{f"count.{symbol}": pa.array(counts[:, k].copy()) for k, symbol in enumerate(forest.symbols)},
        "draws": _draws(forest),
        "reports": _reports(forest.reports, forest.nodes.model[forest.reports.node].astype(np.int64), num_models),
    }


def _draws(forest: Forest) -> pa.Array:
    draws = forest.draws
    model = forest.nodes.model[draws.node]
    order = np.argsort(model, kind="stable")
    fields = {"site": draws.site[order].astype(np.int32), "value": draws.value[order]}
    fields["log_density"] = draws.log_density[order]
    return _lists(np.bincount(model, minlength=forest.num_models), {name: pa.array(v) for name, v in fields.items()})


def _reports(reports: Reports, model: Ints, num_models: int) -> pa.Array:
    """Summaries by model and key; a value that is not a number makes those of its key NaN."""
    names = np.array(sorted(reports.keys), dtype=object)
    rank = np.argsort(np.argsort(np.array(reports.keys, dtype=object))) if len(names) else np.zeros(0, np.int64)
    group = model * max(len(names), 1) + rank[reports.key]
    order = np.argsort(group, kind="stable")
    groups, starts, counts = np.unique(group[order], return_index=True, return_counts=True)
    values = reports.value[order]
    summaries = {
        name: ufunc.reduceat(values, starts) if len(starts) else np.zeros(0)
        for name, ufunc in (("sum", np.add), ("min", np.minimum), ("max", np.maximum))
    }
    keys = pa.DictionaryArray.from_arrays(groups % max(len(names), 1), pa.array(names.tolist(), pa.string()))
    fields = {"key": keys.cast(pa.string()), "count": pa.array(counts.astype(np.int32))}
    per_model = np.bincount(groups // max(len(names), 1), minlength=num_models)
    return _lists(per_model, fields | {name: pa.array(values) for name, values in summaries.items()})


def _lists(counts: Ints, fields: Mapping[str, pa.Array]) -> pa.Array:
    """Lists of records, of a given length for each row."""
    records = pa.StructArray.from_arrays(list(fields.values()), names=list(fields))
    return pa.ListArray.from_arrays(pa.array(offsets_from_counts(counts).astype(np.int32)), records)
