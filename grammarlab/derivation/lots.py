"""Lots, the requests for models: one row per model, with address, footprint, attribute values and start rule.

A model is a function of the grammar and of its row only, so rows may be mixed, reordered and cut in any way.

A model that is far from the origin of the world has a local origin: a 32-bit number has steps of 0.25 m at 2,683,000 m,
and a 64-bit one has lost its nanometres. So far models are derived, written and drawn relative to a local origin, and
only the origin is a large number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, offsets_from_counts, take_rows
from grammarlab.errors import UsageError

NEAR = 1024.0
"""Largest coordinate in metres without a local origin; below it, 32-bit coordinates are accurate to 0.03 mm."""
_GRID = 1000.0
"""Steps of shared origins in metres."""
Footprint: TypeAlias = "tuple[float, float] | Floats"
"""Width and depth in metres of a rectangle from the origin along +x and +z, or the corners [n, 3] of a simple polygon,
counter-clockwise seen from above; holes are joined to it by doubled edges. The scope's x axis runs along the first
edge, y up, z out over the first edge."""
StreetWidths: TypeAlias = "Sequence[float] | Floats"
"""Width in metres of the street along the edge that leaves each corner of a footprint; 0 for an edge without one."""
Values: TypeAlias = "NDArray[np.float64 | np.bool_ | np.str_]"
DEFAULT_FOOTPRINT = (20.0, 20.0)
"""Width (along x) and depth (along z) in metres of the default footprint."""
_LARGEST_WORD = 2**64 - 1


@dataclass(frozen=True, slots=True)
class Footprints:
    """F different polygons, as a ragged list of corners."""

    points: Floats
    """[P, 3] corners in metres, those of the first polygon first."""
    offsets: NDArray[np.int64]
    """[F + 1] into `points`."""
    street_width: Floats | None = None
    """[P] width in metres of the street along the edge that leaves each corner, 0 for an edge without a street; NaN at
    all corners of a footprint whose streets are unknown; None if they are unknown for all footprints."""

    def __post_init__(self) -> None:
        if len(self.offsets) and np.diff(self.offsets).min(initial=3) < 3:
            raise UsageError("footprints: expected at least three corners for each")
        if self.street_width is not None:
            _check_widths(self.street_width, self.offsets)

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @classmethod
    def of(cls, footprints: Sequence[Footprint], street_widths: Sequence[StreetWidths | None] | None = None) -> Self:
        """Footprints as a table, in the order given.

        Args:
            footprints: [F] the footprints.
            street_widths: [F] widths of the streets along the edges of each, None where they are unknown.

        Raises:
            UsageError: If one has fewer than three corners, a coordinate is not finite, its first edge has length 0, or
                it has not one width of at least 0 m for each edge.

        >>> Footprints.of([(20, 12), (9, 9)], [[8, 0, 0, 6], None]).street_width.tolist()
        [8.0, 0.0, 0.0, 6.0, nan, nan, nan, nan]
        """
        polygons = [_corners(footprint) for footprint in footprints]
        points = np.concatenate([np.zeros((0, 3)), *polygons])
        counts = np.array([len(polygon) for polygon in polygons], dtype=np.int64)
        widths = [None] * len(polygons) if street_widths is None else list(street_widths)
        if len(widths) != len(polygons):
            raise UsageError(f"street widths: expected those of {len(polygons)} footprints, found {len(widths)}")
        columns = [_edge_widths(width, count) for width, count in zip(widths, counts.tolist(), strict=True)]
        return cls(points, offsets_from_counts(counts), _joined_widths(columns, counts))

    def take(self, rows: NDArray[np.integer]) -> Footprints:
        """The footprints [K] with these indices."""
        where, offsets = take_rows(self.offsets, rows)
        widths = None if self.street_width is None else self.street_width[where]
        return Footprints(self.points[where], offsets, None if widths is None or np.isnan(widths).all() else widths)

    def polygon(self, index: int) -> Floats:
        """The corners [n, 3] of one footprint."""
        return self.points[self.offsets[index] : self.offsets[index + 1]]

    def widths(self, index: int) -> Floats | None:
        """[n] widths in metres of the streets along the edges of one footprint; None if they are unknown."""
        if self.street_width is None:
            return None
        widths = self.street_width[self.offsets[index] : self.offsets[index + 1]]
        return None if np.isnan(widths[0]) else widths


@dataclass(frozen=True, slots=True)
class AttributeColumn:
    """Values of one attribute for N models, instead of those in the rule file."""

    values: Values
    """[N] the values; arbitrary where none is given."""
    is_given: NDArray[np.bool_]
    """[N] False where the model has the value in the rule file."""

    def take(self, rows: NDArray[np.integer]) -> AttributeColumn:
        """The values of the models at these rows."""
        return AttributeColumn(self.values[rows], self.is_given[rows])


@dataclass(frozen=True, slots=True, kw_only=True)
class Lots:
    """N models to derive.

    >>> import grammarlab as gl
    >>> lots = gl.Lots.concatenate([gl.Lots.of(2, seed=5), gl.Lots.of(1, seed=7, first_model=4)])
    >>> len(lots), lots.model.tolist(), lots.name(2)
    (3, [0, 1, 4], 'model 4 of seed 7')
    """

    seed: NDArray[np.uint64]
    """[N] seed."""
    model: NDArray[np.uint64]
    """[N] index of the model under its seed."""
    footprints: Footprints
    """The different footprints."""
    footprint: NDArray[np.int32]
    """[N] index into `footprints`."""
    attributes: Mapping[str, AttributeColumn]
    """Values of attributes by name, for attributes with a value for at least one model."""
    start_rules: tuple[str, ...]
    """The different start rules; an empty name for the one that the grammar marks."""
    start_rule: NDArray[np.int32]
    """[N] index into `start_rules`."""

    def __post_init__(self) -> None:
        _check_index("footprint", self.footprint, len(self), len(self.footprints))
        _check_index("start rule", self.start_rule, len(self), len(self.start_rules))
        columns = {"seed": self.seed, **{name: column.values for name, column in self.attributes.items()}}
        columns |= {f"given {name}": column.is_given for name, column in self.attributes.items()}
        for name, column in columns.items():
            if column.shape != (len(self),):
                raise UsageError(f"lots: expected a {name} for each of {len(self)} models, found shape {column.shape}")
        for name, column in (("seed", self.seed), ("model", self.model)):
            if column.dtype != np.uint64:
                raise UsageError(f"lots: expected a column {name} of uint64, found {column.dtype}; Lots.at makes one")

    def __len__(self) -> int:
        return len(self.model)

    def __str__(self) -> str:
        return self.name(0) if len(self) == 1 else f"{len(self)} models"

    @property
    def origins(self) -> Floats:
        """[N, 3] origin of the positions of each model, in world metres (see `origins_of`)."""
        return _origins_of_polygons(self.footprints.points, self.footprints.offsets)[self.footprint]

    @classmethod
    def of(
        cls,
        num_models: int,
        seed: int,
        *,
        first_model: int = 0,
        footprint: Footprint = DEFAULT_FOOTPRINT,
        attributes: Mapping[str, float | bool | str] | None = None,
        start_rule: str | None = None,
        street_width: StreetWidths | None = None,
    ) -> Self:
        """Consecutive models of one seed with equal footprints, attributes and start rules.

        Args:
            num_models: number of models, 0 or more.
            seed: 0 <= seed < 2**64.
            first_model: index of the first model under the seed, 0 <= first_model < 2**64.
            footprint: the footprint of all models.
            attributes: values of attributes, instead of those of the grammar.
            start_rule: start symbol, instead of the one that the grammar marks.
            street_width: width of the street along each edge of the footprint, None if nothing is known of streets.

        Raises:
            UsageError: If a number is out of range, the footprint is not a polygon, or not each edge has a width.
        """
        if not isinstance(num_models, int | np.integer) or num_models < 0:
            raise UsageError(f"expected 0 models or more, found {num_models!r}")
        _check_word("seed", seed)
        _check_word("index of the first model", first_model)
        _check_word("index of the last model", first_model + max(num_models, 1) - 1)
        models = np.arange(num_models, dtype=np.uint64) + np.uint64(first_model)
        return cls.at(
            np.full(num_models, seed, dtype=np.uint64), models, footprint, attributes, start_rule, street_width
        )

    @classmethod
    def at(
        cls,
        seed: int | Sequence[int] | NDArray[np.integer],
        model: int | Sequence[int] | NDArray[np.integer],
        footprint: Footprint = DEFAULT_FOOTPRINT,
        attributes: Mapping[str, float | bool | str] | None = None,
        start_rule: str | None = None,
        street_width: StreetWidths | None = None,
    ) -> Self:
        """Models of any addresses with equal footprints, attributes and start rules.

        Args:
            seed: [N] seeds, or one for all.
            model: [N] indices under these seeds.
            footprint: the footprint of all models.
            attributes: values of attributes, instead of those of the grammar.
            start_rule: start symbol, instead of the one that the grammar marks.
            street_width: width of the street along each edge of the footprint, None if nothing is known of streets.

        Raises:
            UsageError: If a number is out of range, the footprint is not a polygon, or not each edge has a width.
        """
        models = _words("index of a model", model)
        num = len(models)
        if attributes is not None and not isinstance(attributes, Mapping):
            raise UsageError(f'attributes: expected values by name such as {{"height": 12}}, found {attributes!r:.60}')
        return cls(
            seed=np.broadcast_to(_words("seed", seed), num).copy(),
            model=models,
            footprints=Footprints.of([footprint], [street_width]),
            footprint=np.zeros(num, dtype=np.int32),
            attributes={
                name: AttributeColumn(np.repeat(_plain(name, value), num), np.ones(num, dtype=bool))
                for name, value in (attributes or {}).items()
            },
            start_rules=(start_rule or "",),
            start_rule=np.zeros(num, dtype=np.int32),
        )

    def on(self, footprints: Footprints, footprint: NDArray[np.integer]) -> Lots:
        """These models on other footprints.

        Args:
            footprints: the different footprints.
            footprint: [N] index of the footprint of each model.

        Raises:
            UsageError: If an index is not in the table, or their number is not N.
        """
        return replace(self, footprints=footprints, footprint=np.asarray(footprint).astype(np.int32))

    def take(self, rows: NDArray[np.integer]) -> Lots:
        """The models at these rows, in any order, repeats allowed; tables keep only used values."""
        used, footprint = np.unique(self.footprint[rows], return_inverse=True)
        starts, start_rule = np.unique(self.start_rule[rows], return_inverse=True)
        columns = {name: column.take(rows) for name, column in self.attributes.items()}
        return Lots(
            seed=self.seed[rows],
            model=self.model[rows],
            footprints=self.footprints.take(used),
            footprint=footprint.astype(np.int32),
            attributes={name: column for name, column in columns.items() if column.is_given.any()},
            start_rules=tuple(self.start_rules[start] for start in starts.tolist()),
            start_rule=start_rule.astype(np.int32),
        )

    @staticmethod
    def concatenate(parts: Sequence[Lots]) -> Lots:
        """All models of several lots, in order; equal footprints and start rules are stored once.

        Raises:
            UsageError: If there are no parts, or an attribute has different types in them.
        """
        if not parts:
            raise UsageError("expected at least one value of Lots to join")
        polygons: dict[tuple[bytes, bytes | None], int] = {}
        unique_polygons: list[Floats] = []
        unique_widths: list[Floats | None] = []
        starts: dict[str, int] = {}
        footprint, start_rule = [], []
        for part in parts:
            indices = []
            for row in range(len(part.footprints)):
                polygon, widths = part.footprints.polygon(row), part.footprints.widths(row)
                content = polygon.tobytes(), None if widths is None else widths.tobytes()
                index = polygons.setdefault(content, len(polygons))
                if index == len(unique_polygons):
                    unique_polygons.append(polygon)
                    unique_widths.append(widths)
                indices.append(index)
            footprint.append(np.array(indices, dtype=np.int32)[part.footprint])
            numbers = [starts.setdefault(name, len(starts)) for name in part.start_rules]
            start_rule.append(np.array(numbers, dtype=np.int32)[part.start_rule])
        names = dict.fromkeys(name for part in parts for name in part.attributes)
        counts = np.array([len(polygon) for polygon in unique_polygons], dtype=np.int64)
        return Lots(
            seed=np.concatenate([part.seed for part in parts]),
            model=np.concatenate([part.model for part in parts]),
            footprints=Footprints(
                np.concatenate([np.zeros((0, 3)), *unique_polygons]),
                offsets_from_counts(counts),
                _joined_widths(unique_widths, counts),
            ),
            footprint=np.concatenate(footprint),
            attributes={name: _joined(name, parts) for name in names},
            start_rules=tuple(starts),
            start_rule=np.concatenate(start_rule),
        )

    def name(self, row: int) -> str:
        """Name of a model in messages: its address.

        >>> Lots.of(3, seed=5, first_model=10).name(2)
        'model 12 of seed 5'
        """
        return f"model {self.model[row]} of seed {self.seed[row]}"


def brought_near(points: Floats, offsets: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Origins [F, 3] of footprints, and their corners [P, 3] relative to the origins.

    Far corners are rounded to the decimals that numbers of their size have, so that rounding errors do not change the
    lengths of sides.

    Args:
        points: [P, 3] the corners of all footprints in the world, at least one for each.
        offsets: [F + 1] offsets of the corners of each footprint.

    >>> corners = np.array([[2683000.13, 0, 0], [2683018.4, 0, 0], [2683018.4, 0, 9]])
    >>> origins, near = brought_near(corners, np.array([0, 3]))
    >>> origins.tolist(), near.tolist()
    ([[2683000.13, 0.0, 0.0]], [[0.0, 0.0, 0.0], [18.27, 0.0, 0.0], [18.27, 0.0, 9.0]])
    """
    origins = _origins_of_polygons(points, offsets)
    near = points.copy()
    for index in np.flatnonzero(origins.any(axis=1)).tolist():
        corners = slice(*offsets[index : index + 2])
        step = np.spacing(np.abs(points[corners]).max())
        near[corners] = np.round(points[corners] - origins[index], int(-np.log10(4.0 * step))) + 0.0
    return origins, near


