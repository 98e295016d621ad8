"""The models that labels are about, derived again from their addresses."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive_chunks
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.lots import DEFAULT_FOOTPRINT, Footprint, Lots
from grammarlab.errors import UsageError
from grammarlab.evaluation.flattening import flattened, flattened_hash
from grammarlab.features.stripping import without_geometry
from grammarlab.geometry.assets import AssetFolder
from grammarlab.language.grammar import Grammar
from grammarlab.preference.labels import Labels
from grammarlab.runs.attributes import fit_properties
from grammarlab.runs.footprints import read_footprints
from grammarlab.runs.request import AttributeValue

MAX_MODELS = 20_000
"""Different models that labels may be about."""


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
    groups: dict[tuple[Any, ...], set[int]] = {}
    for label in labels:
        *batch, model = label.address
        groups.setdefault(tuple(batch), set()).add(model)
    total = sum(map(len, groups.values()))
    if total > MAX_MODELS:
        raise UsageError(f"the labels are about {total:,} models; {MAX_MODELS:,} can be learned from. Split the file.")
    folder = None if assets is None else AssetFolder(assets)
    forests: list[Forest] = []
    place: dict[tuple[Any, ...], int] = {}
    for text_hash in dict.fromkeys(batch[0] for batch in groups):
        lots = []
        for batch, models in groups.items():
            if batch[0] == text_hash:
                lots.append(_lots(grammar, batch, sorted(models)))
                place |= {(*batch, model): len(place) + i for i, model in enumerate(sorted(models))}
        chunks = derive_chunks(programs[text_hash], Lots.concatenate(lots), assets=folder)
        forests += [without_geometry(forest) for forest in chunks]
    return LabelledModels(tuple(forests), np.array([place[label.address] for label in labels], dtype=np.int64))


def _check_grammar(labels: Labels, grammar: Grammar, known: Sequence[str]) -> None:
    foreign = [label.grammar for label in labels if label.grammar not in known]
    if foreign:
        raise UsageError(
            f"{len(foreign):,} of {len(labels):,} labels are about another grammar: expected the grammar "
            f"{grammar.hash[:16]}… of {grammar.file}, found {foreign[0][:16]}…. The rule file has changed since the "
            "models were scored, or it is another one. Learn from the rule file that was scored (the beginning of its "
            "SHA-256 tells it), or score models of this one anew."
        )


def _lots(grammar: Grammar, batch: tuple[Any, ...], models: Sequence[int]) -> Lots:
    """Models whose labels state all but the index alike: hash, start rule, attributes, footprint and seed."""
    _, start_rule, attributes, footprint, seed = batch
    values: dict[str, AttributeValue] = {}
    if attributes != "{}":
        values = json.loads(attributes)
        unknown = [name for name in values if name not in grammar.attributes]
        if unknown:
            raise UsageError(f"labels give a value to {unknown[0]}, which is no attribute of the grammar.")
        values = fit_properties(values, grammar)
    polygon = _polygon(footprint) if footprint else DEFAULT_FOOTPRINT
    return Lots.at(np.full(len(models), seed, np.uint64), models, polygon, values, start_rule or None)


def _polygon(footprint: str) -> Footprint:
    """The footprint that a label states."""
    # A label file says no more than where models come from: it never makes us read other files.
    if footprint.lower().endswith(".json") or footprint.lower().endswith(".geojson") or Path(footprint).exists():
        raise UsageError(f"footprint {footprint!r} of a label is a file; expected 20x12 or WKT.")
    found = read_footprints(footprint)
    if len(found) != 1:
        raise UsageError(f"footprint {footprint[:60]!r} of a label has {len(found)} polygons; expected one.")
    return found[0].polygon
