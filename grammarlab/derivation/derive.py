"""`derive`: a forest from a grammar and lots, or from a grammar, a number of models and a seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypedDict, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from grammarlab.assets.meshes import AssetFolder
from grammarlab.derivation import engine
from grammarlab.derivation.calls.texture_transfer import initial_maps
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.functions.shapes.attributes import STATE_DEFAULTS
from grammarlab.derivation.lots import Footprint, Lots
from grammarlab.derivation.program import Program
from grammarlab.derivation.state.initial import initial_shapes
from grammarlab.derivation.state.meshes import MeshTable
from grammarlab.derivation.state.recorder import Recorder
from grammarlab.derivation.state.workspace import Budget, Workspace
from grammarlab.derivation.values.frames import FrameTable
from grammarlab.derivation.values.materials import MaterialTable
from grammarlab.derivation.values.strings import StringTable
from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar

NODES_PER_CHUNK = 400_000
"""Approximate number of nodes that `derive_chunks` holds at once: fewer cost time per call, more exceed the
processor's caches."""

_FIRST_CHUNK = 32


class LotOptions(TypedDict, total=False):
    """Options of `Lots.of` besides the number of models and the seed."""

    first_model: int
    """Index of the first model."""
    attributes: Mapping[str, float | bool | str] | None
    """Values of attributes, instead of those of the grammar."""
    start_rule: str | None
    """Start symbol, instead of the one that the grammar marks."""
    footprint: Footprint
    """Width and depth of a rectangle, or the corners [n, 3] of a polygon."""


@overload
def derive(
    grammar: Grammar | Program,
    lots: Lots,
    /,
    *,
    assets: str | Path | AssetFolder | None = None,
    budget: Budget | None = None,
) -> Forest: ...
@overload
def derive(
    grammar: Grammar | Program,
    num_models: int,
    seed: int,
    *,
    assets: str | Path | AssetFolder | None = None,
    budget: Budget | None = None,
    **options: Unpack[LotOptions],
) -> Forest: ...
def derive(
    grammar: Grammar | Program,
    num_models: int | Lots,
    seed: int | None = None,
    *,
    assets: str | Path | AssetFolder | None = None,
    budget: Budget | None = None,
    **options: Unpack[LotOptions],
) -> Forest:
    """Sample models from a grammar.

    A model is the same in every batch: it depends only on the grammar and on its row of the lots. The models are those
    of the rules alone: `sample` also applies the acceptance rule that many learned grammars have.

    Args:
        grammar: the grammar, or the program that `compile_grammar` made of it.
        num_models: number of models of a seed, which differ only in their index; or lots with all properties of each
            model. With 0 models the forest has no nodes.
        seed: 0 <= seed < 2**64, with a number of models.
        assets: folder of the meshes and images that the grammar uses, by default that of the grammar if it was loaded
            from a file; an `AssetFolder` caches its files.
        budget: bounds on the size of one model.
        options: first_model, attributes, start_rule and footprint as for `Lots.of`, with a number of models.

    Raises:
        UsageError: If an attribute or start rule is unknown, there is no asset folder of that name, or `Lots.of`
            refuses the lots.
        DerivationError: If a rule cannot be applied.
        BudgetError: If a model exceeds the budget.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> 50%: extrude(3) Low else: extrude(9) High"), 100, seed=5)
    >>> len(forest.nodes), forest.leaves.size[:, 1].max()
    (200, np.float64(9.0))
    """
    lots = _lots(num_models, seed, options)
    program = grammar if isinstance(grammar, Program) else compile_grammar(grammar)
    starts = _starts(program, lots)
    _check_attributes(program, lots)
    workspace = _prepare(program, lots, starts, budget or Budget(), _folder(assets, grammar))
    if len(lots):
        with np.errstate(all="ignore"):
            _evaluate_attributes(workspace)
            engine.run(program, workspace, starts[lots.start_rule])
    recorder = workspace.recorder
    leaves = recorder.leaves(workspace.meshes, workspace.frames)
    rotations, frame = workspace.frames.used(leaves.frame)
    texture_maps, texture_map = workspace.texture_maps.used(leaves.texture_map)
    return Forest(
        lots=lots,
        symbols=program.symbols,
        rules=program.rule_names,
        sites=program.sites,
        nodes=recorder.nodes(),
        leaves=replace(leaves, frame=frame, texture_map=texture_map),
        draws=recorder.draws(),
        reports=recorder.reports(),
        frames=rotations,
        meshes=workspace.meshes.freeze(),
        materials=workspace.materials.freeze(),
        texture_maps=texture_maps,
        prints=tuple(recorder.prints),
        missing_assets=recorder.missing_assets(),
    )


