"""From a facade to a design of layers, with the similarity of its layout and the facade."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import Facade
from grammarlab.files import write_text
from grammarlab.layers.design import Design, design_text
from grammarlab.layers.infer import Reconstruction, compare, infer
from grammarlab.runs.facade.layer_files import SolvedLayout, solve_design

TOLERANCES = (1e-6, 1 / 1000, 1 / 300, 1 / 100, 1 / 50, 1 / 30)
"""Tolerances to try, as fractions of the longer side of a facade."""
_COST_OF_MISPLACED = 40
"""Cost of a misplaced element, in letters: four numbers of ten digits."""


@dataclass(frozen=True)
class Inferred:
    """A design, and the similarity of its layout on the canvas of the facade and the facade."""

    design: Design
    tolerance: float
    """Largest difference of sides in line and of equal sizes, metres."""
    solved: SolvedLayout
    score: Reconstruction
    seconds: float

    @property
    def length(self) -> int:
        """Number of letters of all patterns, symbols and layers."""
        letters = sum(map(_letters, (pattern.text for pattern in self.design.patterns.values())))
        return letters + len(self.design.symbols) + 2 * len(self.design.layers)

    @property
    def cost(self) -> float:
        """Description length of the facade, in letters: that of the design plus that of misplaced elements."""
        num_misplaced = max(self.score.elements, self.score.other_elements) * (1.0 - self.score.quality)
        return self.length + _COST_OF_MISPLACED * num_misplaced


def infer_design(facade: Facade, tolerance: float | None = None, title: str = "") -> Inferred:
    """The design with the shortest description of a facade, including elements that it misplaces.

    Args:
        facade: the facade.
        tolerance: largest difference of sides in line and of equal sizes, metres; the best of `TOLERANCES` when left
            out.
        title: title of the design.

    Raises:
        FacadeError: If it is too large, or no design of it can be solved.
    """
    longest = max(facade.width, facade.height)
    tolerances = [part * longest for part in TOLERANCES] if tolerance is None else [max(tolerance, 1e-9 * longest)]
    best: Inferred | None = None
    refused: FacadeError | None = None
    start = time.perf_counter()
    for candidate in tolerances:
        design = infer(facade, candidate, title)
        try:
            solved = solve_design(design)[0]
        except FacadeError as error:
            refused = error
            continue
        inferred = Inferred(design, candidate, solved, compare(facade, solved.facade), time.perf_counter() - start)
        if best is None or inferred.cost < best.cost:
            best = inferred
    if best is None:
        raise FacadeError(f"no design of this facade can be laid out: {refused}") from refused
    return best


def save_inferred(inferred: Inferred, path: Path) -> Path:
    """Write a design, with its score as a comment."""
    score = inferred.score
    head = (
        f"# Inferred: {score.area:.2%} of the area has the right label, "
        f"{score.other_elements} elements for {score.elements},\n"
        f"# which overlap those by {score.iou:.2%} on average; sides within {inferred.tolerance:.3g} m are in line.\n"
    )
    write_text(path, head + design_text(inferred.design))
    return path


def _letters(text: str) -> int:
    """Number of symbols and loops of a pattern."""
    return sum(letter.isalpha() for letter in text)
