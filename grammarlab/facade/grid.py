"""A grid of a facade: nodes in rows and columns, with empty places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Ints


@dataclass(frozen=True, slots=True)
class Grid:
    """E nodes of a facade that do not overlap, each in a row and a column (paper 000, section 3).

    A place without a node is a phantom: it keeps its row and column aligned, but has no geometry. A node that spans
    several rows, as a door does, has one of them; the other places are phantoms.
    """

    name: str
    """Name for the user; unique in a facade."""
    node: Ints
    """[E] node of the facade, ascending."""
    row: Ints
    """[E] row from 0 at the top."""
    column: Ints
    """[E] column from 0 at the left."""

    @property
    def num_rows(self) -> int:
        """R: number of rows, with and without phantoms."""
        return int(self.row.max(initial=-1)) + 1

    @property
    def num_columns(self) -> int:
        """C: number of columns, with and without phantoms."""
        return int(self.column.max(initial=-1)) + 1

    def places(self) -> Ints:
        """[R, C] the node in each place, -1 for phantoms."""
        nodes = np.full((self.num_rows, self.num_columns), -1, dtype=np.int64)
        nodes[self.row, self.column] = self.node
        return nodes
