"""Records of a derivation: nodes, leaves, draws, reports, prints and missing assets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.forest import Draws, Leaves, MissingAsset, NodeIds, Nodes, Reports, by_path, by_place
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.state.box_orders import kinds
from grammarlab.derivation.state.lineage import NO_PART, PART, Lineage, SiblingOrder
from grammarlab.derivation.state.mesh_table import MeshTable, right_handed, upright
from grammarlab.derivation.state.shapes import EMPTY, Ids, Shapes
from grammarlab.derivation.state.texture_maps import NONE, map_ids, map_name
from grammarlab.errors import Finding, Location

_MOST_PRINTS = 10_000
"""Largest number of printed lines of one derivation that are stored."""
_MOST_WARNINGS = 1_000
"""Largest number of different warnings of one derivation."""
_ZERO = np.zeros(1, dtype=np.int32)
_NO_IDS = np.zeros(0, dtype=np.int32)
_NO_VECTORS = np.zeros((0, 3))
_LEAF_COLUMNS = ("node", "position", "size", "frame", "mesh", "material")


class Recorder:
    """Chunks of columns, joined once at the end."""

    def __init__(
        self,
        id_type: np.dtype[np.int16 | np.int32],
        lineage: Lineage | None = None,
        has_leaves: bool = True,
        siblings: SiblingOrder | None = None,
    ) -> None:
        """No records yet.

        Args:
            id_type: type of the columns of symbols, rules and children.
            lineage: keys of shapes that a second derivation finds again.
            has_leaves: whether the leaves of the models are recorded.
            siblings: numbers of nodes among their siblings, if rules ask for them.
        """
        self.siblings = siblings
        self._id_type = id_type
        self.has_leaves = has_leaves
        self.lineage = lineage
        self._roots = np.zeros(0, dtype=np.int32)
        self.num_nodes = 0
        self._nodes: list[tuple[Ids, Ids | None, int, int, Ids | None]] = []
        self._counts = np.zeros(0, dtype=np.int64)
        """Nodes of each model in the first ``_num_counted`` chunks."""
        self._num_counted = 0
        self._rules: list[tuple[Ids, int]] = []
        self._leaves: list[Shapes] = []
        self._fruitful: list[Ids] | None = None
        self._draws: list[tuple[Ids, int, Floats, float | Floats]] = []
        self._drawn_roots: dict[int, NDArray[np.bool_]] = {}
        """Whether each root has a draw at a site, after the first chunks of draws."""
        self._num_noted = 0
        self._reports: list[tuple[Ids, str, Floats]] = []
        self._missing_assets: set[MissingAsset] = set()
        self._warnings: dict[Finding, None] = {}
        self.prints: list[str] = []

    def add_roots(self, models: Ids, symbols: Ids) -> Ids:
        """Rows [N] of the roots of models [N] with symbols [N]; they come first."""
        self._roots = symbols
        self._nodes.append((models, None, 0, 0, None))
        if self.lineage is not None:
            self.lineage.add_roots(models)
        if self.siblings is not None:
            self.siblings.add_nodes(np.full(len(models), -1, np.int32), NO_PART, 0)
        return self._grow(len(models))

    def add_children(self, shapes: Shapes, symbol: int, child: int, in_block: bool) -> Ids:
        """Rows [N] of one new child of the node of each shape.

        Args:
            shapes: [N] the shapes, with their parents as `node`.
            symbol: the symbol of all of them.
            child: index of the successor in the parents' rule.
            in_block: whether one parent may have several of them.
        """
        self.add_nothing(shapes)
        repeat = _count_in_run(shapes.node) if in_block else None
        self._nodes.append((shapes.model, shapes.node, symbol, child, repeat))
        if self.lineage is not None:
            self.lineage.add_children(shapes.node, child, repeat)
        if self.siblings is not None:
            self.siblings.add_nodes(shapes.node, cast("Ids", shapes.state[PART]), child)
        return self._grow(shapes.num)

    def add_nothing(self, shapes: Shapes) -> None:
        """Note that the nodes of shapes are no leaves; `add_children` does so, too."""
        if self._fruitful is not None:
            self._fruitful.append(shapes.node)

    def fruitless(self, apply: Callable[[], Shapes]) -> Shapes | None:
        """Those of the shapes that operations end with whose nodes got neither a child nor NIL; None for none."""
        outside, self._fruitful = self._fruitful, []
        try:
            shapes = apply()
            rows = _missing_from(shapes.node, self._fruitful)
            return shapes.take(rows) if len(rows) else None
        finally:
            self._fruitful = outside

    def set_rule(self, nodes: Ids, rule: int) -> None:
        """Record the rule that rewrote these nodes."""
        self._rules.append((nodes, rule))

    def add_leaves(self, shapes: Shapes) -> None:
        """Record the geometry of finished shapes."""
        if self.has_leaves:
            self._leaves.append(shapes)

    def leaves_apart(self, derive: Callable[[], None]) -> list[Shapes]:
        """Shapes that a part of a derivation finishes; they are not leaves of the models."""
        outside, self._leaves = self._leaves, []
        fruitful, self._fruitful = self._fruitful, None
        has_leaves, self.has_leaves = self.has_leaves, True
        try:
            derive()
            return self._leaves
        finally:
            self._leaves, self._fruitful, self.has_leaves = outside, fruitful, has_leaves

    def finished(self) -> Iterator[Shapes]:
        """The finished shapes."""
        return iter(self._leaves)

    def add_draw(self, shapes: Shapes, site: int, values: Floats, log_density: float | Floats) -> None:
        """Record one draw [N] for each shape."""
        self._draws.append((shapes.node, site, values, log_density))

    @contextmanager
    def without_repeats(self) -> Iterator[None]:
        """Keeps only the first draw of each root at each site, of those in a block that evaluates attributes again."""
        count = len(self._draws)
        try:
            yield
        finally:
            made = self._draws[count:]
            del self._draws[count:]
            for nodes, site, values, density in made:
                fresh = self._not_drawn(nodes, site)
                if len(fresh):
                    of_fresh = density[fresh] if isinstance(density, np.ndarray) else density
                    self._draws.append((nodes[fresh], site, values[fresh], of_fresh))

    def _not_drawn(self, nodes: Ids, site: int) -> NDArray[np.int64]:
        """Places [K] of the different ones of roots [N] that have no draw at a site."""
        num_roots = len(self._roots)
        for earlier, of_site, *_ in self._draws[self._num_noted :]:
            drawn = self._drawn_roots.setdefault(of_site, np.zeros(num_roots, dtype=bool))
            drawn[earlier[earlier < num_roots]] = True
        self._num_noted = len(self._draws)
        different, first = np.unique(nodes, return_index=True)
        drawn = self._drawn_roots.get(site)
        return first if drawn is None else first[~drawn[different]]

    def add_report(self, nodes: Ids, key: str, values: Floats) -> None:
        """Record one reported number [N] for a shape of each node [N]."""
        self._reports.append((nodes, key, values))

    def add_prints(self, texts: Sequence[str]) -> None:
        """Record printed texts, up to a bound: a rule may print for every one of a million shapes."""
        self.prints += texts[: max(0, _MOST_PRINTS - len(self.prints))]

    def add_missing_asset(self, path: str, location: Location, reason: str = "") -> None:
        """Record a missing asset and its place in the rules, or why it cannot be read."""
        self._missing_assets.add(MissingAsset(path, location, reason))

    def add_warning(self, message: str, location: Location, hint: str = "") -> None:
        """Record what a derivation passed over, once per place."""
        if len(self._warnings) < _MOST_WARNINGS:
            self._warnings.setdefault(Finding("warning", "passed-over", message, location, hint))

    def warnings(self) -> tuple[Finding, ...]:
        """All warnings, by place."""
        return by_place(self._warnings)

    def missing_assets(self) -> tuple[MissingAsset, ...]:
        """All missing assets."""
        return by_path(self._missing_assets)

    def largest_model(self) -> tuple[int, int]:
        """The model with the most nodes so far, and their number."""
        if self._num_counted == 0:
            self._counts = np.zeros(len(self._roots), dtype=np.int64)
        for models, *_ in self._nodes[self._num_counted :]:
            self._counts += np.bincount(models, minlength=len(self._counts))
        self._num_counted = len(self._nodes)
        return int(self._counts.argmax()), int(self._counts.max())

    def nodes(self) -> Nodes:
        """All nodes; they are given away, so it may be called only once, after at least one batch was added.

        Raises:
            ValueError: If there are no nodes, or no longer.
        """
        models, parents, symbols, children, repeats = map(list, zip(*self._nodes, strict=True))
        self._nodes.clear()
        counts = [len(model) for model in models]
        rule = np.full(self.num_nodes, -1, dtype=self._id_type)
        for nodes, number in self._rules:
            rule[nodes] = number
        self._rules.clear()
        symbol = self._spread(symbols, counts)
        symbol[: len(self._roots)] = self._roots
        return Nodes(
            _drained(models, _NO_IDS),
            _filled(parents, counts, -1),
            symbol,
            rule,
            self._spread(children, counts),
            _filled(repeats, counts, 0),
        )

    def leaves(self, meshes: MeshTable, frames: FrameTable) -> Leaves:
        """All leaves that have geometry, in scopes of positive height; boxes share one mesh for all orders of faces.

        They are given away: a second call has none.
        """
        given, self._leaves = self._leaves, []
        chunks = [_with_geometry(upright(right_handed(c, meshes, frames), meshes, frames)) for c in given]
        given.clear()
        return _leaves(chunks)

    def draws(self) -> Draws:
        """All draws."""
        counts = [len(node) for node, *_ in self._draws]
        densities = [np.broadcast_to(density, count) for (*_, density), count in zip(self._draws, counts, strict=True)]
        return Draws(
            _joined([node for node, *_ in self._draws], np.int32),
            self._spread([site for _, site, *_ in self._draws], counts),
            _joined([values for _, _, values, _ in self._draws], np.float64),
            _joined(densities, np.float64),
        )

    def reports(self) -> Reports:
        """All reported values."""
        keys = tuple(sorted({key for _, key, _ in self._reports}))
        index_by_key = {key: index for index, key in enumerate(keys)}
        counts = [len(node) for node, *_ in self._reports]
        return Reports(
            _joined([node for node, *_ in self._reports], np.int32),
            np.repeat(np.array([index_by_key[key] for _, key, _ in self._reports], dtype=np.int32), counts),
            _joined([values for *_, values in self._reports], np.float64),
            keys,
        )

    def _spread(self, values: Sequence[int], counts: Sequence[int]) -> NodeIds:
        """Values repeated by the number of rows of each chunk."""
        return np.array(values, dtype=self._id_type).repeat(counts)

    def _grow(self, count: int) -> Ids:
        first = self.num_nodes
        self.num_nodes += count
        return np.arange(first, first + count, dtype=np.int32)


def _leaves(chunks: list[Shapes]) -> Leaves:
    """The leaves of chunks, whose columns are let go one after the other, so that the next one takes their memory."""
    counts = [shapes.num for shapes in chunks]
    texture_maps = [_texture_map(shapes) for shapes in chunks]
    columns = {name: [getattr(shapes, name) for shapes in chunks] for name in _LEAF_COLUMNS}
    chunks.clear()
    return Leaves(
        node=_drained(columns["node"], _NO_IDS),
        position=_drained(columns["position"], _NO_VECTORS),
        size=_drained(columns["size"], _NO_VECTORS),
        frame=_drained(columns["frame"], _NO_IDS),
        mesh=kinds(_drained(columns["mesh"], _NO_IDS)),
        material=_drained(columns["material"], _NO_IDS),
        texture_map=_filled(texture_maps, counts, NONE),
    )


def _drained(columns: list[NDArray], nothing: NDArray) -> NDArray:
    """All of some columns, which are let go."""
    whole = np.concatenate([nothing, *columns])
    columns.clear()
    return whole


def _texture_map(shapes: Shapes) -> Ids | None:
    """[N] the maps of the first uv set, that of the colour map; None without any."""
    return map_ids(shapes, 0) if map_name(0) in shapes.state else None


def _with_geometry(shapes: Shapes) -> Shapes:
    """The shapes that are not empty."""
    is_empty = shapes.mesh == EMPTY
    return shapes.take(np.flatnonzero(~is_empty)) if is_empty.any() else shapes


def _joined(columns: Sequence[NDArray[np.generic]], dtype: type[np.generic]) -> NDArray:
    return np.concatenate([np.zeros(0, dtype), *columns]).astype(dtype, copy=False)


def _filled(columns: list[Ids | None], counts: Sequence[int], missing: int) -> Ids:
    """Columns one after the other, with a value in place of missing ones; they are let go."""
    whole = np.empty(sum(counts), np.int32)
    ends = np.cumsum(counts).tolist()
    for column, count, end in zip(columns, counts, ends, strict=True):
        whole[end - count : end] = missing if column is None else column
    columns.clear()
    return whole


def _missing_from(nodes: Ids, chunks: Sequence[Ids]) -> NDArray[np.int64]:
    """Places [K] of those of ascending nodes [N] that are in none of the chunks, which consist of some of them."""
    if any(len(chunk) == len(nodes) and (chunk == nodes).all() for chunk in chunks):
        return np.zeros(0, np.int64)
    first = int(nodes[0]) if len(nodes) else 0
    is_missing = np.ones(len(nodes) and int(nodes[-1]) - first + 1, dtype=bool)
    for chunk in chunks:
        is_missing[chunk - first] = False
    return np.flatnonzero(is_missing[nodes - first])


def _count_in_run(values: Ids) -> Ids:
    """Number of equal values before each value of an ascending column."""
    if len(values) == 1:
        return _ZERO
    if values[0] == values[-1]:
        return np.arange(len(values), dtype=np.int32)
    differs = values[1:] != values[:-1]
    if differs.all():
        return np.zeros(len(values), dtype=np.int32)
    starts = np.flatnonzero(np.concatenate(([True], differs)))
    lengths = np.diff(np.append(starts, len(values)))
    return (np.arange(len(values)) - np.repeat(starts, lengths)).astype(np.int32)