@overload
def derive_chunks(
    grammar: Grammar | Program,
    lots: Lots,
    /,
    *,
    nodes_per_chunk: int = NODES_PER_CHUNK,
    assets: str | Path | AssetFolder | None = None,
    budget: Budget | None = None,
) -> Iterator[Forest]: ...
@overload
def derive_chunks(
    grammar: Grammar | Program,
    num_models: int,
    seed: int,
    *,
    nodes_per_chunk: int = NODES_PER_CHUNK,
    assets: str | Path | AssetFolder | None = None,
    budget: Budget | None = None,
    **options: Unpack[LotOptions],
) -> Iterator[Forest]: ...
def derive_chunks(
    grammar: Grammar | Program,
    num_models: int | Lots,
    seed: int | None = None,
    *,
    nodes_per_chunk: int = NODES_PER_CHUNK,
    assets: str | Path | AssetFolder | None = None,
    budget: Budget | None = None,
    **options: Unpack[LotOptions],
) -> Iterator[Forest]:
    """Forests of consecutive lots, together equal to one `derive`; memory is bounded for any number of models.

    Args:
        grammar: see `derive`.
        num_models: number of models of a seed, or lots.
        seed: 0 <= seed < 2**64, with a number of models.
        nodes_per_chunk: approximate number of nodes per forest; at least one model.
        assets: folder of meshes and images; all chunks share the cached files.
        budget: bounds on the size of one model.
        options: see `derive`.
    """
    lots = _lots(num_models, seed, options)
    program = grammar if isinstance(grammar, Program) else compile_grammar(grammar)
    folder = _folder(assets, grammar)
    done, size = 0, min(_FIRST_CHUNK, len(lots))
    while done < len(lots):
        forest = derive(program, lots.take(np.arange(done, done + size)), assets=folder, budget=budget)
        yield forest
        done += size
        per_model = max(1.0, len(forest.nodes) / size)
        size = min(len(lots) - done, max(1, int(nodes_per_chunk / per_model)))


def _lots(num_models: int | Lots, seed: int | None, options: LotOptions) -> Lots:
    """The given lots, or lots from a number of models and options."""
    if not isinstance(num_models, Lots):
        if seed is None:
            raise UsageError("a number of models needs a seed: expected derive(grammar, num_models, seed)")
        return Lots.of(num_models, seed, **options)
    if seed is not None or options:
        given = ", ".join([*(["seed"] if seed is not None else []), *options])
        raise UsageError(f"lots already define their models: leave out {given}, or give a number of models")
    return num_models


def _folder(assets: str | Path | AssetFolder | None, grammar: Grammar | Program) -> AssetFolder | None:
    if assets is None and isinstance(grammar, Grammar):
        assets = grammar.assets
    if not isinstance(assets, str | Path):
        return assets
    if not Path(assets).is_dir():
        raise UsageError(f"assets: expected a folder of meshes and images, found {str(assets)!r}, which is none.")
    return AssetFolder(Path(assets))


def _starts(program: Program, lots: Lots) -> NDArray[np.int32]:
    """[S] the rules of the different start rules."""
    names = [name or program.default_start for name in lots.start_rules]
    unknown = [name for name in names if name not in program.start_rules]
    if unknown:
        known = ", ".join(program.start_rules)
        raise UsageError(f"unknown start rule {unknown[0]}; expected a rule without parameters: {known}")
    return np.array([program.start_rules[name] for name in names], dtype=np.int32)


def _check_attributes(program: Program, lots: Lots) -> None:
    unknown = [name for name in lots.attributes if name not in program.attributes]
    if unknown:
        known = ", ".join(program.attributes) or "none"
        raise UsageError(f"unknown attribute {unknown[0]}; expected one of {known}")


def _prepare(
    program: Program, lots: Lots, starts: NDArray[np.int32], budget: Budget, assets: AssetFolder | None
) -> Workspace:
    """Workspace with the initial shapes."""
    frames, meshes = FrameTable(), MeshTable()
    roots = initial_shapes(lots, frames, meshes)
    symbols = [program.rules[start].symbol for start in starts.tolist()]
    workspace = Workspace(
        attributes=program.attributes,
        state_names=program.state_names,
        uv_sets=program.uv_sets,
        pending=[[] for _ in program.rules],
        lots=lots,
        origins=lots.origins,
        start_symbols=tuple(program.symbols[symbol] for symbol in symbols),
        roots=roots,
        strings=StringTable(),
        frames=frames,
        meshes=meshes,
        materials=MaterialTable(),
        budget=budget,
        recorder=Recorder(program.id_type),
        assets=assets,
    )
    workspace.roots = roots._replace(state=initial_maps(roots, workspace))
    workspace.recorder.add_roots(roots.model, np.array(symbols, dtype=np.int32)[lots.start_rule])
    return workspace


def _evaluate_attributes(workspace: Workspace) -> None:
    """Evaluate every random attribute, and set the state of the initial shapes that rules read or change."""
    for attribute in workspace.attributes.values():
        if attribute.draws:
            workspace.attribute(attribute.name)
    state = {name: STATE_DEFAULTS[name] for name in workspace.state_names if name in STATE_DEFAULTS}
    own = {name: workspace.attribute(name) for name in workspace.state_names if name in workspace.attributes}
    workspace.roots = workspace.roots._replace(state={**workspace.roots.state, **state, **own})
