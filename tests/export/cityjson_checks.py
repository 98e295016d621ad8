"""Checks of CityJSONSeq that stand for a validator: closed, oriented solids, planar rings, indices in range."""

from __future__ import annotations

import json
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

Feature = dict[str, Any]


def features_of(path: Path) -> list[Feature]:
    """The features of a file."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()[1:]]


def geometry_of(feature: Feature, level: str) -> dict[str, Any]:
    """The geometry of a level of the only object of a feature."""
    (thing,) = feature["CityObjects"].values()
    (geometry,) = (part for part in thing["geometry"] if part["lod"] == level)
    return geometry


def surfaces_of(geometry: dict[str, Any]) -> list[list[list[int]]]:
    """The surfaces of a geometry: rings of vertices."""
    return geometry["boundaries"][0] if geometry["type"] == "Solid" else geometry["boundaries"]


def types_of(geometry: dict[str, Any]) -> list[str]:
    """The semantic type of each surface."""
    semantics = geometry["semantics"]
    values = semantics["values"][0] if geometry["type"] == "Solid" else semantics["values"]
    return [semantics["surfaces"][value]["type"] for value in values]


def directed_edges(surfaces: list[list[list[int]]]) -> Counter[tuple[int, int]]:
    """How often the rings pass each edge in each direction."""
    return Counter(edge for surface in surfaces for ring in surface for edge in pairwise([*ring, ring[0]]))


def assert_closed_manifold(geometry: dict[str, Any]) -> None:
    """Each edge is passed once in each direction: closed, consistently oriented, without edges of four faces."""
    edges = directed_edges(surfaces_of(geometry))
    assert set(edges.values()) == {1}
    assert all((end, start) in edges for start, end in edges)


def area_vector(ring: list[int], vertices: np.ndarray) -> np.ndarray:
    """[3] vector area of a ring in square metres."""
    corners = vertices[ring] - vertices[ring[0]]
    return 0.5 * np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)


def volume(geometry: dict[str, Any], feature: Feature) -> float:
    """Signed volume in cubic metres: positive if surfaces face outwards."""
    vertices = np.array(feature["vertices"]) / 1000
    vertices -= vertices[0]
    rings = [ring for surface in surfaces_of(geometry) for ring in surface]
    return float(sum(area_vector(ring, vertices) @ vertices[ring[0]] for ring in rings) / 3)


def assert_well_formed(feature: Feature) -> None:
    """Indices are in range, vertices different and used, rings simple and planar, semantics complete."""
    vertices = np.array(feature["vertices"])
    assert len(np.unique(vertices, axis=0)) == len(vertices)
    used = set()
    (thing,) = feature["CityObjects"].values()
    for geometry in thing["geometry"]:
        surfaces = surfaces_of(geometry)
        kinds = geometry["semantics"]["surfaces"]
        assert len(types_of(geometry)) == len(surfaces)
        for kind in kinds:
            assert kind["type"] not in ("Window", "Door") or kinds[kind["parent"]]["type"] == "WallSurface"
        for ring in (ring for surface in surfaces for ring in surface):
            assert len(ring) >= 3
            assert len(set(ring)) == len(ring)
            used.update(ring)
        for outer, *_ in surfaces:
            normal = area_vector(outer, vertices / 1000)
            height = (vertices[outer] - vertices[outer[0]]) @ normal / np.linalg.norm(normal)
            assert np.abs(height).max() <= 10  # millimetres
    assert used == set(range(len(vertices)))
