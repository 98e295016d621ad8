"""Models of a rule file in a run: derived, with saved derivations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from grammarlab.derivation.derive import derive
from grammarlab.errors import Finding
from grammarlab.geometry.outlines.footprints import Remark
from grammarlab.language.attribute_values import AttributeValue, read_attributes
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.runs.disk.derivations import FILES, load_forest, save_forest
from grammarlab.runs.models.abstract import AbstractModels, MadeModels
from grammarlab.runs.models.reports import summarize_reports
from grammarlab.runs.requests.batches import Batch, lots_of, property_remarks
from grammarlab.runs.requests.checks import not_carried_out
from grammarlab.runs.requests.request import SampleRequest
from grammarlab.scene import Scene, realize


@dataclass(frozen=True)
class GrammarModels(AbstractModels):
    """Models derived from a grammar."""

    space: GrammarSpace

    def attributes(self, texts: Sequence[str]) -> dict[str, AttributeValue]:
        return read_attributes(texts, self.space.grammar)

    def left_out(self) -> tuple[Finding, ...]:
        return not_carried_out(self.space.grammar)

    def check(self, request: SampleRequest) -> None:
        options = {"attributes": request.attributes, "start_rule": request.start_rule or None}
        derive(self.space.program, 0, request.seed, **options)

    def remarks(self, request: SampleRequest) -> tuple[Remark, ...]:
        return tuple(
            remark for footprint in request.footprints for remark in property_remarks(footprint, self.space.grammar)
        )

    def make(self, request: SampleRequest, batch: Batch) -> MadeModels:
        found = self.space.accepted(self.space.program, lots_of(request, batch, self.space.grammar))
        forest = found.forest

        def save(folder: Path) -> Iterable[str]:
            save_forest(forest, folder)
            return FILES

        return MadeModels(
            scene=realize(forest),
            shapes=forest.shapes_per_model().tolist(),
            log_probability=forest.log_probability().tolist(),
            reports=summarize_reports(forest),
            prints=forest.prints,
            missing_assets=forest.missing_assets,
            tries=found.tries.tolist(),
            kept=found.kept.tolist(),
            save=save,
        )

    def stored(self, request: SampleRequest, batch: Batch, folder: Path) -> Scene:
        return realize(load_forest(folder))
