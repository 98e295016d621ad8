"""A run cut into batches, each of which is done, recorded and resumed on its own."""

from __future__ import annotations

from dataclasses import dataclass

from grammarlab.runs.request import BATCH_MODELS, SampleRequest


@dataclass(frozen=True, slots=True)
class Batch:
    """Consecutive models of a run on one footprint."""

    index: int
    footprint: int
    """Index into the footprints of the request, -1 for the default one."""
    first_model: int
    num_models: int

    def __str__(self) -> str:
        return f"models {self.first_model} to {self.first_model + self.num_models - 1}"


def cut_batches(request: SampleRequest) -> tuple[Batch, ...]:
    """The batches of a run: model k on footprint f has the index ``f * num_models + k`` under the run's seed."""
    footprints = range(len(request.footprints)) if request.footprints else [-1]
    cuts = [
        (footprint, max(footprint, 0) * request.num_models + start, min(BATCH_MODELS, request.num_models - start))
        for footprint in footprints
        for start in range(0, request.num_models, BATCH_MODELS)
    ]
    return tuple(Batch(index, *cut) for index, cut in enumerate(cuts))
