"""Small models to take pictures of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.light.look import Look
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import AbstractRenderer, RenderOptions
from grammarlab.scene import TriangleBatch, realize, triangles

RED_BOX = 'Lot --> color("#cc2020") extrude(3)'
TOWER = """
Lot --> extrude(4) comp(f) { top : Top. | side : Wall }
Wall --> color("#c0a080") split(x) { ~1 : Side. | 1 : Window | ~1 : Side. }
Window --> color("#203040") t(0, 0, -0.2) Pane.
Top --> color("#808080") Top.
"""
GLASS = """
Lot --> [ t(1, 0, 1) s(2, 0, 2) color("#cc2020") extrude(2) Core. ]
    color("#88aacc") set(material.opacity, 0.4) extrude(3) Case.
"""
CASCADE = """
Lot --> color("#d0d0d0") [ extrude(1) Base. ] t('0.3, 1, '0.3) s('0.4, 0, '0.4) color("#4060a0") extrude(3) Tower.
"""


def batch(text: str) -> TriangleBatch:
    return triangles(realize(derive(Grammar.parse(text), 1, 1, footprint=(4.0, 4.0))))


def picture(
    model: TriangleBatch, renderer: AbstractRenderer | None = None, view: View | None = None, **options
) -> np.ndarray:
    """The framed model as integers [48, 48, 3]."""
    view = view or View()
    chosen = RenderOptions(48, 48, view=view, **options)
    points = model.vertices if len(model.vertices) else np.zeros((1, 3), np.float32)
    return (renderer or RaycastRenderer()).render(model, frame(points, 1.0, view), chosen).astype(int)


def moved(model: TriangleBatch, matrix: np.ndarray, by: tuple[float, float, float] = (0, 0, 0)) -> TriangleBatch:
    """The model after a linear map that keeps angles, then a shift; a mirrored one keeps its outside outside."""
    directions = matrix / np.cbrt(abs(np.linalg.det(matrix)))
    flipped = np.linalg.det(matrix) < 0
    return replace(
        model,
        vertices=(model.vertices @ matrix.T + by).astype(np.float32),
        normals=(model.normals @ directions.T).astype(np.float32),
        triangles=model.triangles[:, ::-1] if flipped else model.triangles,
    )


PLAIN = Look(edge=0.0)
