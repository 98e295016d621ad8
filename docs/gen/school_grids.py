"""Grids on three levels of the shipped school: storeys, the sashes of each storey, the panes of each sash."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from grammarlab.facade.editing.grids import with_grid
from grammarlab.facade.file import load_facade, save_facade
from grammarlab.facade.tree import Facade, X, Y


def with_levels(school: Facade) -> Facade:
    """The school with these grids after its own."""
    panes = np.array([leaf for leaf in school.leaves.tolist() if school.name_of(leaf) == "light"])
    inside = ((panes >= np.arange(len(school))[:, None]) & (panes < school.end[:, None])).sum(axis=1)
    storeys = np.flatnonzero((inside == len(panes) // 3) & (school.axis == X))
    sashes = np.flatnonzero((inside == 2) & (school.axis == Y))
    school = with_grid(school, "storeys", storeys)
    for name, outer, inner in (("sashes", storeys, sashes), ("panes", sashes, panes)):
        for number, node in enumerate(outer.tolist(), start=1):
            school = with_grid(school, f"{name} {number}", inner[(inner > node) & (inner < school.end[node])])
    return school


if __name__ == "__main__":
    file = Path(sys.argv[1])
    save_facade(with_levels(load_facade(file)), file)