def origins_of(low: Floats, high: Floats) -> Floats:
    """Origin [N, 3] in the world for the coordinates of each object.

    An object that is farther than `NEAR` along some axis has the lowest corner of its bounding box as origin; others
    have the origin of the world. So an origin depends only on the object, and equal objects at different places have
    the same local coordinates.

    Args:
        low: [N, 3] smallest world coordinates of each object.
        high: [N, 3] largest world coordinates of each object.

    >>> low = np.array([[0.0, 0.0, -5.0], [2683000.0, 0.0, -5.0]])
    >>> origins_of(low, low + 9.0).tolist()
    [[0.0, 0.0, 0.0], [2683000.0, 0.0, -5.0]]
    """
    far = np.any((low > NEAR) | (high < -NEAR), axis=1, keepdims=True)
    return np.where(far, low, 0.0)


def shared_origin(low: Floats, high: Floats) -> Floats | None:
    """Origin [3] in the world that several objects share; None if no object is far, so that all have the world's.

    It is in whole kilometres near the middle of the objects, so that another object hardly ever moves it, unless their
    common bounding box is near the origin of the world.

    Args:
        low: [N, 3] smallest world coordinates of each object, at least one.
        high: [N, 3] largest world coordinates of each object.

    >>> low = np.array([[2683000.13, 0.0, -1247010.37], [2683040.13, 0.0, -1247010.37]])
    >>> shared_origin(low, low + 9.0).tolist()
    [2683000.0, 0.0, -1247000.0]
    """
    if not origins_of(low, high).any():
        return None
    low, high = low.min(axis=0), high.max(axis=0)
    if not origins_of(low[None], high[None]).any():
        return np.zeros(3)
    return np.round((low + high) / 2 / _GRID) * _GRID + 0.0


