"""`derive`: a forest from a grammar and lots, or from a grammar, a number of models and a seed.

The engine is columnar: all shapes that wait for one rule are rewritten at once. The initial shape of a lot has a scope
along the first edge of the footprint, and the footprint's polygon as its mesh.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypedDict, Unpack, cast, overload

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, distinct, offsets_from_counts, row_of_value, take_rows
from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation.calls.branches import route
from grammarlab.derivation.calls.lot_plans import initial_plans, streets_of_lots
from grammarlab.derivation.calls.texture_transfer import initial_maps
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.functions.shape_attributes import STATE_DEFAULTS
from grammarlab.derivation.lots import Footprint, Footprints, Lots, StreetWidths, Values, brought_near
from grammarlab.derivation.materials import MaterialTable
from grammarlab.derivation.model_values import attributes_of_models
from grammarlab.derivation.program import CompiledRule, Program, with_variables
from grammarlab.derivation.state.corner_maps import finished
from grammarlab.derivation.state.lineage import NO_PART, PART, Lineage, SiblingOrder
from grammarlab.derivation.state.mesh_table import MeshTable, normalized
from grammarlab.derivation.state.recorder import Recorder
from grammarlab.derivation.state.shapes import FOOTPRINT, Ids, Shapes, concatenate
from grammarlab.derivation.state.surroundings import Collector, Surroundings, visible
from grammarlab.derivation.state.tag_table import TagTable
from grammarlab.derivation.state.trim_planes import NONE, TRIM, TrimPlanes
from grammarlab.derivation.state.workspace import Budget, Workspace, nothing
from grammarlab.derivation.strings import StringTable
from grammarlab.errors import BudgetError, UsageError
from grammarlab.geometry.meshes.measure import face_normals
from grammarlab.geometry.meshes.mesh import UNTAGGED, Meshes
from grammarlab.geometry.meshes.primitives import quad
from grammarlab.geometry.meshes.vectors import cross, dot
from grammarlab.language.grammar import Grammar
from grammarlab.randomness import root_keys

_UP = np.array([0.0, 1.0, 0.0])
_AXES = np.eye(3)
_SHARE = 1e-5
"""Tolerance as a share of the value, beside the absolute one."""
_FLAT_SHARE = 1e-9
"""Largest height of a footprint over its plane that counts as rounding, as a share of its size."""
NODES_PER_CHUNK = 1_000_000
"""Approximate number of nodes that `derive_chunks` holds at once, a budget: some 120 MB. With fewer, the calls per rule
take half of the time where rules are many and models large."""
_MESHES_IN_REACH = 100_000
"""Number of different meshes that are made in about half a minute."""
_MESHES_PER_CHUNK = _MESHES_IN_REACH // 5
"""Approximate number of different meshes that `derive_chunks` makes at once, a budget of some seconds: who waits hears
of each chunk."""
_BARE_NODES = 2
"""Number of nodes without leaves that take at most the memory of one with its leaves."""
_FIRST_CHUNK = 32
"""Number of models of the first chunk, whose nodes determine the size of the others."""
_NUM_ESTIMATED = 8
"""Number of models from which the meshes of one are estimated, beside as many others."""


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
    street_width: StreetWidths | None
    """[n] width in metres of the street along each edge of the footprint, 0 without a street; None if unknown."""


@overload
def derive(
    grammar: Grammar | Program,
    lots: Lots,
    /,
    *,
    assets: str | AssetRoot | AssetFolder | None = None,
    budget: Budget | None = None,
    together: bool = False,
    leaves: bool = True,
) -> Forest: ...
@overload
def derive(
    grammar: Grammar | Program,
    num_models: int,
    seed: int,
    *,
    assets: str | AssetRoot | AssetFolder | None = None,
    budget: Budget | None = None,
    together: bool = False,
    leaves: bool = True,
    **options: Unpack[LotOptions],
) -> Forest: ...
def derive(
    grammar: Grammar | Program,
    num_models: int | Lots,
    seed: int | None = None,
    *,
    assets: str | AssetRoot | AssetFolder | None = None,
    budget: Budget | None = None,
    together: bool = False,
    leaves: bool = True,
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
        together: whether the models stand beside each other in one world: spatial queries between models, such as
            ``overlaps(inter)``, then see the shapes of the others, and a model depends on its neighbours. Otherwise
            they see none.
        leaves: whether to record leaves. Without them, nodes, draws, reports and prints are the same, and operations
            that only leaves show are left out, with their warnings, errors and missing assets: for `building` a fifth
            of the time of one model, half of it in large batches.
        options: with a number of models, first_model, attributes, start_rule, footprint and street_width as for
            `Lots.of`.

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
    prepare = partial(_prepare, program, lots, starts, budget or Budget(), _folder(assets, grammar), has_leaves=leaves)
    surroundings = None
    if program.queries_context and len(lots):
        first = _carried_out(program, prepare(Collector()), starts)
        surroundings = _surroundings(first, together)
    workspace = _carried_out(program, prepare(None, surroundings), starts)
    recorder = workspace.recorder
    finished_leaves = finished(recorder.leaves(workspace.meshes, workspace.frames), workspace)
    rotations, frame = workspace.frames.used(finished_leaves.frame)
    with np.errstate(all="ignore"):  # as for all that operations compute
        texture_maps, texture_map = workspace.texture_maps.used(finished_leaves.texture_map)
    return Forest(
        lots=lots,
        symbols=program.symbols,
        rules=program.rule_names,
        sites=program.sites,
        nodes=recorder.nodes(),
        leaves=replace(finished_leaves, frame=frame, texture_map=texture_map),
        draws=recorder.draws(),
        reports=recorder.reports(),
        frames=rotations,
        meshes=workspace.meshes.freeze(),
        materials=workspace.materials.freeze(),
        texture_maps=texture_maps,
        prints=tuple(recorder.prints),
        missing_assets=recorder.missing_assets(),
        attributes=attributes_of_models(workspace),
        warnings=recorder.warnings(),
    )


@overload
def derive_chunks(
    grammar: Grammar | Program,
    lots: Lots,
    /,
    *,
    nodes_per_chunk: int = NODES_PER_CHUNK,
    assets: str | AssetRoot | AssetFolder | None = None,
    budget: Budget | None = None,
    leaves: bool = True,
) -> Iterator[Forest]: ...
@overload
def derive_chunks(
    grammar: Grammar | Program,
    num_models: int,
    seed: int,
    *,
    nodes_per_chunk: int = NODES_PER_CHUNK,
    assets: str | AssetRoot | AssetFolder | None = None,
    budget: Budget | None = None,
    leaves: bool = True,
    **options: Unpack[LotOptions],
) -> Iterator[Forest]: ...
def derive_chunks(
    grammar: Grammar | Program,
    num_models: int | Lots,
    seed: int | None = None,
    *,
    nodes_per_chunk: int = NODES_PER_CHUNK,
    assets: str | AssetRoot | AssetFolder | None = None,
    budget: Budget | None = None,
    leaves: bool = True,
    **options: Unpack[LotOptions],
) -> Iterator[Forest]:
    """Forests of consecutive lots, together equal to one `derive`; memory is bounded for any number of models.

    Args:
        grammar: the grammar, see `derive`.
        num_models: number of models of a seed, or lots.
        seed: 0 <= seed < 2**64, with a number of models.
        nodes_per_chunk: approximate number of nodes per forest, without leaves twice as many; at least one model. There
            are fewer where models are made of many different meshes.
        assets: folder of meshes and images; all chunks share the cached files.
        budget: bounds on the size of one model.
        leaves: whether to record leaves, see `derive`.
        options: options of lots, see `derive`.
    """
    lots = _lots(num_models, seed, options)
    program = grammar if isinstance(grammar, Program) else compile_grammar(grammar)
    folder = _folder(assets, grammar)
    nodes_per_chunk *= 1 if leaves else _BARE_NODES
    done, size = 0, min(_FIRST_CHUNK, len(lots))
    while done < len(lots):
        rows = np.arange(done, done + size)
        forest = derive(program, lots.take(rows), assets=folder, budget=budget, leaves=leaves)
        yield forest
        done += size
        by_nodes = nodes_per_chunk / max(1.0, len(forest.nodes) / size)
        by_meshes = _MESHES_PER_CHUNK * size / max(1, len(forest.meshes))
        size = min(len(lots) - done, max(1, int(min(by_nodes, by_meshes))))


def models_in_reach(program: Program, assets: AssetFolder | None) -> float:
    """Number of models whose derivation takes about half a minute, by the meshes that some models of the seed 0 add.

    Where meshes are cut, cleaned or asked about, each alone, time grows with the number of different meshes, whatever
    the number of nodes. What all models share is made once in a batch. It does not depend on the machine.

    Raises:
        GrammarlabError: As `derive`.
    """
    few, many = (
        len(derive(program, num_models, 0, assets=assets, leaves=False).meshes)
        for num_models in (_NUM_ESTIMATED, 2 * _NUM_ESTIMATED)
    )
    return _MESHES_IN_REACH * _NUM_ESTIMATED / max(many - few, 1)


def initial_shapes(lots: Lots, frames: FrameTable, meshes: MeshTable) -> Shapes:
    """[N] initial shapes of models, without any state.

    Node and model ids start at 0; positions are relative to `Lots.origins`.
    """
    rows = np.arange(len(lots), dtype=np.int32)
    _, corners = brought_near(lots.footprints.points, lots.footprints.offsets)
    position, size, frame, mesh = _scopes(Footprints(corners, lots.footprints.offsets), frames, meshes)
    on, frame = lots.footprint, frame[lots.footprint]
    keys, material = root_keys(lots.seed, lots.model), np.zeros(len(lots), dtype=np.int32)
    return Shapes(
        node=rows,
        model=rows,
        key=keys,
        position=position[on],
        size=size[on],
        frame=frame,
        pivot=frame,
        mesh=mesh[on],
        material=material,
        state={},
        locals=(),
    )


def _lots(num_models: int | Lots, seed: int | None, options: LotOptions) -> Lots:
    """The given lots, or lots from a number of models and options."""
    if not isinstance(num_models, Lots):
        if seed is None:
            raise UsageError("a number of models needs a seed: expected derive(grammar, num_models, seed)")
        return Lots.of(num_models, seed, **options)
    if seed is not None or options:
        arguments = ", ".join([*(["seed"] if seed is not None else []), *options])
        raise UsageError(f"lots already define their models: leave out {arguments}, or give a number of models")
    return num_models


def _starts(program: Program, lots: Lots) -> NDArray[np.int32]:
    """[S] the rules of the different start rules."""
    names = [name or program.default_start for name in lots.start_rules]
    unknown = [name for name in names if name not in program.start_rules]
    if unknown:
        valid_names = ", ".join(program.start_rules)
        raise UsageError(f"unknown start rule {unknown[0]}; expected a rule without parameters: {valid_names}")
    return np.array([program.start_rules[name] for name in names], dtype=np.int32)


def attributes_of_lots(
    program: Program, lots: Lots, assets: AssetRoot | AssetFolder | None = None
) -> Mapping[str, Values]:
    """`Forest.attributes` of models without deriving them.

    Args:
        program: compiled grammar.
        lots: the models.
        assets: as for `derive`.
    """
    workspace = _prepare(program, lots, _starts(program, lots), Budget(), _folder(assets, program), None)
    if len(lots):
        with np.errstate(all="ignore"):
            _evaluate_attributes(workspace)
    return attributes_of_models(workspace)


def _check_attributes(program: Program, lots: Lots) -> None:
    unknown = [name for name in lots.attributes if name not in program.attributes]
    if unknown:
        valid_names = ", ".join(program.attributes) or "none"
        raise UsageError(f"unknown attribute {unknown[0]}; expected one of {valid_names}")


def _carried_out(program: Program, workspace: Workspace, starts: NDArray[np.int32]) -> Workspace:
    """A prepared workspace after the derivation of all its models."""
    if len(workspace.lots):
        with np.errstate(all="ignore"):
            _evaluate_attributes(workspace)
            _run(program, workspace, starts[workspace.lots.start_rule])
    return workspace


def _surroundings(first: Workspace, together: bool) -> Surroundings:
    """Shapes that the queries of a second derivation see, from the finished first one."""
    collector = cast("Collector", first.collector)
    for shapes in first.recorder.finished():
        collector.add(visible(shapes))
    return Surroundings.of(collector, first.roots, first.origins, first.meshes, first.frames, together)


def _prepare(
    program: Program,
    lots: Lots,
    starts: NDArray[np.int32],
    budget: Budget,
    assets: AssetFolder | None,
    collector: Collector | None,
    surroundings: Surroundings | None = None,
    has_leaves: bool = True,
) -> Workspace:
    """Workspace with the initial shapes."""
    frames, meshes = FrameTable(), MeshTable()
    roots = initial_shapes(lots, frames, meshes)
    symbols = [program.rules[start].symbol for start in starts.tolist()]
    lineage = collector.lineage if collector else Lineage(surroundings.tree) if surroundings else None
    workspace = Workspace(
        attributes=program.attributes,
        state_names=program.state_names,
        uv_sets=program.uv_sets,
        import_prefixes=program.import_prefixes,
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
        recorder=Recorder(
            program.id_type,
            lineage,
            has_leaves or collector is not None,
            SiblingOrder() if program.reads_tree_keys else None,
        ),
        assets=assets,
        collector=collector,
        surroundings=surroundings,
        trim_planes=TrimPlanes(stay_off=not program.trims_again),
        tags=TagTable() if program.uses_tags else None,
    )
    if program.selects_streets:
        workspace.streets = streets_of_lots(lots, workspace)
    state = {**initial_maps(roots, workspace), **initial_plans(workspace)}
    if program.has_trim_planes:
        state[TRIM] = NONE
    if program.reads_tree_keys:
        state[PART] = NO_PART
    workspace.roots = roots._replace(state=state)
    workspace.recorder.add_roots(roots.model, np.array(symbols, dtype=np.int32)[lots.start_rule])
    return workspace


def _scopes(footprints: Footprints, frames: FrameTable, meshes: MeshTable) -> tuple[Floats, Floats, Ids, Ids]:
    """Position, size, frame and mesh [F] of the initial shapes on different footprints."""
    rotation = _rotations(footprints)
    local = _levelled(_times(footprints, rotation), footprints)
    unit, low, size = normalized(_polygons(local, footprints))
    skew = ~_are_near(rotation, _AXES, 1e-12).all(axis=(1, 2))
    frame = np.zeros(len(footprints), dtype=np.int32)
    frame[skew] = frames.add(rotation[skew])
    mesh = np.full(len(footprints), FOOTPRINT, dtype=np.int32)
    other_rows = np.flatnonzero(~_is_rectangle(unit))
    if len(other_rows):
        mesh[other_rows] = meshes.add(unit.take(other_rows))
    return (rotation @ low[:, :, None])[:, :, 0], size, frame, mesh


def _rotations(footprints: Footprints) -> Floats:
    """[F, 3, 3] rotations whose y axis is the normal of the footprint and whose x axis runs along the first edge."""
    first = footprints.offsets[:-1]
    x = footprints.points[first + 1] - footprints.points[first]
    y = _normals(footprints)
    x = x - y * dot(x, y)[:, None]
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, y, cross(x, y)], axis=2)


def _normals(footprints: Footprints) -> Floats:
    """[F, 3] unit normals of footprints; exactly up for those that are level."""
    height, first = footprints.points[:, 1], footprints.offsets[:-1]
    is_sloped = np.logical_or.reduceat(height != np.repeat(height[first], np.diff(footprints.offsets)), first)
    normals = np.broadcast_to(_UP, (len(first), 3)).copy()
    sloped = np.flatnonzero(is_sloped)
    if len(sloped):
        corners, offsets = take_rows(footprints.offsets, sloped)
        normals[sloped] = face_normals(Meshes.from_polygons(footprints.points[corners], np.diff(offsets)))
    return normals


def _times(footprints: Footprints, rotation: Floats) -> Floats:
    """[P, 3] corners times the rotation [F, 3, 3] of their footprint.

    There is one product per footprint, as for a single footprint, so that the last bits are the same.
    """
    counts = np.diff(footprints.offsets)
    result = np.empty_like(footprints.points)
    for count in distinct(counts, int(counts.max(initial=0)) + 1).tolist():
        rows_of_count = np.flatnonzero(counts == count)
        corners = footprints.offsets[rows_of_count][:, None] + np.arange(count)
        result[corners] = footprints.points[corners] @ rotation[rows_of_count]
    return result


def _levelled(local: Floats, footprints: Footprints) -> Floats:
    """[P, 3] corners in scope axes; those of plane footprints have exactly one height."""
    first = footprints.offsets[:-1]
    low, high = (bound.reduceat(local, first, axis=0) for bound in (np.minimum, np.maximum))
    extent = high - low
    is_plane = extent[:, 1] <= _FLAT_SHARE * extent.max(axis=1)
    height = np.where(is_plane, local[first, 1], np.nan).repeat(np.diff(footprints.offsets))
    local[:, 1] = np.where(np.isnan(height), local[:, 1], height)
    return local


def _polygons(points: Floats, footprints: Footprints) -> Meshes:
    """[F] meshes of one face; bridges to its holes are passed in both directions over the same points."""
    counts = np.diff(footprints.offsets)
    row = row_of_value(counts)
    visited, corners = _first_visits(np.column_stack([row.astype(np.float64), footprints.points]))
    per_mesh = np.bincount(row[visited], minlength=len(counts))
    mesh_points = offsets_from_counts(per_mesh)
    return Meshes(
        points=points[visited],
        corners=corners - mesh_points[row],
        face_offsets=footprints.offsets,
        mesh_faces=np.arange(len(counts) + 1),
        mesh_points=mesh_points,
        tags=np.full(len(counts), UNTAGGED, dtype=np.int8),
    )


def _first_visits(points: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices of the first occurrences of points [P, K], ascending, and the number of each point among them."""
    order = np.lexsort(points.T)
    ordered = points[order]
    begins = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1)) if len(points) else np.zeros(0, dtype=bool)
    first = order[begins]  # the sort is stable, so that the first of equal ones comes first
    visited = np.sort(first)
    numbers = np.empty(len(points), dtype=np.int64)
    numbers[order] = np.searchsorted(visited, first)[np.cumsum(begins) - 1]
    return visited, numbers


