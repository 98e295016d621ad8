"""Synthetic scenes with truth: rectangles and arches of a few kinds that share widths and heights, seen badly.

In the manner of Figures 5.2, 5.7, 5.8 and 5.12 of paper 001: points on outlines with noise, parts hidden behind
half-planes, outliers; rows of a facade that agree, and trees that hide neighbours together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import offsets_from_counts
from grammarlab.errors import UsageError
from grammarlab.facade.templates.elements import MOST_ELEMENTS, MOST_POINTS, Elements, Floats, Ints, Truth

_GAP = 0.6
"""Metres between boxes."""
_MARGIN = 0.25
"""Metres of a box around its element."""
_OUTLIERS = 0.05
_APART = 0.05
"""Metres between sizes at least, twice as much at most: windows of real facades differ by 5 cm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneOptions:
    """What a scene is like."""

    elements: int = 32
    kinds: int = 5
    noise: float = 0.02
    """Metres, standard deviation of each coordinate."""
    occluded: float = 0.3
    """Part of the elements that are partly hidden."""
    hidden: tuple[float, float] = (0.1, 0.6)
    """Least and greatest part of the points that each of these hides."""
    points: int = 64
    """Points of an element of which nothing is hidden."""
    rows: int = 0
    """Of a facade; 0 for single elements, which have neither rows nor columns."""
    agreement: float = 0.85
    """Part of the elements of a row that are of the kind of their row."""
    tree: bool = False
    """Whether what is hidden lies behind one tree, so that neighbours are hidden together."""


@dataclass(frozen=True, slots=True)
class _Shape:
    """A kind that a scene is made of."""

    template: str
    parameters: dict[str, float]
    outline: Floats
    """[S, 2, 2] segments, from the lower left corner."""


