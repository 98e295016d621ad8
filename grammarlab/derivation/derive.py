"""`derive`: a grammar, a number of models and a seed give a forest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation import engine
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.frames import FramePool
from grammarlab.derivation.functions.attributes import STATE_DEFAULTS
from grammarlab.derivation.materials import MaterialPool
from grammarlab.derivation.meshes import MeshPool, normalized
from grammarlab.derivation.program import Program
from grammarlab.derivation.shapes import FOOTPRINT, Shapes, Value
from grammarlab.derivation.strings import StringPool
from grammarlab.derivation.texture_transfer import initial_maps
from grammarlab.derivation.workspace import Budget, Workspace
from grammarlab.errors import UsageError
from grammarlab.geometry.assets import AssetFolder
from grammarlab.geometry.mesh import Meshes
from grammarlab.language.grammar import Grammar
from grammarlab.randomness import root_keys

Floats = NDArray[np.float64]

DEFAULT_FOOTPRINT = (20.0, 20.0)
"""Width (along x) and depth (along z) in metres of the lot that a model stands on when none is given."""

NODES_PER_CHUNK = 400_000
"""About how many nodes `derive_chunks` holds at once: fewer cost time per call, more fall out of the processor's
caches."""

_FIRST_CHUNK = 32


def derive(
    grammar: Grammar | Program,
    num_models: int,
    seed: int,
    *,
    first_model: int = 0,
    attributes: Mapping[str, float | bool | str] | None = None,
    start_rule: str | None = None,
    footprint: tuple[float, float] | Floats = DEFAULT_FOOTPRINT,
    assets: Path | AssetFolder | None = None,
    budget: Budget | None = None,
) -> Forest:
    """Sample models from a grammar.

    Model i of a seed is the same in every batch: the result depends on nothing but the grammar, the seed and the index.

    Args:
        grammar: the grammar, or the program that `compile_grammar` made of it.
        num_models: how many models; 0 gives a forest without nodes.
        seed: 0 <= seed < 2**64.
        first_model: index of the first model.
        attributes: values for attributes of the grammar, instead of their own.
        start_rule: symbol to start with, instead of the one that the grammar marks.
        footprint: width and depth in metres of a rectangle from the origin along +x and +z, or the corners [n, 3] of a
            simple polygon, counter-clockwise seen from above; holes are joined to it by doubled edges. The scope's x
            axis runs along the first edge, y up, z out over the first edge.
        assets: folder of the meshes and images that the grammar uses; an `AssetFolder` keeps what it has read.
        budget: bounds on the size of one model.

    Raises:
        UsageError: for an unknown attribute or start rule, or a negative number of models.
        DerivationError: when a rule cannot be carried out.
        BudgetError: when a model grows beyond the budget.

    >>> from grammarlab.language.grammar import Grammar
    >>> forest = derive(Grammar.parse("Lot --> 50%: extrude(3) Low else: extrude(9) High"), 100, seed=5)
    >>> len(forest.nodes), forest.leaves.size[:, 1].max()
    (200, np.float64(9.0))
    """
    program = grammar if isinstance(grammar, Program) else compile_grammar(grammar)
    start = _start(program, start_rule)
    overrides = _overrides(program, attributes or {})
    folder = AssetFolder(assets) if isinstance(assets, Path) else assets
    if num_models < 0:
        raise UsageError(f"expected 0 models or more, found {num_models}")
    workspace = _prepare(
        program, num_models, seed, first_model, start, footprint, folder, budget or Budget(), overrides
    )
    if num_models:
        with np.errstate(all="ignore"):
            _evaluate_attributes(workspace)
            engine.run(program, workspace, start)
    recorder = workspace.recorder
    leaves = recorder.leaves(workspace.meshes, workspace.frames)
    rotations, frame = workspace.frames.used(leaves.frame)
    texture_maps, texture_map = workspace.texture_maps.used(leaves.texture_map)
    return Forest(
        seed,
        first_model,
        num_models,
        program.symbols,
        program.rule_names,
        program.sites,
        recorder.nodes(),
        replace(leaves, frame=frame, texture_map=texture_map),
        recorder.draws(),
        recorder.reports(),
        rotations,
        workspace.meshes.freeze(),
        workspace.materials.freeze(),
        texture_maps,
        tuple(recorder.prints),
        recorder.missing_assets(),
    )


def derive_chunks(
    grammar: Grammar | Program,
    num_models: int,
    seed: int,
    *,
    first_model: int = 0,
    nodes_per_chunk: int = NODES_PER_CHUNK,
    **options: object,
) -> Iterator[Forest]:
    """The forests of consecutive models, together the same as one `derive`; memory stays bounded for any number.

    Args:
        grammar: as for `derive`, like the other arguments and options.
        num_models: how many models in all.
        seed: 0 <= seed < 2**64.
        first_model: index of the first model.
        nodes_per_chunk: about how many nodes one forest has; at least one model.
        options: see `derive`.
    """
    program = grammar if isinstance(grammar, Program) else compile_grammar(grammar)
    assets = options.get("assets")
    if isinstance(assets, Path):
        # All chunks share what is read.
        options["assets"] = AssetFolder(assets)
    done, size = 0, min(_FIRST_CHUNK, num_models)
    while done < num_models:
        forest = derive(program, size, seed, first_model=first_model + done, **options)  # type: ignore[arg-type]
        yield forest
        done += size
        per_model = max(1.0, len(forest.nodes) / size)
        size = min(num_models - done, max(1, int(nodes_per_chunk / per_model)))


def _start(program: Program, name: str | None) -> int:
    wanted = program.default_start if name is None else name
    if wanted not in program.start_rules:
        known = ", ".join(program.start_rules)
        raise UsageError(f"no rule without parameters is called {wanted}; those there are: {known}")
    return program.start_rules[wanted]


def _overrides(program: Program, attributes: Mapping[str, float | bool | str]) -> dict[str, Value]:
    unknown = [name for name in attributes if name not in program.attributes]
    if unknown:
        known = ", ".join(program.attributes) or "none"
        raise UsageError(f"the grammar has no attribute {unknown[0]}; those it has: {known}")
    return {name: value if isinstance(value, bool | str) else float(value) for name, value in attributes.items()}


def _prepare(
    program: Program,
    num_models: int,
    seed: int,
    first_model: int,
    start: int,
    footprint: tuple[float, float] | Floats,
    assets: AssetFolder | None,
    budget: Budget,
    overrides: Mapping[str, Value],
) -> Workspace:
    """The workspace with the initial shapes in it."""
    models = np.arange(num_models, dtype=np.int32)
    frames, meshes = FramePool(), MeshPool()
    position, size, frame, mesh = _initial(footprint, frames, meshes)
    roots = Shapes(
        models,
        models,
        root_keys(seed, np.arange(first_model, first_model + num_models, dtype=np.uint64)),
        np.repeat(position[None, :], num_models, axis=0),
        np.repeat(size[None, :], num_models, axis=0),
        np.full(num_models, frame, dtype=np.int32),
        np.full(num_models, frame, dtype=np.int32),
        np.full(num_models, mesh, dtype=np.int32),
        np.zeros(num_models, dtype=np.int32),
        {},
        (),
    )
    workspace = Workspace(
        program.attributes,
        program.state_names,
        program.uv_sets,
        [[] for _ in program.rules],
        program.symbols[program.rules[start].symbol],
        roots,
        overrides,
        StringPool(),
        frames,
        meshes,
        MaterialPool(),
        budget,
        assets,
    )
    workspace.roots = roots._replace(state=initial_maps(roots, workspace))
    workspace.recorder.add_roots(models, program.rules[start].symbol)
    return workspace


def _evaluate_attributes(workspace: Workspace) -> None:
    """Evaluate every drawn attribute, and give the initial shapes the state that rules read or change."""
    for attribute in workspace.attributes.values():
        if attribute.draws:
            workspace.attribute(attribute.name)
    state = {name: STATE_DEFAULTS[name] for name in workspace.state_names if name in STATE_DEFAULTS}
    own = {name: workspace.attribute(name) for name in workspace.state_names if name in workspace.attributes}
    workspace.roots = workspace.roots._replace(state={**workspace.roots.state, **state, **own})


def _initial(
    footprint: tuple[float, float] | Floats, frames: FramePool, meshes: MeshPool
) -> tuple[Floats, Floats, int, int]:
    """Position, size, frame and mesh of the initial shape."""
    if isinstance(footprint, tuple):
        width, depth = footprint
        return np.zeros(3), np.array([width, 0.0, depth]), 0, FOOTPRINT
    x = footprint[1] - footprint[0]
    x = x / np.linalg.norm(x)
    rotation = np.stack([x, [0.0, 1.0, 0.0], np.cross(x, [0.0, 1.0, 0.0])], axis=1)
    # The bridges to its holes are passed twice: there and back over the same points.
    first, corners = _first_visits(footprint)
    local = Meshes.single((footprint @ rotation)[first], [corners.tolist()])
    unit, low, size = normalized(local)
    rectangle = np.array([[0.0, 0, 1], [1, 0, 1], [1, 0, 0], [0, 0, 0]])
    is_rectangle = unit.points.shape == (4, 3) and np.allclose(unit.points, rectangle, atol=1e-9)
    frame = 0 if np.allclose(rotation, np.eye(3), atol=1e-12) else int(frames.add(rotation[None])[0])
    mesh = FOOTPRINT if is_rectangle else int(meshes.add(unit)[0])
    return rotation @ low[0], size[0], frame, mesh


def _first_visits(points: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which of points [P] come for the first time, ascending, and for each point [P] the number of its first visit."""
    _, first, which = np.unique(points, axis=0, return_index=True, return_inverse=True)
    visited = np.sort(first)
    return visited, np.searchsorted(visited, first)[which.ravel()]