def _is_rectangle(unit: Meshes) -> NDArray[np.bool_]:
    """[F] whether meshes in the unit cube are the whole rectangle y = 0 seen from above."""
    is_rectangle = np.diff(unit.mesh_points) == 4
    four = np.flatnonzero(is_rectangle & (np.diff(unit.face_offsets) == 4))
    corners = unit.points[unit.mesh_points[:-1][four][:, None] + np.arange(4)]
    is_rectangle[:] = False
    is_rectangle[four] = _are_near(corners, quad().points, 1e-9).all(axis=(1, 2))
    return is_rectangle


def _are_near(values: Floats, expected: Floats, tolerance: float) -> NDArray[np.bool_]:
    """[..., K] whether values are those expected [..., K]; a tenth of the time of `numpy.isclose` for few of them."""
    return np.abs(values - expected) <= tolerance + _SHARE * np.abs(expected)


def _folder(assets: str | AssetRoot | AssetFolder | None, grammar: Grammar | Program) -> AssetFolder | None:
    if assets is None and isinstance(grammar, Grammar):
        assets = grammar.assets
    if assets is None or isinstance(assets, AssetFolder):
        return assets
    root = Path(assets) if isinstance(assets, str) else assets
    if not root.is_dir():
        raise UsageError(f"assets: expected a folder of meshes and images, found {str(root)!r}, which is none.")
    return AssetFolder(root)