def _corners(footprint: Footprint) -> Floats:
    """Checked corners [n, 3] of a footprint."""
    if isinstance(footprint, tuple):
        if not (len(footprint) == 2 and all(np.isfinite(footprint)) and min(footprint) > 0):
            raise UsageError(f"footprint: expected width and depth in metres, both above 0, found {footprint}")
        width, depth = footprint
        return np.array([[0.0, 0.0, depth], [width, 0.0, depth], [width, 0.0, 0.0], [0.0, 0.0, 0.0]])
    try:
        corners = np.ascontiguousarray(footprint, dtype=np.float64)
    except (TypeError, ValueError):
        raise UsageError(
            f"footprint: expected (width, depth) in metres or corners [n, 3], found {footprint!r:.60}; "
            "gl.read_footprints(text)[0].polygon are the corners of a text"
        ) from None
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) < 3:
        raise UsageError(f"footprint: expected corners [n, 3] of a polygon, n at least 3, found shape {corners.shape}")
    if not np.isfinite(corners).all():
        raise UsageError("footprint: expected finite coordinates in metres")
    if (corners[0] == corners[1]).all():
        raise UsageError(
            f"footprint: the first two corners are the same, {corners[0].tolist()}; the first edge gives the scope its "
            "direction, so leave one of them out"
        )
    return corners


