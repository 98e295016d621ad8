"""Random forests: any columns that the type allows, whether or not a grammar could have made them."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from grammarlab.arrays import offsets_from_counts
from grammarlab.derivation.forest import Draws, Forest, Leaves, Nodes, Reports, RuleName, Site
from grammarlab.derivation.lots import AttributeColumn, Footprints, Lots
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.geometry.meshes.mesh import Meshes


def random_forest(rng: np.random.Generator, num_models: int, num_nodes: int, num_leaves: int, num_draws: int) -> Forest:
    def ints(high: int, size: int, dtype: Any) -> Any:
        return rng.integers(0, max(high, 1), size).astype(dtype)

    def floats(*size):
        return rng.standard_normal(size) * 10.0 ** rng.integers(-300, 300, size)

    rules = tuple(RuleName(f"Rule{i}", i % 3, tuple(range(i % 4)), i + 1) for i in range(4))
    return Forest(
        lots=random_lots(rng, num_models),
        symbols=("Lot", "Mass", "Fenêtre"),
        rules=rules,
        sites=(Site("Lot#2", "choice", "Lot", 12, 3),),
        nodes=Nodes(
            model=ints(num_models, num_nodes, np.int32),
            parent=ints(num_nodes, num_nodes, np.int32) - np.int32(1),
            symbol=ints(3, num_nodes, np.int16),
            rule=ints(4, num_nodes, np.int16) - np.int16(1),
            child=ints(9, num_nodes, np.int16),
            repeat=ints(9, num_nodes, np.int32),
        ),
        leaves=Leaves(
            node=ints(num_nodes, num_leaves, np.int32),
            position=floats(num_leaves, 3),
            size=floats(num_leaves, 3),
            frame=ints(24, num_leaves, np.int32),
            mesh=ints(5, num_leaves, np.int32),
            material=ints(2, num_leaves, np.int32),
            texture_map=ints(3, num_leaves, np.int32) - np.int32(1),
        ),
        draws=Draws(
            node=ints(num_nodes, num_draws, np.int32),
            site=ints(1, num_draws, np.int16),
            value=floats(num_draws),
            log_density=floats(num_draws),
        ),
        reports=Reports(
            node=ints(num_nodes, 2, np.int32),
            key=ints(2, 2, np.int32),
            value=np.array([np.nan, -0.0]),
            keys=("area", ""),
        ),
        frames=floats(24, 3, 3),
        meshes=random_meshes(rng, 5),
        materials=Materials(rng.random((2, len(CHANNELS))), ("", "wood/oak.jpg")),
        texture_maps=floats(2, 2, 4),
    )


def random_lots(rng: np.random.Generator, num_models: int) -> Lots:
    """Lots that differ in everything."""
    widths = None if rng.random() < 0.5 else [[8.0, 0.0, 6.5, 0.0], None, rng.uniform(0.0, 20.0, 4)]
    footprints = Footprints.of([(8.0, 6.0), rng.standard_normal((5, 3)) + 3e6, (1.0, 2.0)], widths)
    given = rng.random((3, num_models)) < 0.6
    values = (
        rng.standard_normal(num_models),
        rng.random(num_models) < 0.5,
        np.array([("é", "", "tile")[i % 3] for i in range(num_models)]),
    )
    columns = zip(("height", "shops", "style"), values, given, strict=True)
    return Lots(
        seed=rng.integers(0, 2**64, num_models, dtype=np.uint64),
        model=rng.integers(0, 2**64, num_models, dtype=np.uint64),
        footprints=footprints,
        footprint=rng.integers(0, 3, num_models, dtype=np.int32),
        attributes={n: AttributeColumn(np.where(g, v, np.zeros(1, v.dtype)), g) for n, v, g in columns},
        start_rules=("Roof", ""),
        start_rule=rng.integers(0, 2, num_models, dtype=np.int32),
    )


def random_meshes(rng: np.random.Generator, num_meshes: int) -> Meshes:
    faces_per_mesh = rng.integers(0, 4, num_meshes)
    points_per_mesh = rng.integers(3, 9, num_meshes)
    face_sizes = rng.integers(3, 7, faces_per_mesh.sum())
    mesh_of_corner = np.repeat(np.repeat(np.arange(num_meshes), faces_per_mesh), face_sizes)
    return Meshes(
        points=rng.standard_normal((points_per_mesh.sum(), 3)),
        corners=(rng.random(face_sizes.sum()) * points_per_mesh[mesh_of_corner]).astype(np.int64),
        face_offsets=offsets_from_counts(face_sizes),
        mesh_faces=offsets_from_counts(faces_per_mesh),
        mesh_points=offsets_from_counts(points_per_mesh),
        tags=rng.integers(0, 3, face_sizes.shape).astype(np.int8),
    )


def assert_same(a: Any, b: Any, path: str = "forest") -> None:
    """Two values are equal in type, dtype, shape and every bit, in all fields that count for equality."""
    assert type(a) is type(b), path
    if is_dataclass(a):
        for field in (field for field in fields(a) if field.compare):
            assert_same(getattr(a, field.name), getattr(b, field.name), f"{path}.{field.name}")
    elif isinstance(a, np.ndarray) and a.dtype.kind == "U":
        assert a.tolist() == b.tolist(), path
    elif isinstance(a, np.ndarray):
        assert (a.dtype, a.shape) == (b.dtype, b.shape), path
        assert a.tobytes() == b.tobytes(), path
    elif isinstance(a, dict):
        assert list(a) == list(b), path
        for key in a:
            assert_same(a[key], b[key], f"{path}.{key}")
    else:
        assert a == b, path