def _evaluate_attributes(workspace: Workspace) -> None:
    """Evaluate every random attribute, and set the state of the initial shapes that rules read or change."""
    for attribute in workspace.attributes.values():
        if attribute.draws:
            workspace.attribute(attribute.name)
    state = {name: STATE_DEFAULTS[name] for name in workspace.state_names if name in STATE_DEFAULTS}
    attributes = {name: workspace.attribute(name) for name in workspace.state_names if name in workspace.attributes}
    workspace.roots = workspace.roots._replace(state={**workspace.roots.state, **state, **attributes})


def _run(program: Program, workspace: Workspace, starts: Ids) -> None:
    """Derive every model from its initial shape.

    Args:
        program: the grammar.
        workspace: with the initial shapes as `roots`, their nodes already recorded.
        starts: [N] number of the start rule of each model.

    Raises:
        BudgetError: If a model has too many shapes, or a recursive group of rules is too deep.
        DerivationError: If an operation cannot be applied.
    """
    pending, roots = workspace.pending, workspace.roots
    workspace.finish = partial(_finish, program, workspace)
    different = distinct(starts, len(program.rules)).tolist()
    for start in different:
        pending[start].append(roots if len(different) == 1 else roots.take(np.flatnonzero(starts == start)))
    try:
        workspace.finish()
    finally:
        # What refers to itself stays in memory until the collector of cycles comes, some hundred megabytes later.
        workspace.finish = nothing


