"""Pictures by rays and by OpenGL, and a whole contact sheet.

The building of about 20,000 triangles at 160 x 160 pixels is the one to watch: at most 110 ms on one core by rays.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.grammars import FACADES
from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.choice import RendererChoice, choose
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.runs.sample.models import cut_batches, models_of
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import sample_run
from grammarlab.runs.work.executor_choice import executor_of
from grammarlab.scene import realize, triangles


@pytest.fixture(scope="module")
def models():
    """A building, and a block of towers."""
    request = SampleRequest.of("building", num_models=16, seed=5)
    buildings = triangles(next(iter(models_of(request).make(request, cut_batches(request)[0]).scenes)).scene)
    nearest = int(np.abs(buildings.triangles_per_model() - 20_000).argmin())
    block = triangles(realize(derive(Grammar.parse(FACADES), 1, 1, footprint=(400.0, 400.0))))
    return {"building": buildings.model(nearest), "block": block.model(0)}


@pytest.mark.parametrize("renderer", ["cast", "gl"])
@pytest.mark.parametrize("side", [160, 320])
@pytest.mark.parametrize("name", ["building", "block"])
def test_picture(benchmark, models, name, side, renderer):
    choice = choose("auto") if renderer == "gl" else RendererChoice("cast")
    if choice.name != renderer:
        pytest.skip("OpenGL does not work on this machine")
    model = models[name]
    camera, drawing = frame(model.vertices, 1.0, View()), choice.make()
    benchmark.extra_info |= {"triangles": len(model.triangles), "driver": choice.driver}
    benchmark.pedantic(drawing.render, (model, camera, RenderOptions(side, side)), rounds=8, warmup_rounds=1)


@pytest.mark.parametrize("jobs", [1, 2])
def test_sheet_of_16_buildings(benchmark, tmp_path, jobs):
    """The files, too; `bench_cli` says what they take."""
    request = SampleRequest.of("building", num_models=16, seed=5)
    benchmark.pedantic(sample_run, (request, tmp_path), {"executor": executor_of(jobs)}, rounds=2)
