"""Example models of grammars to learn from: derivations on disk, possibly from strangers, checked against a grammar.

Every number of a file is checked before it is used: sizes are bounded, and the trees must be trees of the
grammar; percentages may differ. Geometry is not read.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.density.grammar_skeleton import TreeGrammar
from grammarlab.density.samples.examples import EXAMPLE_METHODS, ExampleMethod, learn_from_examples
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Draws, Forest, Leaves, Nodes, Reports
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.derivation.program import Program
from grammarlab.derivation.selection import join_forests
from grammarlab.errors import AssetError, UsageError
from grammarlab.files import PART_PREFIX, read_bounded
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool, PoolDesigns
from grammarlab.learning.targets.writers import Learned
from grammarlab.runs.learn.example_learners import AbstractExampleLearner
from grammarlab.runs.sample.derivations import HEADER
from grammarlab.runs.sample.records import DERIVATIONS

MAX_HEADER_BYTES = 16 << 20
"""Largest size of a header in bytes."""
MAX_FILE_BYTES = 1 << 30
"""Largest size of a table in bytes."""
MAX_MODELS = 200_000
"""Largest number of examples."""
MAX_ROWS = 50_000_000
"""Largest number of nodes, or draws, of all examples together."""
MAX_FOLDERS = 20_000
"""Largest number of batches in a folder."""
_NODES, _DRAWS = "nodes.parquet", "draws.parquet"
_NODE_COLUMNS = ("model", "parent", "symbol", "rule", "child", "repeat")
_DRAW_COLUMNS = {"node": True, "site": True, "value": False, "log_density": False}
"""Whether each column has whole numbers."""


@dataclass(frozen=True, slots=True)
class _Names:
    """Indices in the program of the grammar for the integers of a folder, -1 for none."""

    num_models: int
    symbols: Ints
    rules: Ints
    sites: Ints


@dataclass(frozen=True)
class GrammarExamples(AbstractExampleLearner[Forest]):
    """Learns the maximum-likelihood grammar of models near a grammar."""

    space: GrammarSpace

    @property
    def methods(self) -> tuple[str, ...]:
        return EXAMPLE_METHODS

    def read(self, path: Path) -> Forest:
        return example_models(path, self.space.grammar)

    def count(self, designs: Forest) -> int:
        return designs.num_models

    def take(self, designs: Forest, indices: Ints) -> Forest:
        return self.space.take(designs, indices)

    def learn(self, designs: Forest, method: str, lines: Sequence[str]) -> tuple[Learned[Forest], int]:
        chosen, grammar = cast(ExampleMethod, method), self.space.grammar
        learned = learn_from_examples(grammar, designs, chosen, header=lines, assets=self.space.assets)
        return learned, len(learned.components)

    def ratio(self, learned: Learned[Forest], designs: Forest) -> Floats:
        return learned.ratio(designs)

    def pool(self, learned: Learned[Forest], seed: int) -> tuple[Floats, Floats]:
        pool_designs = PoolDesigns.of(self.space, Pool.usual(self.space, seed))
        return np.concatenate([learned.ratio(forest) for forest in pool_designs.batches]), pool_designs.weights


def example_models(path: Path, grammar: Grammar) -> Forest:
    """Models from a path as trees of a grammar, without geometry.

    Args:
        path: output of `grammarlab sample`: its folder, ``derivations`` in it, or one batch of these; or a Parquet
            file with a table of nodes. A file without ``forest.json`` beside it has the numbering of symbols and
            rules of the grammar, and no drawn attributes.
        grammar: the grammar that can make them.

    Raises:
        UsageError: If there are no models, or they are not of the grammar.
        AssetError: If files are damaged or too large.
    """
    program, tree = compile_grammar(grammar), TreeGrammar.of(grammar)
    forests: list[Forest] = []
    models = rows = 0
    for nodes in _node_files(path):
        try:
            forest = _forest(nodes, program, _Slots.of(program, tree))
        except (ValueError, LookupError, TypeError, OSError, RecursionError, pa.ArrowException) as error:
            raise AssetError(
                f"{nodes}: these derivations are damaged, or of another grammar ({error}). Sample them again."
            ) from error
        models, rows = models + forest.num_models, rows + len(forest.nodes)
        if models > MAX_MODELS or rows > MAX_ROWS:
            raise AssetError(
                f"{path}: {models:,} models with {rows:,} nodes and more; {MAX_MODELS:,} with {MAX_ROWS:,} can be "
                "learned from. Give a part of them."
            )
        forests.append(forest)
    return join_forests(forests)


def _node_files(path: Path) -> tuple[Path, ...]:
    """The tables of nodes at a path."""
    if path.is_file():
        if path.suffix != ".parquet":
            raise UsageError(f"{path}: expected a folder that grammarlab sample wrote, or a Parquet file.")
        sibling = path.with_name(_NODES)
        return (sibling if path.with_name(HEADER).is_file() and sibling.is_file() else path,)
    if not path.is_dir():
        raise UsageError(f"no examples at {str(path)!r}: expected a folder that grammarlab sample wrote.")
    for folder in (path / DERIVATIONS, path):
        if (folder / _NODES).is_file():
            return (folder / _NODES,)
        # A folder of a batch that was killed may lack rows.
        files = sorted(file for file in folder.glob(f"*/{_NODES}") if not file.parent.name.startswith(PART_PREFIX))
        if len(files) > MAX_FOLDERS:
            raise AssetError(f"{folder}: {len(files):,} batches; {MAX_FOLDERS:,} can be read.")
        if files:
            return tuple(files)
    raise UsageError(f"{path}: expected derivations in this folder, as grammarlab sample writes them, found none.")


def _forest(file: Path, program: Program, slots: _Slots) -> Forest:
    columns = _read(file, dict.fromkeys(_NODE_COLUMNS, True))
    header = file.with_name(HEADER)
    alone = not header.is_file()
    num_models = int(columns["model"].max(initial=-1)) + 1
    names = _own_names(program, num_models) if alone else _names(header, program)
    nodes = _nodes(columns, names, slots)
    draws = {name: np.zeros(0) for name in _DRAW_COLUMNS}
    if not alone and file.with_name(_DRAWS).is_file():
        draws = _read(file.with_name(_DRAWS), _DRAW_COLUMNS)
    none, empty = np.zeros(0, dtype=np.int32), np.zeros((0, 3))
    zero = np.zeros(1, dtype=np.int64)
    return Forest(
        lots=Lots.of(names.num_models, seed=0),
        symbols=program.symbols,
        rules=program.rule_names,
        sites=program.sites,
        nodes=nodes,
        leaves=Leaves(node=none, position=empty, size=empty, frame=none, mesh=none, material=none, texture_map=none),
        draws=_draws(draws, names, len(nodes), program),
        reports=Reports(none, none, np.zeros(0), ()),
        frames=np.zeros((0, 3, 3)),
        meshes=Meshes(
            points=empty,
            corners=zero[:0],
            face_offsets=zero,
            mesh_faces=zero,
            mesh_points=zero,
            tags=np.zeros(0, dtype=np.int8),
        ),
        materials=Materials(np.zeros((0, len(CHANNELS))), ()),
        texture_maps=np.zeros((0, 2, 4)),
    )


# Names


def _own_names(program: Program, num_models: int) -> _Names:
    sizes = (len(program.symbols), len(program.rule_names), len(program.sites))
    return _Names(num_models, *(np.arange(size) for size in sizes))


def _names(header: Path, program: Program) -> _Names:
    """Content of ``forest.json``."""
    values = json.loads(read_bounded(header, MAX_HEADER_BYTES))
    num_models = values["num_models"]
    if not isinstance(num_models, int) or not 0 <= num_models <= MAX_MODELS:
        raise ValueError(f"{num_models!r:.40} models")
    own_rules = [(rule.symbol, rule.parameters, rule.branch) for rule in program.rule_names]
    rules = [(str(rule[0]), rule[1], tuple(rule[2])) for rule in values["rules"]]
    # Derivations of the first version have other names of sites: their draws are left out.
    sites = [tuple(site[:3]) if isinstance(site, list) else () for site in values["sites"]]
    own_sites = [(site.name, site.kind, site.definition) for site in program.sites]
    return _Names(
        num_models,
        _indices(program.symbols, [str(symbol) for symbol in values["symbols"]]),
        _indices(own_rules, rules),
        _indices(own_sites, sites),
    )


def _indices(names: Sequence[object], items: Sequence[object]) -> Ints:
    index_of = {item: i for i, item in enumerate(names)}
    return np.array([index_of.get(item, -1) for item in items], dtype=np.int64)


# Tables


def _read(file: Path, kinds: Mapping[str, bool]) -> dict[str, NDArray[Any]]:
    """Columns of numbers, whole if their kind requires it."""
    if not file.is_file() or file.stat().st_size > MAX_FILE_BYTES:
        raise ValueError(f"{file.name} has more than {MAX_FILE_BYTES:,} bytes")
    with file.open("rb") as stream, pq.ParquetFile(stream) as table:
        if table.metadata.num_rows > MAX_ROWS:
            raise ValueError(f"{file.name} has more than {MAX_ROWS:,} rows")
        for name, is_integer in kinds.items():
            kind = table.schema_arrow.field(name).type
            if not (pa.types.is_integer(kind) if is_integer else pa.types.is_floating(kind)):
                raise ValueError(f"column {name} of {file.name} holds {kind}")
        values = table.read(columns=list(kinds), use_threads=False)
    if any(values.column(name).null_count for name in kinds):
        raise ValueError(f"{file.name} has cells without a value")
    return {
        name: values.column(name).cast(pa.int64() if is_integer else pa.float64()).to_numpy()
        for name, is_integer in kinds.items()
    }


def _within(values: Ints, low: int, high: int, what: str) -> None:
    if len(values) and not (low <= values.min() and values.max() < high):
        raise ValueError(f"expected {what} from {low} to {high - 1}, found {values.min()} to {values.max()}")


def _nodes(columns: Mapping[str, Ints], names: _Names, slots: _Slots) -> Nodes:
    """The nodes, if they are trees of the grammar."""
    model, parent, rule = columns["model"], columns["parent"], columns["rule"]
    size = len(model)
    _within(model, 0, names.num_models, "models")
    _within(columns["symbol"], 0, len(names.symbols), "symbols")
    _within(rule, -1, len(names.rules), "rules")
    _within(columns["repeat"], 0, 1 << 31, "repeats")
    if (parent < -1).any() or (parent >= np.arange(size)).any():
        raise ValueError("a node is not below its parent")
    inner = np.flatnonzero(parent >= 0)
    roots = np.bincount(model[parent < 0], minlength=names.num_models)
    if (roots != 1).any() or (model[parent[inner]] != model[inner]).any():
        raise ValueError("expected one tree per model")
    symbol = names.symbols[columns["symbol"]]
    own_rule = np.append(names.rules, -1)[rule]
    slots.check(symbol, np.where((rule >= 0) & (own_rule < 0), slots.UNKNOWN, own_rule), parent, columns["child"])
    return Nodes(
        model.astype(np.int32),
        parent.astype(np.int32),
        symbol.astype(slots.program.id_type),
        own_rule.astype(slots.program.id_type),
        columns["child"].astype(slots.program.id_type),
        columns["repeat"].astype(np.int32),
    )


def _draws(columns: Mapping[str, NDArray[Any]], names: _Names, num_nodes: int, program: Program) -> Draws:
    """Draws of the random expressions of the grammar."""
    node, site = columns["node"].astype(np.int64), columns["site"].astype(np.int64)
    _within(node, 0, num_nodes, "nodes")
    _within(site, 0, len(names.sites), "random expressions")
    sites = names.sites[site] if len(site) else site
    is_known = sites >= 0
    value, log_density = columns["value"][is_known], columns["log_density"][is_known]
    if not np.isfinite(value).all() or np.isnan(log_density).any():
        raise ValueError("a draw is not a number")
    choices = np.array([program_site.choices for program_site in program.sites], dtype=np.int64)[sites[is_known]]
    if ((choices > 0) & ((value < 0) | (value >= choices) | (value != np.floor(value)))).any():
        raise ValueError("a choice has no branch of that number")
    return Draws(node[is_known].astype(np.int32), sites[is_known].astype(program.id_type), value, log_density)


@dataclass(frozen=True, slots=True)
class _Slots:
    """Symbols of the successors of each rule."""

    UNKNOWN = -2
    """Marks a rule that the grammar does not have."""

    program: Program
    symbol_of_rule: Ints
    """[R + 1] the last one for leaves: any."""
    first: Ints
    """[R + 1] offsets of the successors of each rule in `successor`."""
    successor: Ints
    """Symbols of successors, one rule after the other."""
    start: int
    """The symbol of a root."""

    @classmethod
    def of(cls, program: Program, tree: TreeGrammar) -> _Slots:
        index_of = {name: i for i, name in enumerate(program.symbols)}
        alternatives = {
            (key, alternative.branch): alternative for key in tree.bodies for alternative in tree.alternatives(key)
        }
        below = [
            [index_of[s.key[0]] for s in alternatives[(rule.symbol, rule.parameters), rule.branch].successors]
            for rule in program.rule_names
        ]
        return cls(
            program,
            np.array([*(index_of[rule.symbol] for rule in program.rule_names), -1], dtype=np.int64),
            np.cumsum([0, *map(len, below)]),
            np.array([symbol for symbols in below for symbol in symbols], dtype=np.int64),
            index_of[tree.start[0]],
        )

    def check(self, symbol: Ints, rule: Ints, parent: Ints, child: Ints) -> None:
        """Check that children match the rules of their parents.

        Raises:
            UsageError: If they do not.
        """
        inner = np.flatnonzero(parent >= 0)
        above = rule[parent[inner]]
        slot = self.first[above] + child[inner]
        fits = (
            (symbol >= 0).all()
            and (rule != self.UNKNOWN).all()
            and ((rule < 0) | (self.symbol_of_rule[rule] == symbol)).all()
            and (symbol[parent < 0] == self.start).all()
            and (above >= 0).all()
            and (child[inner] >= 0).all()
            and (slot < self.first[above + 1]).all()
            and (self.successor[slot] == symbol[inner]).all()
        )
        if not fits:
            raise UsageError(
                "the examples are not models of this grammar: its symbols or rules differ, or they begin with "
                "another rule, which `start_rule=` chooses. Learn from models that the rule file itself can make; "
                "percentages may differ."
            )
