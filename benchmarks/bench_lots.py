"""1,000 buildings on as many footprints beside 1,000 on one: at most 1.5 times as long."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import Lots, compile_grammar, derive
from grammarlab.derivation.lots import Footprints
from grammarlab.language.importing import load

GRAMMARS = Path(__file__).parent.parent / "grammars"
NUM = 1000


def _rectangle(rng: np.random.Generator) -> np.ndarray:
    """A rectangle of any size and direction."""
    (width, depth), angle = rng.uniform(15.0, 25.0, 2), rng.uniform(0.0, 2.0 * np.pi)
    cosine, sine = np.cos(angle), np.sin(angle)
    corners = np.array([[0.0, 0, depth], [width, 0, depth], [width, 0, 0], [0, 0, 0]])
    return corners @ np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]) + rng.uniform(-500, 500, 3) * [
        1,
        0,
        1,
    ]


def _polygon(rng: np.random.Generator) -> np.ndarray:
    """A polygon of five to ten corners."""
    angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(5, 11))))
    radius = rng.uniform(9.0, 14.0, len(angles))
    return np.column_stack([radius * np.cos(angles), np.zeros(len(angles)), -radius * np.sin(angles)])


def _lots(kind: str, **options) -> Lots:
    lots, rng = Lots.of(NUM, 1, **options), np.random.default_rng(3)
    if kind == "one footprint":
        return lots
    make = _rectangle if kind == "rectangles" else _polygon
    return lots.on(Footprints.of([make(rng) for _ in range(NUM)]), np.arange(NUM))


@pytest.mark.parametrize("fit", [False, True], ids=["own size", "fit to lot"])
@pytest.mark.parametrize("kind", ["one footprint", "rectangles", "polygons"])
def test_derive_1000_buildings_on(benchmark, kind, fit):
    program, assets = compile_grammar(load(GRAMMARS / "building.cga")), AssetFolder(GRAMMARS / "assets")
    lots = _lots(kind, attributes={"fitToLot": fit})
    forest = benchmark(derive, program, lots, assets=assets)
    assert forest.num_models == NUM