def _edge_widths(widths: StreetWidths | None, count: int) -> Floats | None:
    """Checked widths [count] of the streets along the edges of a footprint."""
    if widths is None:
        return None
    try:
        column = np.asarray(widths, dtype=np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"street widths: expected metres for each edge, found {widths!r:.60}") from None
    if column.shape != (count,):
        raise UsageError(f"street widths: expected one for each of {count} edges, found shape {column.shape}")
    if not (np.isfinite(column) & (column >= 0.0)).all():
        raise UsageError("street widths: expected metres, 0 for no street, found a negative or no number")
    return column + 0.0


def _joined_widths(columns: Sequence[Floats | None], counts: NDArray[np.int64]) -> Floats | None:
    """[P] street widths of all footprints with these numbers of edges; None if those of all are unknown."""
    if all(column is None for column in columns):
        return None
    return np.concatenate(
        [
            np.full(count, np.nan) if column is None else column
            for column, count in zip(columns, counts.tolist(), strict=True)
        ]
    )


def _check_widths(widths: Floats, offsets: NDArray[np.int64]) -> None:
    num_corners = int(offsets[-1]) if len(offsets) else 0
    if widths.shape != (num_corners,) or widths.dtype != np.float64:
        raise UsageError(
            f"street widths: expected a column of float64 for {num_corners} corners, "
            f"found {widths.dtype} of shape {widths.shape}"
        )
    unknown = np.isnan(widths)
    if not ((np.isfinite(widths) & (widths >= 0.0)) | unknown).all():
        raise UsageError("street widths: expected metres, 0 for no street, found a negative or infinite number")
    if unknown.any() and (np.add.reduceat(unknown.astype(np.int64), offsets[:-1]) % np.diff(offsets)).any():
        raise UsageError("street widths: expected those of all edges of a footprint or of none, found NaN at some")


