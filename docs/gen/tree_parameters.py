"""Pictures of every parameter of trees at three or more values, and the sections of `docs/trees/parameters.md`.

    .venv/bin/python -m docs.gen.tree_parameters [NAME ...]

All trees of a strip have one key; only the parameter differs. `make tree-parameters` draws all strips.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from PIL import Image

from grammarlab.arrays import Floats
from grammarlab.randomness import root_keys
from grammarlab.rendering.camera import View, frame_alike, seen_aspect
from grammarlab.rendering.choice import RendererChoice
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.runs.sample.contact_sheet import draw_page, lay_out, seen_points
from grammarlab.scene import TriangleBatch, triangles
from grammarlab.trees.growth import grow
from grammarlab.trees.measures import MEASURES
from grammarlab.trees.parameters import COLUMN, COLUMNS, DEFAULTS, PARAMETERS, SPREAD, Parameter
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.species import Look

FOLDER = Path(__file__).parents[1] / "images" / "trees"
PANEL_AREA = 220 * 200
"""Pixels of each picture of a strip."""
_MIN_ASPECT, _MAX_ASPECT = 0.6, 1.5
_JPEG_QUALITY = 72
_MODEL = 3
"""Number of the tree whose draws are used."""
_LOOK = Look()
_RENDERER = RendererChoice("cast").make()

Values = Mapping[str, float]
SIDE = View(azimuth=20.0, elevation=6.0, margin=0.04)
FLAT = View(azimuth=110.0, elevation=6.0, margin=0.04)
"""For trees in one plane."""
TWIG = View(azimuth=110.0, elevation=40.0, margin=0.04)
"""For blades, which mostly face the sky."""
ABOVE = View(azimuth=20.0, elevation=40.0, margin=0.04)
"""For lobes, and for turns about the trunk."""


@dataclass(frozen=True, slots=True)
class Strip:
    """One tree at several values of a column."""

    values: tuple[float, ...]
    """V values, at least 3."""
    tree: Values
    """Values of other columns; those left out have their defaults."""
    view: View = field(default=SIDE)

    def rows(self, column: str) -> Floats:
        """[V, P] parameters of the trees."""
        rows = np.tile(DEFAULTS, (len(self.values), 1))
        for name, value in self.tree.items():
            rows[:, COLUMN[name]] = value
        rows[:, COLUMN[column]] = self.values
        return rows


_TRUNK: Values = {"levels": 1, "scale": 8, "ratio": 0.06, "curve_res_0": 12, "flare": 0, "base_size": 0.1}
_BARE: Values = {
    "levels": 2, "scale": 10, "ratio": 0.03, "ratio_power": 1.0, "base_size": 0.25, "flare": 0.3, "curve_res_0": 10,
    "branches_1": 18, "length_1": 0.35, "down_angle_1": 65, "rotate_1": 140, "curve_res_1": 8,
}  # fmt: skip
"""A trunk with branches."""
_STOUT: Values = {**_BARE, "branches_1": 7, "length_1": 0.5, "ratio": 0.05, "ratio_power": 0.6, "shape": 3}
"""A trunk with a few thick branches."""
_FORKED: Values = {
    **_BARE, "levels": 3, "branches_1": 9, "length_1": 0.5, "branches_2": 14, "length_2": 0.4, "down_angle_2": 55,
    "curve_res_2": 6,
}  # fmt: skip
"""A tree whose branches have branches."""
_FLAT: Values = {
    **_STOUT, "levels": 3, "branches_1": 5, "rotate_1": 180, "down_angle_1": 60, "branches_2": 8, "length_2": 0.45,
    "down_angle_2": 50, "rotate_2": 180, "curve_res_2": 8,
}  # fmt: skip
"""A tree in one plane, as in a herbarium, on which branches of branches are seen."""
_PRESSED: Values = {
    **_FLAT, "levels": 4, "ratio": 0.03, "branches_1": 3, "length_1": 0.75, "branches_2": 4, "length_2": 0.65,
    "branches_3": 7, "length_3": 0.45, "down_angle_3": 50, "rotate_3": 180, "curve_res_3": 8,
}  # fmt: skip
"""The same, for twigs."""
_LEAFY: Values = {
    **_FORKED, "branches_1": 24, "length_1": 0.4, "branches_2": 16, "leaves": 12, "leaf_scale": 0.28,
}  # fmt: skip
_TWIG: Values = {
    "levels": 2, "scale": 0.6, "ratio": 0.012, "base_size": 0.1, "flare": 0, "shape": 3, "branches_1": 3,
    "length_1": 0.7, "down_angle_1": 60, "rotate_1": 180, "curve_res_1": 5, "leaves": 9, "leaf_scale": 0.12,
    "leaf_scale_x": 0.6, "down_angle_2": 50, "rotate_2": -90,
}  # fmt: skip
"""A twig, on which single leaves are seen."""
_PRUNED: Values = {**_FORKED, "branches_1": 30, "length_1": 0.6, "prune_ratio": 1, "prune_width": 0.3, "shape": 3}
_CLIPPED: Values = {**_PRUNED, "branches_1": 50, "prune_power_low": 1, "prune_power_high": 1}
"""A tree that fills its envelope."""
_LEVEL_TREES = (_TRUNK, _BARE, _FLAT, _PRESSED)

_TREE_STRIPS: Mapping[str, Strip] = {
    "shape": Strip(tuple(range(9)), {**_BARE, "branches_1": 50}),
    "base_size": Strip((0.05, 0.3, 0.6), _BARE),
    "scale": Strip((5, 8, 12), _BARE),
    "scale_v": Strip((0, 3, 6), _BARE),
    "z_scale": Strip((0.6, 1, 1.6), _BARE),
    "levels": Strip((2, 3, 4), _PRESSED, FLAT),
    "ratio": Strip((0.01, 0.03, 0.08), _BARE),
    "ratio_power": Strip((0.3, 1, 2.5), {**_BARE, "ratio": 0.05}),
    "lobes": Strip((0, 3, 8), {**_TRUNK, "scale": 1.5, "ratio": 0.2, "lobe_depth": 0.25, "taper_0": 0}, ABOVE),
    "lobe_depth": Strip((0, 0.15, 0.4), {**_TRUNK, "scale": 1.5, "ratio": 0.2, "lobes": 6, "taper_0": 0}, ABOVE),
    "flare": Strip((0, 0.6, 2), {**_TRUNK, "scale": 3, "ratio": 0.08, "taper_0": 0.7}),
    "attraction_up": Strip((-8, 0, 8), _FORKED),
    "prune_ratio": Strip((0, 0.5, 1), _PRUNED),
    "prune_width": Strip((0.1, 0.25, 0.4), _PRUNED),
    "prune_width_peak": Strip((0.1, 0.5, 0.9), _CLIPPED),
    "prune_power_low": Strip((0.2, 1, 4), {**_CLIPPED, "prune_width_peak": 0.8}),
    "prune_power_high": Strip((0.2, 1, 4), {**_CLIPPED, "prune_width_peak": 0.2}),
    "wind_speed": Strip((0, 15, 40), {**_FORKED, "ratio": 0.012}),
    "wind_direction": Strip((0, 90, 180), {**_FORKED, "ratio": 0.012, "wind_speed": 40}),
}  # fmt: skip

_LEAF_STRIPS: Mapping[str, Strip] = {
    "leaves": Strip((2, 8, -8), {**_TWIG, "rotate_2": 140, "down_angle_2": 30, "leaf_bend": 0}, TWIG),
    "leaf_shape": Strip(tuple(range(10)), {**_TWIG, "leaves": 5, "leaf_scale": 0.25}, TWIG),
    "leaf_scale": Strip((0.05, 0.1, 0.2), _TWIG, TWIG),
    "leaf_scale_x": Strip((0.2, 0.6, 1.2), _TWIG, TWIG),
    "leaf_bend": Strip((0, 0.5, 1), _TWIG, TWIG),
    "leaf_stem_len": Strip((-1, 0.5, 2), _TWIG, TWIG),
    "leaf_quality": Strip((0.05, 0.3, 1), _LEAFY),
    "blossom_rate": Strip((0, 0.3, 1), {**_TWIG, "blossom_scale": 0.05}, TWIG),
    "blossom_shape": Strip((1, 2, 3), {**_TWIG, "blossom_rate": 1, "blossom_scale": 0.07}, TWIG),
    "blossom_scale": Strip((0.02, 0.05, 0.1), {**_TWIG, "blossom_rate": 1}, TWIG),
}

_HEADINGS = {
    "shape": "The whole tree",
    "scale_0": "The trunk",
    "down_angle_1": "Branches, level 1",
    "down_angle_2": "Branches of branches, level 2",
    "down_angle_3": "Twigs, level 3",
    "leaves": "Leaves and blossoms",
}
"""Headings by the first parameter below them."""


def _level_strips(level: int) -> Mapping[str, Strip]:
    """Strips of the parameters of a level."""
    tree, view = _LEVEL_TREES[level], SIDE if level < 2 else FLAT
    thick = _STOUT if level == 1 else tree
    forks: dict[str, float] = {**thick, f"seg_splits_{level}": 0.3, f"split_angle_{level}": 35, f"curve_res_{level}": 6}
    if level == 1:  # splits of steep branches are seen best: the angle is measured from the vertical
        forks |= {"down_angle_1": 25, "branches_1": 4, "ratio": 0.03}
    curved = {**tree, f"curve_{level}": 60}
    values: dict[str, tuple[tuple[float, ...], Values]] = {
        "length": ((0.6, 0.8, 1) if level == 0 else (0.15, 0.3, 0.6), tree),
        "length_v": ((0, 0.15, 0.3), tree),
        "taper": ((0, 1, 2, 3), thick),
        "seg_splits": ((0, 0.2, 0.6), forks),
        "split_angle": ((20, 45, 80), forks),
        "split_angle_v": ((0, 30, 60), forks),
        "curve_res": ((2, 4, 16), {**tree, f"curve_{level}": 110}),
        "curve": ((-60, 0, 120), tree),
        "curve_v": ((-50, 0, 300), tree),
        "curve_back": ((-90, 0, 90), curved),
    }
    if level == 0:
        values |= {"scale": ((0.5, 1, 2), _BARE), "base_splits": ((0, 1, 4), {**_BARE, "split_angle_0": 35})}
    else:
        values |= {
            "down_angle": ((25, 65, 115), tree),
            "down_angle_v": ((-40, 0, 40), tree),
            "branches": ((4, 12, 40), tree),
        }
    strips = {_column(name, level): Strip(numbers, base, view) for name, (numbers, base) in values.items()}
    if level > 0:
        about = ABOVE if level == 1 else FLAT
        strips[f"rotate_{level}"] = Strip((15, 140, -90), tree, about)
        strips[f"rotate_{level}_v"] = Strip((0, 30, 180), {**tree, f"rotate_{level}": 90}, about)
    return strips


def _column(name: str, level: int) -> str:
    """The column of a parameter of a level: ``curve_1_v`` of ``curve_v``."""
    if name == "base_splits":
        return name
    return f"{name.removesuffix(SPREAD)}_{level}{SPREAD if name.endswith(SPREAD) else ''}"


def _strips() -> Mapping[str, Strip]:
    strips = {**_TREE_STRIPS, **_LEAF_STRIPS}
    for level in range(len(_LEVEL_TREES)):
        strips |= _level_strips(level)
    # Spreads of deeper levels look as those of level 1.
    shown = [column for column in COLUMNS if column in PARAMETERS or not column.endswith(("_2_v", "_3_v"))]
    return {column: strips[column] for column in shown if column in strips}


STRIPS = _strips()
"""The strip of each parameter and of the spreads with a visible effect, in the order of the table."""


def models(column: str) -> list[TriangleBatch]:
    """The trees of a strip."""
    rows = STRIPS[column].rows(column)
    scene = realize_trees(grow(rows, root_keys(0, np.full(len(rows), _MODEL))), _LOOK, "full")
    batch = triangles(scene)
    return [batch.model(index) for index in range(len(rows))]


def picture(column: str) -> Image.Image:
    """The strip of a column, with its values below."""
    strip, parts = STRIPS[column], models(column)
    points = [seen_points(part) for part in parts]
    aspect = float(np.clip(max(seen_aspect(each, strip.view) for each in points), _MIN_ASPECT, _MAX_ASPECT))
    width, height = round((PANEL_AREA * aspect) ** 0.5), round((PANEL_AREA / aspect) ** 0.5)
    options = RenderOptions(width=width, height=height, samples=3, view=strip.view)
    cameras = frame_alike(points, width / height, strip.view)
    pictures = [_RENDERER.render(part, camera, options) for part, camera in zip(parts, cameras, strict=True)]
    captions = [(text, "") for text in values_in_words(column)]
    return Image.fromarray(
        draw_page(
            lay_out(len(parts), {10: 5, 4: 4}.get(len(parts), 3), width, height),
            pictures,
            captions,
            (column, paper_name(column)),
        )
    )


def parameter_of(column: str) -> Parameter:
    """The parameter of a column, which may be its spread."""
    return PARAMETERS[column.removesuffix(SPREAD)]


def paper_name(column: str) -> str:
    """The paper's name: ``1CurveV`` of ``curve_1_v``."""
    words = column.split("_")
    level = "".join(word for word in words if word.isdigit()) or ("0" if column == "base_splits" else "")
    return level + "".join(word.capitalize() for word in words if not word.isdigit())


