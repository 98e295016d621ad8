"""Trace of the derivation of one model in the rule text: an indented tree, or rows for programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation.expressions import number_grammar
from grammarlab.derivation.forest import Forest, Site, origin_of
from grammarlab.derivation.lots import DEFAULT_FOOTPRINT, Footprint, Lots
from grammarlab.errors import Location, UsageError
from grammarlab.features.acceptance import Acceptance, derive_accepted
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.geometry.footprints.footprint_text import read_footprint_map
from grammarlab.language.attribute_values import read_attributes, usable_properties
from grammarlab.language.grammar import read_text
from grammarlab.language.numbering import Numbering
from grammarlab.language.presets import RuleChoices
from grammarlab.runs.sample.models import property_remarks
from grammarlab.runs.sample.records import compiled
from grammarlab.runs.sample.shipped import find_rules

MAX_FORMS = 3
"""Shapes of one successor that are listed where they differ in what became of them."""
LINE_WIDTH = 80
"""Letters of a line of a tree, behind which all but the first draw go to further lines: as wide as a terminal."""


@dataclass(frozen=True, slots=True)
class DerivationTrace:
    """One model and the numbering of its grammar."""

    name: str
    """Name of the grammar."""
    forest: Forest
    """The model, first if there are several."""
    numbering: Numbering
    own_lines: int
    """Number of lines of the rule file; later lines are imported."""
    children: tuple[tuple[int, ...], ...]
    """Children of each node, in the order of the text and of the derivation."""
    draws: Mapping[int, tuple[int, ...]]
    """Rows of the draws of each node."""
    leaves: Mapping[int, tuple[int, ...]]
    """Rows of the visible shapes of each node."""
    remarks: tuple[Remark, ...] = ()
    """What is left out of the footprint."""


@dataclass(frozen=True, slots=True)
class TreeRow:
    """One row of a derivation tree, in the order in which a tree is read."""

    depth: int
    symbol: str
    """Symbol; empty for shapes that are not listed, which `note` counts."""
    note: str
    """Number of equal shapes, or of those left out; often empty."""
    made_at: Location | None
    """Place of the successor that made the shape; None for the initial shape."""
    rule_at: Location | None
    """Place of the branch of the rule that rewrote it; None for a leaf."""
    details: tuple[str, ...]
    """Draws, and the size of a visible shape, in words."""
    nodes: tuple[int, ...] = ()
    """The nodes of the shapes, of which the first one is listed; none where shapes are left out."""


def trace_model(
    grammar: str,
    model: int,
    seed: int,
    attributes: Sequence[str] = (),
    start_rule: str = "",
    footprint: str = "",
    assets: Path | None = None,
    library: Path | None = None,
) -> DerivationTrace:
    """Derive one model as in `grammarlab.runs.sample.run.sample_run`.

    Args:
        grammar: a path, or a name from ``grammarlab list``.
        model: index of the model under the seed, 0 <= model < 2**64.
        seed: 0 <= seed < 2**64.
        attributes: values of attributes as texts, in the syntax of `read_attributes`.
        start_rule: the start rule; empty for the one that the grammar marks.
        footprint: one polygon in the syntax of `read_footprints`; empty for the default footprint.
        assets: folder of assets, by default the one beside the rule file.
        library: folder of further projects that the rule file imports from.

    Raises:
        UsageError: If a value is out of range, or there are several footprints.
    """
    source = find_rules(grammar, assets, RuleChoices(library))
    rules, program = compiled(source.text(), source.name)
    values = read_attributes(attributes, rules)
    polygon: Footprint = DEFAULT_FOOTPRINT
    remarks: tuple[Remark, ...] = ()
    if footprint:
        plan = read_footprint_map(footprint)
        lot, *others = plan.footprints
        if others:
            raise UsageError(f"footprint: expected one polygon to show a model on, found {len(others) + 1}.")
        polygon, values = lot.polygon, {**usable_properties(lot.properties, rules).values, **values}
        remarks = (*plan.remarks, *property_remarks(lot, rules))
    acceptance, folder = Acceptance.of(rules.tree), AssetFolder(source.assets)
    lots = Lots.at(seed, model, polygon, values, start_rule or None)
    forest = derive_accepted(program, acceptance, lots, folder).forest
    own_lines = len(read_text(source.path).splitlines())
    return trace_of(forest, number_grammar(rules), source.name, own_lines, remarks)


def trace_of(
    forest: Forest, numbering: Numbering, name: str, own_lines: int, remarks: tuple[Remark, ...] = ()
) -> DerivationTrace:
    """The models of a forest with the tables of their trees; see `DerivationTrace`."""
    nodes = forest.nodes
    order = np.lexsort((nodes.repeat, nodes.child, nodes.parent))
    children = _by_node(nodes.parent[order], order)
    return DerivationTrace(
        name=name,
        forest=forest,
        numbering=numbering,
        own_lines=own_lines,
        children=tuple(children.get(node, ()) for node in range(len(nodes))),
        draws=_by_node(forest.draws.node),
        leaves=_by_node(forest.leaves.node),
        remarks=remarks,
    )


def as_values(trace: DerivationTrace) -> dict[str, Any]:
    """The model as plain values, one row per node."""
    forest, nodes = trace.forest, trace.forest.nodes
    rows = []
    for node, depth in _depth_first(trace):
        origin = origin_of(forest, trace.numbering, node)
        rows.append(
            {
                "node": node,
                "parent": int(nodes.parent[node]),
                "depth": depth,
                "symbol": origin.symbol,
                "made_at": _position(origin.made_at),
                "rule_at": _position(origin.rule_at),
                "draws": [
                    {"site": site.name, "kind": site.kind, "value": value, **(_position(location) or {})}
                    for site, value, location in _draws(trace, node)
                ],
                "sizes": [forest.leaves.size[leaf].tolist() for leaf in trace.leaves.get(node, ())],
            }
        )
    return {
        "grammar": trace.name,
        "model": int(forest.lots.model[0]),
        "seed": int(forest.lots.seed[0]),
        "log_probability": float(forest.log_probability()[0]),
        "nodes": rows,
    }


def as_lines(trace: DerivationTrace, everything: bool = False) -> Iterator[str]:
    """The model as an indented tree.

    Args:
        trace: the model.
        everything: whether equal shapes of one successor are listed one by one.
    """
    count, visible = len(trace.forest.nodes), len(trace.forest.leaves)
    yield f"{trace.name}, {trace.forest.lots}: {count:,} shapes, {visible:,} visible"
    if any(branch.location.line > trace.own_lines for branch in trace.numbering.branches):
        yield f"places after line {trace.own_lines} are those of imported rules, as they follow the rule file's own"
    yield "   made at   rule at  symbol"
    for row in tree_rows(trace, everything):
        if row.symbol:
            yield from _lines(row)
        else:
            yield f"{'':21}{'  ' * row.depth}{row.note}; --all lists them"


def tree_rows(
    trace: DerivationTrace, everything: bool = False, root: int = 0, forms: Sequence[int] | None = None
) -> Iterator[TreeRow]:
    """The rows of the tree of one model.

    Args:
        trace: the model, or several.
        everything: whether equal shapes of one successor are listed one by one.
        root: node of the initial shape of the model.
        forms: ``forms_of(trace)``, for the trees of several models.
    """
    forms = () if everything else forms_of(trace) if forms is None else forms
    waiting: list[tuple[tuple[int, ...], int, str]] = [((root,), 0, "")]
    while waiting:
        nodes, depth, note = waiting.pop()
        if not nodes:
            yield TreeRow(depth=depth, symbol="", note=note, made_at=None, rule_at=None, details=())
            continue
        yield _row(trace, nodes, depth, note)
        below = _all(trace, nodes[0]) if everything else _shortened(trace, nodes[0], forms)
        waiting += reversed([(children, depth + 1, note) for children, note in below])


def _all(trace: DerivationTrace, node: int) -> list[tuple[tuple[int, ...], str]]:
    return [((child,), "") for child in trace.children[node]]


def _shortened(trace: DerivationTrace, node: int, forms: Sequence[int]) -> list[tuple[tuple[int, ...], str]]:
    """The children to list, equal ones together with their number; none for those left out."""
    nodes = trace.forest.nodes
    listed: list[tuple[tuple[int, ...], str]] = []
    successors: dict[int, dict[int, list[int]]] = {}
    for child in trace.children[node]:
        successors.setdefault(int(nodes.child[child]), {}).setdefault(forms[child], []).append(child)
    for alike in successors.values():
        groups = list(alike.values())
        listed += [(tuple(group), f" x {len(group)}" if len(group) > 1 else "") for group in groups[:MAX_FORMS]]
        num_hidden = sum(map(len, groups[MAX_FORMS:]))
        if num_hidden:
            symbol = trace.forest.symbols[nodes.symbol[groups[0][0]]]
            listed.append(((), f"… {num_hidden:,} more {symbol}, each derived otherwise"))
    return listed


def forms_of(trace: DerivationTrace) -> list[int]:
    """Class of each node; equal if the same branches were taken below it."""
    nodes = trace.forest.nodes
    classes: dict[object, int] = {}
    forms = [0] * len(nodes)
    for node in reversed(range(len(nodes))):
        below = tuple((int(nodes.child[child]), forms[child]) for child in trace.children[node])
        forms[node] = classes.setdefault((int(nodes.symbol[node]), int(nodes.rule[node]), below), len(classes))
    return forms


def _depth_first(trace: DerivationTrace) -> Iterator[tuple[int, int]]:
    waiting = [(0, 0)]
    while waiting:
        node, depth = waiting.pop()
        yield node, depth
        waiting += reversed([(child, depth + 1) for child in trace.children[node]])


def _row(trace: DerivationTrace, nodes: tuple[int, ...], depth: int, note: str) -> TreeRow:
    node = nodes[0]
    origin = origin_of(trace.forest, trace.numbering, node)
    sizes = [trace.forest.leaves.size[leaf].tolist() for leaf in trace.leaves.get(node, ())]
    size_texts = [" x ".join(f"{extent:.2f}" for extent in size) + " m" for size in sizes[:1]]
    size_texts += [f"and {len(sizes) - 1} more"] if len(sizes) > 1 else []
    drawn = [_drawn(site, value) for site, value, _ in _draws(trace, node)]
    return TreeRow(
        depth=depth,
        symbol=origin.symbol,
        note=note,
        made_at=origin.made_at,
        rule_at=origin.rule_at,
        details=(*drawn, *size_texts),
        nodes=nodes,
    )


def _lines(row: TreeRow) -> Iterator[str]:
    """A line of a tree, and further ones below the symbol for draws that have no room in it."""
    made_at, rule = (
        f"{location.line}:{location.column}" if location else "-" for location in (row.made_at, row.rule_at)
    )
    line = f"{made_at:>10}{rule:>10}   {'  ' * row.depth}{row.symbol}{row.note}"
    below = " " * (23 + 2 * row.depth + 2)
    for position, detail in enumerate(row.details):
        if position and len(f"{line}  {detail}") > LINE_WIDTH:
            yield line
            line = below + detail
        else:
            line += f"  {detail}"
    yield line


def _drawn(site: Site, value: float) -> str:
    if site.kind == "choice":
        return f"{site.name}: branch {int(value) + 1} of {site.choices}"
    if site.kind == "bernoulli":
        return f"{site.name} = {'true' if value else 'false'}"
    return f"{site.name} = {value:.6g}" if site.kind == "uniform" else f"{site.name}: item {int(value) + 1}"


def _draws(trace: DerivationTrace, node: int) -> Iterator[tuple[Site, float, Location]]:
    draws = trace.forest.draws
    for row in trace.draws.get(node, ()):
        site = int(draws.site[row])
        yield trace.forest.sites[site], float(draws.value[row]), trace.numbering.random_places[site].node.location


def _position(location: Location | None) -> dict[str, int] | None:
    return None if location is None else {"line": location.line, "column": location.column}


def _by_node(node: np.ndarray, rows: np.ndarray | None = None) -> dict[int, tuple[int, ...]]:
    """The rows of each node, in their order."""
    rows_of: dict[int, list[int]] = {}
    for key, row in zip(node.tolist(), (np.arange(len(node)) if rows is None else rows).tolist(), strict=True):
        rows_of.setdefault(key, []).append(row)
    return {key: tuple(rows) for key, rows in rows_of.items()}
