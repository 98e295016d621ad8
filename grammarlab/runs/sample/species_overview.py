"""A species, or one of its trees, as plain values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.randomness import root_keys
from grammarlab.runs.sample.domains import opened_models
from grammarlab.runs.sample.shipped import RuleSource, find_rules
from grammarlab.runs.sample.species_models import SpeciesModels, num_parts, with_attributes
from grammarlab.trees.accepted_trees import accepted_rows, log_density
from grammarlab.trees.growth import grow
from grammarlab.trees.measures import MEASURES, measure
from grammarlab.trees.parameters import COLUMN, COLUMNS, DEFAULTS, HIGH, IS_INTEGER, LOW, PARAMETERS, SPREAD, Parameter
from grammarlab.trees.species import Kind, Species

_MAX_SEED = 2**64


def species_values(source: RuleSource) -> dict[str, Any]:
    """A species with all its parameters, kinds and its acceptance rule.

    Raises:
        LanguageError: If the file has errors.
    """
    species = _models(source).species
    low, high = _all_ranges(species)
    return {
        "species": species.name,
        "about": species.about,
        "acceptance": species.acceptance,
        "look": asdict(species.look),
        "parameters": [_parameter(parameter, species, low, high) for parameter in PARAMETERS.values()],
        "kinds": [
            {"weight": kind.weight, "means": kind.means, "ranges": _own_ranges(kind, low, high)}
            for kind in species.kinds
        ],
    }


def tree_values(
    argument: str, model: int, seed: int, attributes: Sequence[str] = (), assets: Path | None = None
) -> dict[str, Any]:
    """The parameters and measures of one tree, as in `grammarlab.runs.sample.run.sample_run`.

    Args:
        argument: a path, or the name of a shipped species.
        model: index of the tree under the seed, 0 <= model < 2**63.
        seed: 0 <= seed < 2**64.
        attributes: values of attributes as texts, as in `SpeciesModels.attributes`.
        assets: folder of pictures, by default the one beside the file.

    Raises:
        UsageError: If a value is out of range.
        LanguageError: If the file has errors.
    """
    source = find_rules(argument, assets)
    models = _models(source)
    check_whole("model", model, 2**63)
    check_whole("seed", seed, _MAX_SEED)
    species = with_attributes(models.species, models.attributes(attributes))
    trees = accepted_rows(species, root_keys(seed, np.array([model])))
    skeleton = grow(trees.rows, trees.keys)
    kind = species.kinds[int(trees.kind[0])]
    return {
        "species": species.name,
        "model": model,
        "seed": seed,
        "kind": int(trees.kind[0]),
        "means": kind.means,
        "tries": int(trees.tries[0]),
        "accepted": bool(trees.is_accepted[0]),
        "log_probability": float(log_density(species, trees.rows)[0]),
        "parts": int(num_parts(skeleton)[0]),
        "stems": [len(level) for level in skeleton.levels],
        "leaves": len(skeleton.leaves),
        "parameters": {
            name: number(column, value) for column, (name, value) in enumerate(zip(COLUMNS, trees.rows[0], strict=True))
        },
        "measures": dict(zip(MEASURES, measure(skeleton)[0].tolist(), strict=True)),
    }


def number(column: int, value: float) -> float | int:
    """The value of a column; of counts and choices a whole number."""
    return int(value) if IS_INTEGER[column] else float(value)


def check_whole(what: str, value: int, end: int) -> None:
    """Check that a number is at least 0 and below an end.

    Raises:
        UsageError: If it is not.
    """
    if not 0 <= value < end:
        raise UsageError(f"{what}: expected a whole number from 0 to {end - 1}, found {value}.")


def _models(source: RuleSource) -> SpeciesModels:
    return opened_models(source.suffix, source.text(), source.name, source.assets)


def _all_ranges(species: Species) -> tuple[Floats, Floats]:
    """[P] smallest start and largest end of the ranges of all kinds."""
    return (
        np.min([kind.low for kind in species.kinds], axis=0),
        np.max([kind.high for kind in species.kinds], axis=0),
    )


def _parameter(parameter: Parameter, species: Species, low: Floats, high: Floats) -> dict[str, Any]:
    column = COLUMN[parameter.name]
    values: dict[str, Any] = {
        "name": parameter.name,
        "value": number(column, species.typical[column]),
        "range": [number(column, ends[column]) for ends in (low, high)],
        "unit": parameter.unit,
        "limits": [number(column, ends[column]) for ends in (LOW, HIGH)],
        "default": number(column, DEFAULTS[column]),
        "meaning": parameter.why,
        "why": species.why.get(parameter.name, ""),
    }
    if parameter.spread is not None:
        spread = COLUMN[parameter.name + SPREAD]
        values |= {"spread": float(species.typical[spread]), "spread_range": [low[spread].item(), high[spread].item()]}
    return values


def _own_ranges(kind: Kind, low: Floats, high: Floats) -> dict[str, list[float | int]]:
    """Ranges of a kind that are narrower than those of all kinds together."""
    narrower = np.flatnonzero((kind.low != low) | (kind.high != high))
    return {
        COLUMNS[column]: [number(column, kind.low[column]), number(column, kind.high[column])]
        for column in narrower.tolist()
    }
