"""Drawing of models, model files, and the rules of visible parts, in a worker process."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import Finding, GrammarlabError, UsageError
from grammarlab.export.glb import merged_glb
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace, AbstractParts
from grammarlab.pages.workers.tasks import (
    Begin,
    DrawContrast,
    DrawModels,
    DrawnModels,
    FindPart,
    FoundPart,
    MakeGlb,
)
from grammarlab.pages.workers.worker_pool import Handler, Report
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.runs.sample.checks import warnings_of
from grammarlab.runs.sample.contact_sheet import PAPER, seen_points
from grammarlab.runs.sample.domains import opened
from grammarlab.scene import TriangleBatch, triangles
from grammarlab.scene.scene_pictures import with_pictures

_MAX_MODELS = 48
"""Largest number of models in memory, since they are drawn twice: quickly, then well."""
_MAX_VERTICES = 8_000_000
"""Largest number of their vertices, unless the models requested last have more."""
_MAX_GLB_BYTES = 128 << 20
"""Largest size of a GLB file for a window, in bytes."""


@dataclass(frozen=True, slots=True)
class PartFinder:
    """Parts of one model."""

    model: str
    """Address."""
    parts: AbstractParts

    def find(self, number: int, is_triangle: bool) -> FoundPart:
        """A part by its number modulo the number of parts, or by the number of one of its triangles.

        Raises:
            UsageError: If there is no such triangle, or no part.
        """
        part_of = self.parts.of_triangles
        if not len(part_of):
            raise UsageError("the model has no visible part.")
        if is_triangle and not 0 <= number < len(part_of):
            raise UsageError(f"triangle: expected 0 to {len(part_of) - 1}, found {number}.")
        num_parts = int(part_of.max()) + 1
        part = int(part_of[number]) if is_triangle else number % num_parts
        triangles = np.flatnonzero(part_of == part)
        return FoundPart(part, num_parts, (int(triangles[0]), int(triangles[-1]) + 1), self.parts.way_to(part))


def artist(suffix: str, text: str, name: str, assets: AssetRoot) -> Handler:
    """Worker for `DrawModels`, `MakeGlb` and `FindPart` tasks of the designs of a text."""
    return _Studio(opened(suffix, text, name, assets), assets).do


@dataclass
class _Studio:
    """Recently used models."""

    space: AbstractDesignSpace[Any]
    assets: AssetRoot
    models: OrderedDict[str, TriangleBatch] = field(default_factory=OrderedDict)
    parts: PartFinder | None = None
    """Parts of the model that was clicked last."""
    warnings: dict[Finding, None] = field(default_factory=dict)
    """Warnings about all models so far."""

    def do(
        self, request: Begin | DrawModels | DrawContrast | MakeGlb | FindPart, _report: Report
    ) -> DrawnModels | FoundPart | bytes | int:
        if isinstance(request, Begin):
            return self.space.pool_size
        if isinstance(request, MakeGlb):
            return self._glb(request.model)
        if isinstance(request, FindPart):
            return self._part(request)
        if isinstance(request, DrawContrast):
            return self._contrast(request)
        pictures = self._draw(
            request.models, RenderOptions(width=request.size, height=request.size, samples=request.samples)
        )
        return DrawnModels(tuple(pictures), tuple(self.warnings))

    def _glb(self, model: str) -> bytes:
        content = merged_glb(self._model(model), model, self.assets)
        if len(content) > _MAX_GLB_BYTES:
            raise GrammarlabError(f"model {model} is too large to be shown: {len(content) >> 20} MiB.")
        return content

    def _part(self, request: FindPart) -> FoundPart:
        if self.parts is None or self.parts.model != request.model:
            self.parts = PartFinder(request.model, self.space.parts(Address.parse(request.model)))
        return self.parts.find(request.number, request.is_triangle)

    def _contrast(self, request: DrawContrast) -> DrawnModels:
        """Two pictures in one frame, so that what looks different is different."""
        for model in request.contrast.models:
            pair = self.space.contrast(Address.parse(model), request.contrast.feature)
            if pair is None:
                continue
            batch = triangles(with_pictures(pair.scene, self.assets))
            seen = frame(seen_points(batch), 1.0, View())
            options = RenderOptions(width=request.size, height=request.size, samples=request.samples)
            return DrawnModels(tuple(RaycastRenderer().render(batch.model(index), seen, options) for index in range(2)))
        raise UsageError(f"{request.contrast.text}: no seed here gives two models that differ in this alone.")

    def _draw(self, models: Sequence[str], options: RenderOptions) -> list[NDArray[np.uint8]]:
        # A model that cannot be derived is reported in the large view; others are not affected.
        with suppress(GrammarlabError):
            self._derive([Address.parse(model) for model in models if model not in self.models])
        return [self._picture(model, options) for model in models]

    def _picture(self, name: str, options: RenderOptions) -> NDArray[np.uint8]:
        try:
            model = self._model(name)
            return RaycastRenderer().render(model, frame(seen_points(model), 1.0, View()), options)
        except GrammarlabError:
            return np.full((options.height, options.width, 3), PAPER, np.uint8)

    def _model(self, text: str) -> TriangleBatch:
        if text not in self.models:
            self._derive([Address.parse(text)])
        self.models.move_to_end(text)
        return self.models[text]

    def _derive(self, addresses: Sequence[Address]) -> None:
        """Load models into memory."""
        if not addresses:
            return
        ordered = sorted(addresses)
        realized = self.space.realize(ordered)
        self.warnings |= dict.fromkeys(warnings_of(realized.missing_assets, self.assets))
        batch = triangles(with_pictures(realized.scene, self.assets))
        self.models |= {str(address): batch.model(index) for index, address in enumerate(ordered)}
        vertices = sum(len(model.vertices) for model in self.models.values())
        while len(self.models) > _MAX_MODELS or (vertices > _MAX_VERTICES and len(self.models) > len(addresses)):
            vertices -= len(self.models.popitem(last=False)[1].vertices)
