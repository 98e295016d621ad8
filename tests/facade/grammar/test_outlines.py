"""Leaves with outlines as rules: the meshes are the outlines, and the boxes are those of the leaves."""

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon

from grammarlab.derivation import derive
from grammarlab.facade.grammar.exact_grammar import EXACT, write_exact
from grammarlab.facade.grammar.leaf_looks import Shape, outlined_leaves, store_shapes
from grammarlab.facade.looks import THICKNESS, look_of
from grammarlab.facade.tree import LEAF, Facade, X, laid_out, plain
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.language.grammar import Grammar
from grammarlab.scene import Scene, realize

ARCH = np.array([[0, 0], [1, 0], [1, 0.7], [0.75, 0.93], [0.5, 1], [0.25, 0.93], [0, 0.7]])
TRIANGLE = np.array([[0, 0], [1, 0], [1, 1]])
SMALLER = np.array([[0.2, 0.2], [0.8, 0.2], [0.5, 0.8]])


def outlined(labels: list[str], outlines: list[np.ndarray]) -> Facade:
    """Leaves side by side, each 2 m wide and 3 m high."""
    num = len(labels)
    parent, axis = np.array([-1] + [0] * num), np.array([X] + [LEAF] * num, dtype=np.int8)
    facade = plain(parent, axis, *laid_out(parent, axis, np.tile([2.0, 3.0], (num + 1, 1))), ["", *labels])
    offsets = np.cumsum([0, 0, *(len(each) for each in outlines)])
    return replace(facade, outline_offsets=offsets, outline_points=np.concatenate(outlines).astype(np.float64))


def volume(shape: Shape) -> float:
    """Volume of a mesh in its part of the unit cube."""
    mesh: Any = trimesh.load(io.StringIO(shape.text), file_type="obj", force="mesh")
    assert mesh.bounds == pytest.approx(np.array([[0, 0, 0], [1, 1, 1]]))
    return float(mesh.volume * shape.size.prod())


@st.composite
def stars(draw: st.DrawFn) -> np.ndarray:
    """Outlines around the centre of the box that reach all of its sides."""
    reach = np.array(draw(st.lists(st.floats(0.2, 1.0), min_size=4, max_size=10)))
    angle = np.linspace(0.0, 2.0 * np.pi, len(reach), endpoint=False) + 0.1
    points = reach[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return (points - points.min(axis=0)) / np.ptp(points, axis=0)


@settings(max_examples=25)
@given(stars())
def test_meshes_fill_the_outline_and_what_it_leaves_of_the_box(outline: np.ndarray) -> None:
    (leaf,) = outlined_leaves(outlined(["window", "wall"], [outline, np.zeros((0, 2))])).values()
    area = Polygon(outline).area
    assert volume(leaf.shape) == pytest.approx(area, abs=1e-6)
    assert leaf.around is not None
    assert volume(leaf.around) == pytest.approx(1.0 - area, abs=1e-6)


def test_a_facade_with_outlines_is_derived_with_them(tmp_path: Path) -> None:
    facade = outlined(["window", "window", "wall", "door"], [ARCH, ARCH, TRIANGLE, SMALLER])
    written = write_exact(facade)
    assert written.error <= EXACT
    store_shapes(written.outlined, tmp_path)
    # A triangle of a wall has no wall around it, and an outline inside its box is the box.
    assert len(list(tmp_path.iterdir())) == 3 + 1
    assert written.text.count("i(") == 2 + 1
    forest = derive(Grammar.parse(written.text), 1, seed=0, assets=tmp_path)
    scene = realize(forest)
    filled = sum(
        float(trimesh_of(scene, each).volume) * float(scene.size[each].prod()) for each in range(len(scene.mesh))
    )
    depth = {label: THICKNESS + look_of(label).front for label in ("window", "wall", "door")}
    arch = Polygon(ARCH).area
    expected = 6.0 * (2 * (arch * depth["window"] + (1 - arch) * THICKNESS) + 0.5 * depth["wall"] + depth["door"])
    assert filled == pytest.approx(expected, rel=1e-6)


def trimesh_of(scene: Scene, each: int) -> trimesh.Trimesh:
    """The mesh of an instance, in the unit cube."""
    mesh = scene.meshes.take(np.array([scene.mesh[each]]))
    return trimesh.Trimesh(mesh.points, triangulate(mesh)[0])