def _check_index(name: str, index: NDArray[np.int32], num_models: int, num: int) -> None:
    if index.shape != (num_models,):
        raise UsageError(f"lots: expected a {name} for each of {num_models} models, found shape {index.shape}")
    if num_models and not (index.min() >= 0 and index.max() < num):
        raise UsageError(
            f"lots: expected indices of {num} {name}s, from 0 to {num - 1}, found {index.min()} to {index.max()}"
        )


def _origins_of_polygons(points: Floats, offsets: NDArray[np.int64]) -> Floats:
    """Origins [F, 3] of polygons; for the arguments see `brought_near`."""
    starts = offsets[:-1]
    return origins_of(np.minimum.reduceat(points, starts, axis=0), np.maximum.reduceat(points, starts, axis=0))


def _check_word(name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 0 <= int(value) <= _LARGEST_WORD:
        raise UsageError(f"{name}: expected a whole number from 0 to {_LARGEST_WORD}, found {value!r}")


def _words(name: str, values: int | Sequence[int] | NDArray[np.integer]) -> NDArray[np.uint64]:
    """[N] whole numbers as uint64."""
    if isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype.kind in "iu":
        if values.dtype != np.uint64 and len(values):
            _check_word(name, int(values.min()))
        return values.astype(np.uint64, copy=False)
    numbers = [values] if isinstance(values, int) else list(values)
    for number in numbers:
        _check_word(name, number)
    return np.array(numbers, dtype=np.uint64)


def _plain(name: str, value: object) -> Values:
    """[1] a value of an attribute as a column."""
    if isinstance(value, bool | np.bool_):
        return np.array([value], dtype=np.bool_)
    if isinstance(value, str):
        return np.array([value], dtype=np.str_)
    if isinstance(value, int | float | np.integer | np.floating):
        return np.array([value], dtype=np.float64)
    raise UsageError(f"attribute {name}: expected a number, a bool or a text, found {value!r}")


def _joined(name: str, parts: Sequence[Lots]) -> AttributeColumn:
    """One attribute of the models of several lots."""
    columns = [part.attributes.get(name) for part in parts]
    first = next(column for column in columns if column is not None)
    if len({column.values.dtype.kind for column in columns if column is not None}) > 1:
        raise UsageError(f"attribute {name}: expected values of one type, found numbers, bools or texts mixed")
    values = [
        np.zeros(len(part), dtype=first.values.dtype) if column is None else column.values
        for column, part in zip(columns, parts, strict=True)
    ]
    is_given = [
        np.zeros(len(part), dtype=bool) if column is None else column.is_given
        for column, part in zip(columns, parts, strict=True)
    ]
    return AttributeColumn(np.concatenate(values), np.concatenate(is_given))