def _finish(program: Program, workspace: Workspace) -> None:
    """Apply the rules of all pending shapes, and of those that they make."""
    pending = workspace.pending
    for group in program.order:
        waves = 0
        while any(pending[rule] for rule in group):
            if waves > workspace.budget.depth:
                raise _too_deep(program, workspace, group)
            waves += 1
            for rule in group:
                chunks, pending[rule] = pending[rule], []
                if chunks:
                    if program.rules[rule].is_bare and not workspace.recorder.has_leaves:
                        chunks = [chunk.bare() for chunk in chunks]
                    _rewrite(program.rules[rule], concatenate(chunks, workspace.strings), workspace)
                    _check_size(workspace, program.symbols[program.rules[rule].symbol])


def _too_deep(program: Program, workspace: Workspace, group: tuple[int, ...]) -> BudgetError:
    names = " -> ".join(program.symbols[program.rules[rule].symbol] for rule in group)
    waiting = next(rule for rule in group if workspace.pending[rule])
    models = np.concatenate([chunk.model for chunk in workspace.pending[waiting]])
    depth, model = workspace.budget.depth, workspace.lots.name(models.min())
    return BudgetError(
        f"the rules {names} call themselves more than {depth} times in {model}",
        None,
        "a recursive rule needs a case that ends it, or an expected number of successors below one",
    )


def _rewrite(rule: CompiledRule, shapes: Shapes, workspace: Workspace) -> None:
    """Apply one rule to all its pending shapes."""
    for operations, _, chosen in route(rule.body, with_variables(shapes, rule.variables, workspace), workspace):
        workspace.recorder.set_rule(chosen.node, operations.rule)
        operations.run(chosen, workspace)


def _check_size(workspace: Workspace, symbol: str) -> None:
    """Refuse models that exceed their budget.

    Nodes per model are counted only when one model could have exceeded it.
    """
    recorder, budget = workspace.recorder, workspace.budget.shapes
    if recorder.num_nodes <= workspace.count_again_at:
        return
    model, count = recorder.largest_model()
    workspace.count_again_at = recorder.num_nodes + budget - count
    if count > budget:
        raise BudgetError(
            f"{workspace.lots.name(model)} has more than {budget} shapes after the rule {symbol}",
            None,
            "look for a rule that calls itself, directly or not, or raise the shape budget",
        )
