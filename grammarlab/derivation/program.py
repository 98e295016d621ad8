"""Compiled grammar.

Rules, attributes and functions are compiled, symbols and sites numbered, rules ordered by their calls.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.derivation.calls.branches import Branching
from grammarlab.derivation.forest import RuleName, Site
from grammarlab.derivation.operation_sequences import Operations
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.derivation.state.workspace import Code, CompiledAttribute, Workspace


@dataclass(frozen=True, slots=True)
class CompiledRule:
    """A rule: one symbol with one number of parameters."""

    symbol: int
    body: Branching[Operations]
    variables: tuple[Code, ...] = ()
    """Local variables, evaluated in order before the body; their values follow the parameters in `Shapes.locals`."""
    is_bare: bool = False
    """Whether its shapes need no geometry while no leaves are recorded."""


def with_variables(shapes: Shapes, variables: Sequence[Code], workspace: Workspace) -> Shapes:
    """Shapes whose local variables are evaluated, each with those before it."""
    for code in variables:
        shapes = shapes._replace(locals=(*shapes.locals, code(shapes, workspace)))
    return shapes


@dataclass(frozen=True, slots=True)
class Program:
    """A compiled grammar, independent of models and seeds."""

    symbols: tuple[str, ...]
    rule_names: tuple[RuleName, ...]
    sites: tuple[Site, ...]
    attributes: Mapping[str, CompiledAttribute]
    rules: tuple[CompiledRule, ...]
    order: tuple[tuple[int, ...], ...]
    """Groups of rules that may call each other, every group before the groups it calls."""
    start_rules: Mapping[str, int]
    """Rules without parameters, by symbol: possible start rules."""
    default_start: str
    state_names: frozenset[str]
    """Attributes that some rule sets and shape attributes that some expression reads: entries of `Shapes.state`."""
    most_successors: int
    """Largest number of successors of a rule branch."""
    uv_sets: frozenset[int]
    """Sets of texture coordinates that operations and expressions use; all sets if the number of one is computed."""

    has_trim_planes: bool
    """Whether rules insert or trim meshes below components, for which shapes remember trim planes."""
    trims_again: bool
    """Whether rules may switch trim planes on, so that shapes keep planes that are off."""
    selects_streets: bool
    """Whether rules use selectors such as ``street.front``, for which shapes remember the edges of their lots."""
    uses_tags: bool
    """Whether rules read tags, for which faces remember theirs."""
    queries_context: bool
    """Whether rules use spatial queries, for which models are derived twice."""
    reads_tree_keys: bool
    """Whether rules use ``getTreeKey``, for which nodes remember their places among their siblings."""
    import_prefixes: tuple[str, ...]
    """Beginnings, such as ``Tree.``, of the names of files that the rules import and that were not read."""

    @property
    def id_type(self) -> np.dtype[np.int16 | np.int32]:
        """Types of the columns of symbols, rules, children and sites: as narrow as this grammar allows."""
        most = max(len(self.symbols), len(self.rule_names), len(self.sites), self.most_successors)
        return np.dtype(np.int16) if most <= np.iinfo(np.int16).max else np.dtype(np.int32)  # ty: ignore[invalid-explicit-return]