def values_in_words(column: str) -> list[str]:
    """The values of a strip, with their unit."""
    unit = parameter_of(column).unit
    return [f"{value:g}{'°' if unit == 'deg' else f' {unit}' if unit else ''}" for value in STRIPS[column].values]


def sections() -> str:
    """The sections of the page: one for each parameter, below the part of the tree that it belongs to."""
    parts = []
    for name, parameter in PARAMETERS.items():
        if name in _HEADINGS:
            parts.append(f"## {_HEADINGS[name]}")
        parts.append(_section(name, parameter))
    return "\n\n".join(parts)


def measures() -> str:
    """A table of what is measured of trees."""
    rows = [f"| `{each.name}` | {each.unit.replace('m2', 'm²')} | {each.why} |" for each in MEASURES.values()]
    return "\n".join(["| measure | unit | is |", "|---|---|---|", *rows])


def _section(name: str, parameter: Parameter) -> str:
    unit = {"": "", "m": ", metres", "deg": ", degrees", "m/s": ", metres per second"}[parameter.unit]
    count = "a whole number, " if parameter.integer else ""
    limits = f"{count}{parameter.low:g} to {parameter.high:g}{unit}; {parameter.default:g} if a file does not name it"
    lines = [f"### `{name}`", f"{parameter.why[0].upper()}{parameter.why[1:]}. *{paper_name(name)}*: {limits}."]
    lines += [_image(name)]
    if parameter.spread is not None:
        column = f"{name}{SPREAD}"
        low = -parameter.spread if parameter.signed else 0.0
        lines.append(f"Its spread `{column}`, *{paper_name(column)}*: {low:g} to {parameter.spread:g}{unit}.")
        lines += [_image(column)] if column in STRIPS else []
    return "\n\n".join(lines)


def _image(column: str) -> str:
    *others, last = values_in_words(column)
    return f"![The same tree with {column} = {', '.join(others)} and {last}](../images/trees/{column}.jpg)"


def main(names: list[str]) -> None:
    """Draw the strips of these columns; all of them without a name."""
    if unknown := set(names) - set(STRIPS):
        raise SystemExit(f"unknown strip {min(unknown)!r}: expected one of {', '.join(STRIPS)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in names or STRIPS:
        picture(name).save(FOLDER / f"{name}.jpg", quality=_JPEG_QUALITY, optimize=True)


if __name__ == "__main__":
    main(sys.argv[1:])
