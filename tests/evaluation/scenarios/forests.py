"""Derivation trees written by hand."""

from __future__ import annotations

import re

import numpy as np

from grammarlab.derivation.forest import Draws, Forest, Leaves, Nodes, Reports, RuleName, Site
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.geometry.meshes.mesh import Meshes

_TOKEN = re.compile(
    r"\s*(?:(?P<open>\()|(?P<close>\))|(?P<symbol>\w+)(?::(?P<branch>\d+))?|\$(?P<draw>\w+)=(?P<value>[\d.]+))"
)


def forest_of(*trees: str) -> Forest:
    """A forest of one model a text.

    ``Tower:1(Block:0 Block:2(Glass))`` is a Tower rewritten by branch 1 with two children; ``$height=3`` before the
    root is a draw. Nodes without a branch are leaves unless they have children; siblings are successors 0, 1, 2, ...
    """
    symbols: dict[str, int] = {}
    rules: dict[tuple[str, int | None], int] = {}
    sites: dict[str, int] = {}
    nodes: list[tuple[int, int, int, int, int]] = []
    draws: list[tuple[int, int, float]] = []
    for model, text in enumerate(trees):
        parents, root = [-1], len(nodes)
        children = {-1: 0}
        place = 0
        while place < len(text):
            match = _TOKEN.match(text, place)
            assert match, text[place:]
            place = match.end()
            if match["open"]:
                parents.append(len(nodes) - 1)
            elif match["close"]:
                parents.pop()
            elif match["draw"]:
                draws.append((root, sites.setdefault(match["draw"], len(sites)), float(match["value"])))
            else:
                inner = text[place : place + 1] == "("
                branch = int(match["branch"]) if match["branch"] else None
                ruled = branch is not None or inner
                rule = rules.setdefault((match["symbol"], branch), len(rules)) if ruled else -1
                symbol = symbols.setdefault(match["symbol"], len(symbols))
                child = children.get(parents[-1], 0)
                children[parents[-1]] = child + 1
                nodes.append((model, parents[-1], symbol, rule, child))
        assert parents == [-1], text
    return _forest(len(trees), tuple(symbols), tuple(rules), tuple(sites), nodes, draws)


def _forest(num_models, symbols, rules, sites, nodes, draws) -> Forest:
    table = np.array(nodes).reshape(-1, 5)
    drawn = np.array(draws, dtype=float).reshape(-1, 3)
    none = np.zeros(0, np.int32)
    return Forest(
        Lots.of(num_models, seed=0),
        symbols,
        tuple(RuleName(symbol, 0, () if branch is None else (branch,), 1) for symbol, branch in rules),
        tuple(Site(name, "uniform", name, 1, 0) for name in sites),
        Nodes(
            table[:, 0].astype(np.int32),
            table[:, 1].astype(np.int32),
            table[:, 2].astype(np.int16),
            table[:, 3].astype(np.int16),
            table[:, 4].astype(np.int16),
            np.zeros(len(table), np.int32),
        ),
        Leaves(none, np.zeros((0, 3)), np.zeros((0, 3)), none, none, none, none),
        Draws(drawn[:, 0].astype(np.int32), drawn[:, 1].astype(np.int16), drawn[:, 2].copy(), np.zeros(len(drawn))),
        Reports(none, none, np.zeros(0), ()),
        np.eye(3)[None],
        Meshes.from_polygons(np.zeros((0, 3)), np.zeros(0, np.int64)),
        Materials(np.zeros((0, len(CHANNELS))), ()),
        np.zeros((0, 2, 4)),
    )
