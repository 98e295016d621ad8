"""The models that labels are about, derived again from their addresses."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.program import Program
from grammarlab.derivation.selection import select_models
from grammarlab.errors import UsageError
from grammarlab.evaluation.flattening import flattened, flattened_hash
from grammarlab.features.stripping import without_geometry
from grammarlab.geometry.assets import AssetFolder
from grammarlab.language.grammar import Grammar
from grammarlab.preference.labels import Label, Labels
from grammarlab.runs.attributes import fit_properties
from grammarlab.runs.footprints import read_footprints

MAX_MODELS = 20_000
"""Different models that labels may be about."""
_GAP = 48
"""Models between two labelled ones that are derived along rather than starting anew."""


@dataclass(frozen=True, slots=True)
class LabelledModels:
    """Labels with the derivations of their models."""

    forests: tuple[Forest, ...]
    """Every labelled model once, without geometry."""
    model: NDArray[np.int64]
    """[labels] the model of each label, counted through all forests."""


def labelled_models(labels: Labels, grammar: Grammar, assets: Path | None) -> LabelledModels:
    """Derives the models that labels are about.

    Args:
        labels: of models of the grammar, or of the grammar with equal percentages (`flattened_hash`).
        grammar: what they should be about.
        assets: folder of meshes and images.

    Raises:
        UsageError: when there are none or too many, or they are about another grammar; says how to go on.
        DerivationError: when a model cannot be derived.
    """
    if not len(labels):
        raise UsageError("there are no labels: score some models first, such as with grammarlab label.")
    programs = {grammar.hash: compile_grammar(grammar), flattened_hash(grammar): flattened(grammar).program}
    _check_grammar(labels, grammar, tuple(programs))
    groups: dict[tuple[Any, ...], dict[int, int]] = {}
    for label in labels:
        *batch, model = label.address
        groups.setdefault(tuple(batch), {})[model] = -1
    total = sum(map(len, groups.values()))
    if total > MAX_MODELS:
        raise UsageError(f"the labels are about {total:,} models; {MAX_MODELS:,} can be learned from. Split the file.")
    folder = None if assets is None else AssetFolder(assets)
    forests: list[Forest] = []
    done = 0
    for (text_hash, start, attributes, footprint, seed), found in groups.items():
        options = _options(grammar, start, attributes, footprint)
        for models in _runs(sorted(found)):
            forests.append(_derived(programs[text_hash], seed, models, options | {"assets": folder}))
            found |= {model: done + i for i, model in enumerate(models)}
            done += len(models)
    return LabelledModels(tuple(forests), np.array([_place(groups, label) for label in labels], dtype=np.int64))


def _place(groups: dict[tuple[Any, ...], dict[int, int]], label: Label) -> int:
    *batch, model = label.address
    return groups[tuple(batch)][model]


def _check_grammar(labels: Labels, grammar: Grammar, known: Sequence[str]) -> None:
    foreign = [label.grammar for label in labels if label.grammar not in known]
    if foreign:
        raise UsageError(
            f"{len(foreign):,} of {len(labels):,} labels are about another grammar: expected the grammar "
            f"{grammar.hash[:16]}… of {grammar.file}, found {foreign[0][:16]}…. The rule file has changed since the "
            "models were scored, or it is another one. Learn from the rule file that was scored (the beginning of its "
            "SHA-256 tells it), or score models of this one anew."
        )


def _options(grammar: Grammar, start: str, attributes: str, footprint: str) -> dict[str, Any]:
    """Arguments of `derive` that the address of a label states."""
    options: dict[str, Any] = {}
    if start:
        raise UsageError(
            f"labels of models that begin with {start} cannot be learned from: mark it @StartRule in the rule file, "
            "and score models of that file."
        )
    if attributes != "{}":
        values = json.loads(attributes)
        unknown = [name for name in values if name not in grammar.attributes]
        if unknown:
            raise UsageError(f"labels give a value to {unknown[0]}, which is no attribute of the grammar.")
        options["attributes"] = fit_properties(values, grammar)
    if footprint:
        # A label file says no more than where models come from: it never makes us read other files.
        if footprint.lower().endswith(".json") or footprint.lower().endswith(".geojson") or Path(footprint).exists():
            raise UsageError(f"footprint {footprint!r} of a label is a file; expected 20x12 or WKT.")
        found = read_footprints(footprint)
        if len(found) != 1:
            raise UsageError(f"footprint {footprint[:60]!r} of a label has {len(found)} polygons; expected one.")
        options["footprint"] = found[0].polygon
    return options


def _runs(models: Sequence[int]) -> Iterator[list[int]]:
    """Ascending numbers, cut where there is a wide gap."""
    run: list[int] = []
    for model in models:
        if run and model - run[-1] > _GAP:
            yield run
            run = []
        run.append(model)
    yield run


def _derived(program: Program, seed: int, models: list[int], options: dict[str, Any]) -> Forest:
    first = models[0]
    forest = derive(program, models[-1] - first + 1, seed, first_model=first, **options)
    return without_geometry(select_models(forest, np.array(models) - first))
