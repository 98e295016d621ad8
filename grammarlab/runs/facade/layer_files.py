"""From a design of layers to files of its layouts."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grammarlab.export.save import Format, save_together
from grammarlab.facade.grammar.exact_grammar import write_exact
from grammarlab.facade.tree import Facade
from grammarlab.files import write_text
from grammarlab.layers.design import Design, word_text
from grammarlab.layers.layer_family import FamilyVariant, WrittenVariants, write_variants
from grammarlab.layers.layouts import layouts
from grammarlab.layers.panels import Panels, flattened, panels_of, relief
from grammarlab.layers.solving import Layout
from grammarlab.runs.facade.gallery import GALLERY, draw_gallery, write_gallery
from grammarlab.runs.work.run_folder import only_run_in, replace_written

FAMILY = "family.cga"
"""File of a grammar of all layouts."""
_MODELS: tuple[Format, ...] = ("glb", "obj")
_AXES = "xy"
_MIN_PROBABILITY = 0.01
"""Least probability of a layout, relative to that of the best one of its canvas."""


@dataclass(frozen=True, eq=False)
class SolvedLayout:
    """A layout of a design, and its panels."""

    design: Design
    layout: Layout
    panels: Panels
    facade: Facade
    seconds: float
    """Duration of solving for all layouts of one call."""

    def as_dict(self) -> dict[str, Any]:
        """Values for `--json`."""
        layout, design = self.layout, self.design
        keys = {group: _AXES[group[0]] + (f":{group[1]}" if group[1] else "") for group in layout.groups}
        return {
            "counters": dict(layout.candidate.counters),
            "words": self._words(),
            "columns": {keys[group]: alignment.columns() for group, alignment in layout.alignments.items()},
            "omega": sum(alignment.omega for alignment in layout.alignments.values()),
            "span": {keys[group]: alignment.span for group, alignment in layout.alignments.items()},
            "sizes": dict(layout.sizing.sizes),
            "sizing_error": layout.sizing.error,
            "sizing_residual": layout.sizing.residual,
            "ends": {
                keys[group]: placed.ends.tolist()
                for group, placed in zip(layout.groups, layout.sizing.placed, strict=True)
            },
            "energy": layout.energy,
            "bound": layout.bound,
            "proven": layout.proven,
            "tolerance": layout.tolerance,
            "width": float(self.panels.lines[0][-1]),
            "height": float(self.panels.lines[1][-1]),
            "leaves": len(self.facade.leaves),
            "weights": {
                "omega": design.weights.omega,
                "merge": design.weights.merge,
                "sizing": design.weights.sizing,
            },
            "seconds": self.seconds,
        }

    def _words(self) -> list[dict[str, Any]]:
        """For each layer, its words as patterns without operations."""
        rows: dict[tuple[int, str], int] = {}
        layer_words = []
        for layer in self.design.visible_layers:
            words: dict[str, Any] = {"layer": layer.name}
            for axis, name in enumerate(_AXES):
                group = (axis, layer.groups[axis])
                rows[group] = rows.get(group, -1) + 1
                words[name] = word_text(self.layout.alignments[group].words[rows[group]])
            layer_words.append(words)
        return layer_words


def solve_design(
    design: Design, width: float | None = None, height: float | None = None, count: int = 1
) -> list[SolvedLayout]:
    """The best different layouts of a design, best first, with their panels.

    Args:
        design: the design.
        width: metres; that of the design's canvas when left out.
        height: metres; that of the design's canvas when left out.
        count: largest number of layouts.

    Raises:
        FacadeError: If there are none.
    """
    width, height = width or design.width, height or design.height
    start = time.perf_counter()
    candidates = layouts(design, width, height, count)
    seconds = time.perf_counter() - start
    solved = []
    for layout in candidates:
        panels = panels_of(design, layout, width, height)
        solved.append(SolvedLayout(design, layout, panels, flattened(panels), seconds))
    return solved


def save_layouts(
    solved: Sequence[SolvedLayout], folder: Path, source: Path | None = None, family: str = ""
) -> list[dict[str, str]]:
    """Write each layout as a facade, a drawing, a picture, models and rules, and all of them as one picture.

    Other files of the earlier run are removed unless they were changed: a folder shows one run.

    Args:
        solved: the layouts.
        folder: where to write; created if missing.
        source: a file that is neither overwritten nor removed.
        family: text of a grammar of all layouts, for ``family.cga``; none if empty.

    Returns:
        The files of each: `facade`, `drawing`, `picture`, `glb`, `obj`, `rules`.

    Raises:
        UsageError: If the source would be overwritten, or another run is writing into the folder.
        FacadeError: If a layout cannot be drawn.
    """
    rules = [write_exact(solution.facade).text for solution in solved]
    gallery = draw_gallery([solution.facade for solution in solved], folder, source)
    with only_run_in(folder):
        files, written = write_gallery(gallery, folder)
        layout_files = _write_models(solved, files, rules, written)
        if family:
            write_text(folder / FAMILY, family)
            written.append(folder / FAMILY)
        replace_written(folder, GALLERY, written, [source] if source else ())
    return layout_files


def _write_models(
    solved: Sequence[SolvedLayout], files: Sequence[Path], rules: Sequence[str], written: list[Path]
) -> list[dict[str, str]]:
    """Write the models and rules of layouts beside their facades; adds the files to `written`.

    Returns:
        The files of each layout.
    """
    layout_files = []
    for file, solution, text in zip(files, solved, rules, strict=True):
        folder, name = file.parent, file.name.removesuffix(".facade.json")
        scene = relief(solution.design, solution.panels)
        paths = {"facade": file, "drawing": folder / f"{name}.svg", "picture": folder / f"{name}.png"}
        for ending in _MODELS:
            paths[ending] = folder / f"{name}.{ending}"
            save_together([scene], paths[ending], ending, on_file=written.append)
        paths["rules"] = folder / f"{name}.cga"
        write_text(paths["rules"], text)
        written.append(paths["rules"])
        layout_files.append({key: str(path) for key, path in paths.items()})
    return layout_files


def family_of(design: Design, widths: Sequence[float], heights: Sequence[float], count: int = 1) -> WrittenVariants:
    """A stochastic grammar of the best layouts on some canvases; for one canvas, less energy has more probability.

    Args:
        design: the design.
        widths: widths of canvases, metres.
        heights: heights of canvases, metres; each is combined with each width.
        count: largest number of layouts per canvas.

    Raises:
        FacadeError: If no layout fits a canvas.
    """
    variants = []
    for width in widths:
        for height in heights:
            solved = solve_design(design, width, height, count)
            least = solved[0].layout.energy
            variants += [
                FamilyVariant(
                    (width, height), solution.facade, max(math.exp(least - solution.layout.energy), _MIN_PROBABILITY)
                )
                for solution in solved
            ]
    sizes = f"{min(widths):g} to {max(widths):g} m wide and {min(heights):g} to {max(heights):g} m high"
    return write_variants(variants, f"{design.title or 'A layered facade'}: {len(variants)} layouts, {sizes}")
