"""Leaves of a family as rules: boxes or meshes, with the picture that they show in the facade."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from grammarlab.facade.tree import Facade
from grammarlab.facade.writing.outlines import OutlinedLeaf, outlined_leaf
from grammarlab.facade.writing.pictures import picture_file, window_projection
from grammarlab.facade.writing.rule_text import leaf_body
from grammarlab.facade.writing.structure.cells import Cell, PictureWindow

Outline = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class FacadeLeaves:
    """What makes the things of a facade. Each leaf lays its own window of the picture on its box."""

    facade: Facade
    meshes: dict[Outline, OutlinedLeaf | None] = field(default_factory=dict)
    """Of each outline that was written; None for one that is written as its box."""

    def body(self, cell: Cell) -> str:
        """The operations that make a thing, which has no parts."""
        setup = self._projection(cell.shows) if cell.shows else ""
        if cell.outline not in self.meshes:
            self.meshes[cell.outline] = outlined_leaf(np.array(cell.outline)) if cell.outline else None
        mesh, pictured = self.meshes[cell.outline], bool(setup)
        body = mesh.body(cell.label, pictured=pictured) if mesh else leaf_body(cell.label, pictured=pictured)
        return f"{setup} {body}".lstrip()

    @property
    def outlined(self) -> tuple[OutlinedLeaf, ...]:
        """Those whose meshes the rules refer to."""
        return tuple(mesh for mesh in self.meshes.values() if mesh)

    def _projection(self, shows: PictureWindow) -> str:
        low, high = np.array(shows.low), np.array(shows.high)
        return window_projection(picture_file(self.facade, shows.picture), low, high - low)
