"""The map from parts of a new wall to examples, from a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.analysis.example import MOST_LINES
from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.values import a_list, parse_json, read_bounded


def read_regions(path: Path, rows: int, columns: int, examples: int) -> Labels:
    """[rows, columns] index of the example of each cell, from 0.

    The file is a JSON array of rows, the lowest first, each an array of numbers from 1. It is stretched over the wall
    if it has other numbers of rows and columns.

    Raises:
        FacadeError: If it is not such a map.
    """
    try:
        found = [a_list(row, "row", MOST_LINES) for row in a_list(parse_json(read_bounded(path)), "map", MOST_LINES)]
    except FacadeError as error:
        raise FacadeError(f"{path.name}: {error}") from error
    if not found or not found[0] or len({len(row) for row in found}) > 1:
        raise FacadeError(f"{path.name}: expected rows of one length, such as [[1, 1, 2], [1, 1, 2]].")
    for row in found:
        for each in row:
            if isinstance(each, bool) or not isinstance(each, int) or not 1 <= each <= examples:
                raise FacadeError(f"{path.name}: expected examples 1 to {examples}, found {each!r:.40}.")
    given = np.array(found, dtype=np.int64) - 1
    places = [
        (2 * np.arange(new) + 1) * old // (2 * new) for new, old in ((rows, len(found)), (columns, len(found[0])))
    ]
    return given[np.ix_(*places)]
