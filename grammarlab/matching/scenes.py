"""Synthetic scenes with ground truth: rectangles and arches of a few kinds with shared sizes, and defects of scans.

The scenes follow Figures 5.2, 5.7, 5.8 and 5.12 of paper 001: points on outlines with noise, parts hidden behind
half-planes, outliers; rows of a facade with equal kinds, and trees that hide neighbours together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints, offsets_from_counts
from grammarlab.errors import UsageError
from grammarlab.matching.elements import MOST_ELEMENTS, MOST_POINTS, Elements, Truth

_GAP_M = 0.6
"""Distance between boxes, metres."""
_MARGIN_M = 0.25
"""Margin of a box around its element, metres."""
_OUTLIER_SHARE = 0.05
"""Expected fraction of outliers."""
_MIN_SIZE_STEP_M = 0.05
"""Least difference of sizes, metres; the largest is twice that. Windows of real facades differ by 5 cm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneOptions:
    """Properties of a scene."""

    elements: int = 32
    kinds: int = 5
    noise: float = 0.02
    """Standard deviation of each coordinate, metres."""
    occluded: float = 0.3
    """Fraction of partly hidden elements."""
    hidden: tuple[float, float] = (0.1, 0.6)
    """Range of the fraction of points that each of these hides."""
    points: int = 64
    """Number of points of an element without hidden parts."""
    rows: int = 0
    """Number of rows of a facade; 0 for single elements without rows and columns."""
    agreement: float = 0.85
    """Fraction of the elements of a row that are of the row's kind."""
    tree: bool = False
    """Whether one tree hides all hidden parts, so that neighbours are hidden together."""


@dataclass(frozen=True, slots=True)
class _Shape:
    """A kind of a scene."""

    template: str
    parameters: dict[str, float]
    outline: Floats
    """[S, 2, 2] segments, from the lower left corner."""


def rectangles(options: SceneOptions, seed: int) -> Elements:
    """A scene of rectangles; each of its five kinds shares its width or height with another one (Figure 5.2).

    Raises:
        UsageError: If the options are invalid.
    """
    if not (1 <= options.kinds <= options.elements) or options.noise < 0.0 or options.points < 1:
        raise UsageError("expected at least one element, kind and point, not more kinds than elements, noise >= 0.")
    if options.elements > MOST_ELEMENTS or options.elements * options.points > MOST_POINTS:
        raise UsageError(f"expected at most {MOST_ELEMENTS:,} elements with {MOST_POINTS:,} points together.")
    random = np.random.default_rng(seed)
    sizes = _shared_sizes(options.kinds, random)
    if options.rows:
        row_kind = random.integers(options.kinds, size=options.rows)
        columns = -(-options.elements // options.rows)
        row, column = (index[: options.elements] for index in np.divmod(np.arange(options.rows * columns), columns))
        agrees = random.uniform(size=options.elements) < options.agreement
        kind = np.where(agrees, row_kind[row], random.integers(options.kinds, size=options.elements))
    else:
        row = column = np.full(options.elements, -1, dtype=np.int64)
        kind = random.permutation(np.arange(options.elements) % options.kinds)
    return _observed(_rectangles(sizes), kind, row, column, options, random)


def scene_of_sizes(sizes: Floats, kind: Ints, options: SceneOptions, seed: int) -> Elements:
    """A scene of rectangles of given widths and heights.

    Args:
        sizes: [K, 2] widths and heights, metres.
        kind: [N] index into `sizes` for each element.
        options: noise, points, and hidden parts; counts and rows are not used.
        seed: seed of the scene.
    """
    no_line = np.full(len(kind), -1, dtype=np.int64)
    return _observed(_rectangles(sizes), kind, no_line, no_line, options, np.random.default_rng(seed))


def house(counts: Sequence[int] = (38, 4, 23, 23), noise: float = 0.01, seed: int = 0) -> Elements:
    """The house of Figure 5.7: narrow and wide windows with a triangle on top, long and short arches."""
    random = np.random.default_rng(seed)
    shapes = [_Shape("gable", {"width": w, "height": 1.9, "rise": 0.35}, _gable(w, 1.9, 0.35)) for w in (0.9, 1.3)] + [
        _Shape("arch", {"width": 1.0, "height": h}, _arch(1.0, h)) for h in (1.9, 1.3)
    ]
    kind = np.repeat(np.arange(4), counts)
    no_line = np.full(len(kind), -1, dtype=np.int64)
    options = SceneOptions(elements=len(kind), kinds=4, noise=noise, occluded=0.0, points=80)
    return _observed(shapes, kind, no_line, no_line, options, random)


def _shared_sizes(kinds: int, random: np.random.Generator) -> Floats:
    """[K, 2] widths and heights, metres, from few values, so that kinds share them."""
    num_widths = max(1, int(np.ceil(np.sqrt(kinds))))
    num_heights = -(-kinds // num_widths) if kinds != 5 else 3
    widths = _spaced_sizes(0.9, _MIN_SIZE_STEP_M, num_widths, random)
    heights = _spaced_sizes(1.4, _MIN_SIZE_STEP_M, num_heights, random)
    while True:
        cells = random.permutation(num_widths * num_heights)[:kinds]
        across, up = np.divmod(cells, num_heights)
        if len(set(across.tolist())) == num_widths and len(set(up.tolist())) == num_heights:
            return np.stack([widths[across], heights[up]], axis=1)


def _spaced_sizes(least: float, gap: float, count: int, random: np.random.Generator) -> Floats:
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
    cell = size.max(axis=0) + 2 * _MARGIN_M + _GAP_M
    columns = int(column.max()) + 1 if (column >= 0).all() else int(np.ceil(np.sqrt(number)))
    rows = -(-number // columns)
    cell_index = np.stack([np.arange(number) % columns, rows - 1 - np.arange(number) // columns], axis=1)
    middle = (cell_index + 0.5) * cell + random.uniform(-0.05, 0.05, size=(number, 2))
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
        stray = random.binomial(len(points), _OUTLIER_SHARE) if options.noise else 0
        reach = size[kind[element]] / 2 + _MARGIN_M
        clouds.append(np.vstack([points, middle[element] + random.uniform(-reach, reach, size=(stray, 2))]))
    names = tuple(shape.template for shape in shapes)
    truth = Truth(kind.astype(np.int64), names, tuple(shape.parameters for shape in shapes))
    half = cell / 2 - _GAP_M / 2
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
    """The visible points if a half-plane in a direction hides a fraction of them from a range."""
    along = points @ direction
    return points[along <= np.quantile(along, 1.0 - random.uniform(*hidden))]


def _behind_tree(middle: Floats, part: float) -> tuple[Floats, np.ndarray]:
    """The centre of a tree, and the elements [N] that it hides: those nearest to a point low on the facade."""
    trunk = np.array([middle[:, 0].mean(), middle[:, 1].min()])
    distance = np.linalg.norm(middle - trunk, axis=1)
    return trunk, distance <= np.quantile(distance, part)