def rectangles(options: SceneOptions, seed: int) -> Elements:
    """A scene of rectangles; of five kinds, each shares its width or height with another one (Figure 5.2).

    Raises:
        UsageError: for numbers that no scene has.
    """
    if not (1 <= options.kinds <= options.elements) or options.noise < 0.0 or options.points < 1:
        raise UsageError("a scene has at least one element, kind and point, not more kinds than elements, noise >= 0.")
    if options.elements > MOST_ELEMENTS or options.elements * options.points > MOST_POINTS:
        raise UsageError(f"a scene has at most {MOST_ELEMENTS:,} elements with {MOST_POINTS:,} points together.")
    random = np.random.default_rng(seed)
    sizes = _shared_sizes(options.kinds, random)
    if options.rows:
        of_row = random.integers(options.kinds, size=options.rows)
        columns = -(-options.elements // options.rows)
        row, column = (each[: options.elements] for each in np.divmod(np.arange(options.rows * columns), columns))
        agrees = random.uniform(size=options.elements) < options.agreement
        kind = np.where(agrees, of_row[row], random.integers(options.kinds, size=options.elements))
    else:
        row = column = np.full(options.elements, -1, dtype=np.int64)
        kind = random.permutation(np.arange(options.elements) % options.kinds)
    return _observed(_rectangles(sizes), kind, row, column, options, random)


def of_sizes(sizes: Floats, kind: Ints, options: SceneOptions, seed: int) -> Elements:
    """A scene of rectangles of given widths and heights.

    Args:
        sizes: [K, 2] metres.
        kind: [N] row of `sizes` of each element.
        options: noise, points, and what is hidden; counts and rows are not used.
        seed: of the scene.
    """
    none = np.full(len(kind), -1, dtype=np.int64)
    return _observed(_rectangles(sizes), kind, none, none, options, np.random.default_rng(seed))


def house(counts: Sequence[int] = (38, 4, 23, 23), noise: float = 0.01, seed: int = 0) -> Elements:
    """The house of Figure 5.7: narrow and wide windows with a triangle on top, long and short arches."""
    random = np.random.default_rng(seed)
    shapes = [_Shape("gable", {"width": w, "height": 1.9, "rise": 0.35}, _gable(w, 1.9, 0.35)) for w in (0.9, 1.3)] + [
        _Shape("arch", {"width": 1.0, "height": h}, _arch(1.0, h)) for h in (1.9, 1.3)
    ]
    kind = np.repeat(np.arange(4), counts)
    none = np.full(len(kind), -1, dtype=np.int64)
    options = SceneOptions(elements=len(kind), kinds=4, noise=noise, occluded=0.0, points=80)
    return _observed(shapes, kind, none, none, options, random)


def _shared_sizes(kinds: int, random: np.random.Generator) -> Floats:
    """[K, 2] widths and heights, metres, each of few values, so that kinds share them."""
    num_widths = max(1, int(np.ceil(np.sqrt(kinds))))
    num_heights = -(-kinds // num_widths) if kinds != 5 else 3
    widths = _apart(0.9, _APART, num_widths, random)
    heights = _apart(1.4, _APART, num_heights, random)
    while True:
        cells = random.permutation(num_widths * num_heights)[:kinds]
        across, up = np.divmod(cells, num_heights)
        if len(set(across.tolist())) == num_widths and len(set(up.tolist())) == num_heights:
            return np.stack([widths[across], heights[up]], axis=1)


def _apart(least: float, gap: float, count: int, random: np.random.Generator) -> Floats:
    return least + np.cumsum(random.uniform(gap, 2.0 * gap, size=count))


def _rectangles(sizes: Floats) -> list[_Shape]:
    return [_Shape("rectangle", {"width": w, "height": h}, _rectangle(w, h)) for w, h in sizes.tolist()]


def _rectangle(width: float, height: float) -> Floats:
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def _gable(width: float, height: float, rise: float) -> Floats:
    corners = np.array([[0, 0], [width, 0], [width, height - rise], [width / 2, height], [0, height - rise]])
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def _arch(width: float, height: float) -> Floats:
    angle = np.linspace(0.0, np.pi, 33)
    top = np.stack([width / 2 * (1 + np.cos(angle)), height - width / 2 + width / 2 * np.sin(angle)], axis=1)
    corners = np.concatenate([[[0.0, 0.0], [width, 0.0]], top])
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def _observed(
    shapes: Sequence[_Shape], kind: Ints, row: Ints, column: Ints, options: SceneOptions, random: np.random.Generator
) -> Elements:
    number = len(kind)
    size = np.array([shape.outline.reshape(-1, 2).max(axis=0) for shape in shapes])
    cell = size.max(axis=0) + 2 * _MARGIN + _GAP
    columns = int(column.max()) + 1 if (column >= 0).all() else int(np.ceil(np.sqrt(number)))
    rows = -(-number // columns)
    place = np.stack([np.arange(number) % columns, rows - 1 - np.arange(number) // columns], axis=1)
    middle = (place + 0.5) * cell + random.uniform(-0.05, 0.05, size=(number, 2))
    hidden = random.uniform(size=number) < options.occluded
    tree = _behind_tree(middle, options.occluded) if options.tree else None
    clouds = []
    for element in range(number):
        shape = shapes[kind[element]]
        corner = middle[element] - size[kind[element]] / 2
        points = _on_outline(shape.outline, options.points, random) + corner
        if tree is not None:
            away = middle[element] - tree[0]
            facing = -away / max(float(np.linalg.norm(away)), 1e-9)
            points = _cut(points, facing, options.hidden, random) if tree[1][element] else points
        elif hidden[element]:
            angle = random.uniform(0.0, 2.0 * np.pi)
            points = _cut(points, np.array([np.cos(angle), np.sin(angle)]), options.hidden, random)
        points = points + random.normal(scale=options.noise, size=points.shape) if options.noise else points
        stray = random.binomial(len(points), _OUTLIERS) if options.noise else 0
        reach = size[kind[element]] / 2 + _MARGIN
        clouds.append(np.vstack([points, middle[element] + random.uniform(-reach, reach, size=(stray, 2))]))
    names = tuple(shape.template for shape in shapes)
    truth = Truth(kind.astype(np.int64), names, tuple(shape.parameters for shape in shapes))
    half = cell / 2 - _GAP / 2
    counts = np.array([len(cloud) for cloud in clouds])
    return Elements(
        offsets=offsets_from_counts(counts),
        points=np.vstack(clouds),
        low=middle - half,
        high=middle + half,
        row=row,
        column=column,
        truth=truth,
    )


def _on_outline(outline: Floats, count: int, random: np.random.Generator) -> Floats:
    """[count, 2] points, uniform over the length of segments."""
    length = np.linalg.norm(outline[:, 1] - outline[:, 0], axis=1)
    segment = random.choice(len(outline), size=count, p=length / length.sum())
    part = random.uniform(size=(count, 1))
    return outline[segment, 0] * (1.0 - part) + outline[segment, 1] * part


def _cut(points: Floats, direction: Floats, hidden: tuple[float, float], random: np.random.Generator) -> Floats:
    """What a half-plane leaves that hides a part of the points in a direction."""
    along = points @ direction
    return points[along <= np.quantile(along, 1.0 - random.uniform(*hidden))]


def _behind_tree(middle: Floats, part: float) -> tuple[Floats, np.ndarray]:
    """The middle of a tree, and which elements [N] it hides: those nearest to a place low on the facade."""
    trunk = np.array([middle[:, 0].mean(), middle[:, 1].min()])
    distance = np.linalg.norm(middle - trunk, axis=1)
    return trunk, distance <= np.quantile(distance, part)
