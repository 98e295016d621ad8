"""State of a matching session: elements, match and corrections."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.errors import FacadeError, UsageError
from grammarlab.matching.corrections import Corrections, as_dict, check_corrections, load_corrections, save_corrections
from grammarlab.matching.elements import Elements
from grammarlab.matching.match import Match, doubt, drawn_parameters, sentences
from grammarlab.matching.match_grammar import color_of
from grammarlab.matching.template import Template, points_along
from grammarlab.pages.desk import AbstractDocumentDesk
from grammarlab.pages.windows import PROTOCOL
from grammarlab.runs.facade.match_files import match_elements

MOST_SHOWN = 1_000
"""Largest number of elements on the page."""
_POINTS = 120
"""Largest number of points drawn per element."""
_GREY = "#888888"


class ScanDesk(AbstractDocumentDesk[Corrections]):
    """Elements, their match, and corrections, each of which is saved at once."""

    def __init__(
        self, title: str, elements: Elements, templates: tuple[Template, ...], target: Path, seed: int = 0
    ) -> None:
        """Opens elements; corrections in the target are loaded.

        Raises:
            FacadeError: If there are too many elements, or corrections of other elements.
            UsageError: If the target is not JSON.
        """
        if len(elements) > MOST_SHOWN:
            raise FacadeError(
                f"{title}: {len(elements):,} elements; expected at most {MOST_SHOWN:,} on the page. "
                "grammarlab facade match supports more."
            )
        if target.suffix.lower() != ".json":
            raise UsageError(f"--output: expected the suffix .json, found {target.name!r}.")
        corrections = load_corrections(target) if target.exists() else ()
        check_corrections(corrections, len(elements), templates)
        super().__init__(target, corrections, saved=corrections)
        self.title, self.elements, self.templates, self._seed = title, elements, templates, seed
        self.match: Match | None = None
        self.is_stale = True
        """Whether the match is from earlier corrections."""

    def accept(self, document: Corrections) -> None:
        """Save corrections before they become the current ones.

        Raises:
            FacadeError: If corrections have unknown elements, or contradict each other.
        """
        check_corrections(document, len(self.elements), self.templates)
        self.write(self.target, document, is_new=False)
        self.saved = document

    def follow(self, previous: Corrections) -> None:
        """Let the elements be matched again."""
        self.is_stale = True

    def write(self, path: Path, document: Corrections, *, is_new: bool) -> None:
        """Write corrections."""
        save_corrections(document, path)

    def rematch(self) -> None:
        """Matches again with all corrections."""
        self.is_stale = False
        self.match = match_elements(self.elements, self.templates, "default", self._seed, self.document)
        self.notify()

    def state(self) -> dict[str, Any]:
        """The whole state of the page."""
        low, high = self.elements.low.min(axis=0), self.elements.high.max(axis=0)
        return {
            "protocol": PROTOCOL,
            **self.summary(),
            "title": self.title,
            "busy": self.is_stale,
            "undo": bool(self.history.past),
            "bounds": [*low.tolist(), *high.tolist()],
            "templates": sorted({template.base for template in self.templates}),
            "elements": [self._element(element) for element in range(len(self.elements))],
            "corrections": [as_dict(correction) for correction in self.document],
            "words": sentences(self.match) if self.match else [],
        }

    def _element(self, element: int) -> dict[str, Any]:
        points = self.elements.points_of(element)[:, :2]
        sampled = points[np.linspace(0, len(points) - 1, min(len(points), _POINTS)).astype(np.int64)]
        values: dict[str, Any] = {
            "box": [*self.elements.low[element].tolist(), *self.elements.high[element].tolist()],
            "points": sampled.round(3).tolist(),
            "kind": "",
            "color": _GREY,
            "lines": [],
            "sizes": {},
            "uncertain": "",
        }
        match = self.match
        if match is None:
            return values
        values |= {"kind": match.name_of(int(match.kind[element])), "uncertain": doubt(match, element)}
        fit = drawn_parameters(match, element)
        if fit is None:
            return values
        template, parameters = fit
        red, green, blue = color_of(int(match.kind[element]))
        lines = points_along(template, parameters) + match.corner[element]
        return values | {
            "color": f"#{red:02x}{green:02x}{blue:02x}",
            "lines": lines.reshape(-1, 4).round(3).tolist(),
            "sizes": dict(zip(template.parameters, parameters.round(3).tolist(), strict=True)),
        }
