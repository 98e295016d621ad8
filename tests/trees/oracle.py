"""A tree stem by stem, written from the model's specification and the decisions in `grammarlab/trees/README.md`.

It shares with the engine only the addresses of draws. Everything else is plain: one stem after the other, matrices one
by one, no columns. It is slow on purpose.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from grammarlab.randomness import fold, uniforms
from grammarlab.trees.draws import STEMS, Site, Turn
from grammarlab.trees.parameters import COLUMNS

Matrix = np.ndarray
UP = np.array([0.0, 1.0, 0.0])
TRUNK = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Frame of a trunk: columns x, y and z; z is up."""
EPSILON = 1e-9


@dataclass(eq=False)
class Stem:
    level: int
    parent: Stem | None
    key: int
    offset: float = 0.0
    share: float = 0.0
    length: float = 0.0
    radius: float = 0.0
    room: float = 0.0
    start: Matrix = field(default_factory=lambda: np.zeros(3))
    """Place where the whole stem begins."""
    source: Stem | None = None
    whole: Stem | None = None
    """The stem that a clone is a clone of, at last."""
    first: int = 0
    axes: Matrix = field(default_factory=TRUNK.copy)
    """Frame with which the next segment begins."""
    back: float = 0.0
    """Radians by which a segment turns back after splits."""
    pending: float = 0.0
    """Radians that segments after the next turn back more."""
    steps: list[Matrix] = field(default_factory=list)
    """Nodes of the path for a length of 1, from where the whole stem begins."""
    frames: list[Matrix] = field(default_factory=list)
    points: list[Matrix] = field(default_factory=list)
    rest_frames: list[Matrix] = field(default_factory=list)
    """Frames before the wind."""
    rest_points: list[Matrix] = field(default_factory=list)
    azimuth: float = 0.0
    """Degrees, of the last child."""


@dataclass(eq=False)
class Leaf:
    stem: Stem
    offset: float
    position: Matrix
    frame: Matrix
    length: float
    width: float
    is_blossom: bool


def below(key: int, *path: int) -> int:
    keys = np.array([key], np.uint64)
    for word in path:
        keys = fold(keys, word)
    return int(keys[0])


def uniform(key: int, site: int) -> float:
    return float(uniforms(np.array([key], np.uint64), site)[0])


def about_x(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_y(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def about_z(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def about(axis: Matrix, angle: float) -> Matrix:
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def slope(direction: Matrix) -> float:
    return math.acos(max(-1.0, min(1.0, float(direction @ UP))))


def rounded(number: float) -> int:
    return math.floor(number + 0.5 + EPSILON)


def shape_ratio(shape: int, r: float, width: float) -> float:
    r = min(1.0, max(0.0, r))
    flame = r / 0.7 if r <= 0.7 else (1.0 - r) / 0.3
    match shape:
        case 0:
            return 0.2 + 0.8 * r
        case 1:
            return 0.2 + 0.8 * math.sin(math.pi * r)
        case 2:
            return 0.2 + 0.8 * math.sin(0.5 * math.pi * r)
        case 3:
            return 1.0
        case 4:
            return 0.5 + 0.5 * r
        case 5:
            return flame
        case 6:
            return 1.0 - 0.8 * r
        case 7:
            return 0.5 + 0.5 * flame
        case _:
            return width


def taper_radius(radius: float, length: float, taper: float, z: float) -> float:
    if taper < 1.0:
        return radius * (1.0 - taper * z)
    unit = 2.0 - taper if taper < 2.0 else 0.0
    t = radius * (1.0 - unit * z)
    z2 = (1.0 - z) * length
    if taper < 2.0:
        return t if z2 >= t else math.sqrt(max(0.0, t * t - (z2 - t) ** 2))
    depth = 1.0 if z2 < t else taper - 2.0
    z3 = abs(z2 - 2.0 * t * math.floor(z2 / (2.0 * t) + 0.5)) if t > 0.0 else z2
    return (1.0 - depth) * t + depth * math.sqrt(max(0.0, t * t - (z3 - t) ** 2))


class Tree:
    """One tree, grown when it is made."""

    def __init__(self, row: np.ndarray, key: int) -> None:
        self.parameters = dict(zip(COLUMNS, (float(value) for value in row), strict=True))
        trunk_key = below(key, STEMS)
        self.scale = max(self.varied("scale", trunk_key, Site.SCALE), 0.1 * self["scale"])
        stretch = max(self.varied("z_scale", trunk_key, Site.Z_SCALE), 0.1 * self["z_scale"])
        self.height = self.scale * stretch
        share = max(self.varied("length_0", trunk_key, Site.LENGTH), 0.01)
        self.unstretched = share * self.scale
        thickness = max(self.varied("scale_0", trunk_key, Site.RADIUS), 0.1 * self["scale_0"])
        trunk = Stem(0, None, trunk_key, length=share * self.height)
        trunk.radius = trunk.room = self.unstretched * self["ratio"] * thickness
        self.bare = min(1.0, self["base_size"] * self.height / trunk.length)
        self.levels = [self.grown(0, [trunk])]
        for level in range(1, int(self["levels"])):
            shoots = [child for stem in self.levels[-1] for child in self.children(stem)]
            stems = self.grown(level, shoots)
            if not stems:
                break
            self.levels.append(stems)
        self.blow()
        self.leaves = self.foliage() if len(self.levels) == int(self["levels"]) else []

    def __getitem__(self, name: str) -> float:
        return self.parameters[name]

    def varied(self, name: str, key: int, site: int) -> float:
        return self[name] + self[f"{name}_v"] * (2.0 * uniform(key, site) - 1.0)

    # Children

    def bare_share(self, stem: Stem) -> float:
        return self.bare if stem.level == 0 else 0.0

    def bearing(self, stem: Stem) -> float:
        return max(self.bare_share(stem), stem.first / self[f"curve_res_{stem.level}"])

    def number(self, stem: Stem) -> float:
        """Children that a stem has beyond its split."""
        num = self[f"branches_{stem.level + 1}"]
        if stem.level == 1:
            longest = self["length_1"] + self["length_1_v"]
            num *= 0.2 + 0.8 * min(1.0, stem.length / self.unstretched / longest)
        elif stem.level > 1:
            num *= 1.0 - 0.5 * stem.share
        bare = self.bare_share(stem)
        return num * (1.0 - self.bearing(stem)) / (1.0 - bare) if bare < 1.0 else 0.0

    def places(self, stem: Stem, num: int) -> Iterator[float]:
        """Shares of the length of a stem at which children begin."""
        segments, start = int(self[f"curve_res_{stem.level}"]), self.bearing(stem)
        if start >= 1.0:
            return
        placed = 0
        for segment in range(segments):
            low, high = max(start, segment / segments), max(start, (segment + 1) / segments)
            total = rounded(num * (high - start) / (1.0 - start))
            for index in range(total - placed):
                yield low + (high - low) * (index + 0.5) / (total - placed)
            placed = total

    def segment_at(self, stem: Stem, share: float) -> int:
        segments = int(self[f"curve_res_{stem.level}"])
        return min(int(share * segments), segments - 1)

    def joint(self, stem: Stem, share: float) -> tuple[Matrix, Matrix]:
        """Place and frame of a stem at a share of its length."""
        segment = self.segment_at(stem, share)
        part, node = share * self[f"curve_res_{stem.level}"] - segment, segment - stem.first
        point = stem.points[node] + part * (stem.points[node + 1] - stem.points[node])
        return point, stem.frames[node]

    def turned(self, stem: Stem, level: int, index: int, share: float, key: int, frame: Matrix) -> Matrix:
        """Frame of a child."""
        rotate = self[f"rotate_{level}"]
        random = self[f"rotate_{level}_v"] * (2.0 * uniform(key, Site.ROTATE) - 1.0)
        if rotate < 0.0:
            azimuth = (180.0 - rotate + random) * (1.0 if index % 2 == 0 else -1.0)
        else:
            stem.azimuth += rotate + random
            azimuth = stem.azimuth
        return frame @ about_z(math.radians(azimuth)) @ about_x(self.down_angle(stem, level, share, key))

    def down_angle(self, stem: Stem, level: int, share: float, key: int) -> float:
        spread = self[f"down_angle_{level}_v"]
        if spread >= 0.0:
            return math.radians(self[f"down_angle_{level}"] + spread * (2.0 * uniform(key, Site.DOWN) - 1.0))
        bare = self.bare_share(stem)
        r = (1.0 - share) / (1.0 - bare) if bare < 1.0 else 1.0 - share
        return math.radians(self[f"down_angle_{level}"] + spread * (1.0 - 2.0 * (0.2 + 0.8 * r)))

    def children(self, stem: Stem) -> Iterator[Stem]:
        level = stem.level + 1
        stem.azimuth = 0.0
        for index, share in enumerate(self.places(stem, rounded(self.number(stem)))):
            key = below(stem.key, Site.CHILDREN, index)
            point, frame = self.joint(stem, share)
            child = Stem(level, stem, key, share * stem.length, share, start=point)
            child.axes = self.turned(stem, level, index, share, key, frame)
            factor = self.varied(f"length_{level}", key, Site.LENGTH)
            if level == 1:
                r = (1.0 - share) / (1.0 - self.bare)
                child.length = self.unstretched * factor * shape_ratio(int(self["shape"]), r, self.envelope(r))
            else:
                child.length = factor * (stem.length - 0.6 * child.offset)
            child.room = taper_radius(stem.radius, stem.length, self[f"taper_{stem.level}"], share)
            if child.length > 1e-4 * self.scale:
                yield child

    # Paths

    def grown(self, level: int, shoots: list[Stem]) -> list[Stem]:
        """Stems of a level with their clones."""
        segments, stems = int(self[f"curve_res_{level}"]), list(shoots)
        for stem in stems:
            stem.whole, stem.steps = stem, [np.zeros(3)]
        visits = 0
        for segment in range(segments):
            for stem in stems:
                self.advance(stem, segment, segments)
            if segment + 1 == segments:
                break
            for stem in list(stems):
                if level == 0 and segment == 0 and self["base_splits"] > 0:
                    num, even = int(self["base_splits"]), True
                else:
                    rate, even = self[f"seg_splits_{level}"], False
                    num = math.floor((visits + 1) * rate + 0.5) - math.floor(visits * rate + 0.5)
                    visits += 1
                stems += self.split(stem, segment + 1, segments, num, even)
        for whole in shoots:
            family = [stem for stem in stems if stem.whole is whole]
            self.finish(whole, family)
        return [stem for stem in stems if stem.length > 1e-4 * self.scale]

    def split(self, stem: Stem, segment: int, segments: int, num: int, even: bool) -> list[Stem]:
        """The clones of a stem before a segment; the stem itself turns to the other side."""
        if num == 0:
            return []
        axes, back, clones = stem.axes, stem.back, []
        for index in range(num):
            clone = Stem(stem.level, stem.parent, below(stem.key, Site.CLONES, segment - 1, index))
            clone.offset, clone.share, clone.start, clone.room = stem.offset, stem.share, stem.start, stem.room
            clone.source, clone.whole, clone.first = stem, stem.whole, segment
            clone.steps, clone.back = [stem.steps[-1]], back
            key = below(clone.key, Site.SEGMENTS, segment)
            if even:
                spread = 360.0 * (index + 1) / (num + 1)
            else:
                declination = math.degrees(slope(axes[:, 2]))
                spread = 20.0 + 0.75 * (30.0 + abs(declination - 90.0)) * uniform(key, Turn.SPREAD) ** 2
                spread *= 1.0 if uniform(key, Turn.SIDE) < 0.5 else -1.0
            angle = self.split_angle(stem.level, axes, key)
            clone.axes = about(UP, math.radians(spread)) @ axes @ about_x(angle)
            self.give_back(clone, angle, segment, segments)
            clones.append(clone)
        angle = self.split_angle(stem.level, axes, below(stem.key, Site.SEGMENTS, segment))
        angle = angle if even else -angle
        stem.axes = axes @ about_x(angle)
        self.give_back(stem, angle, segment, segments)
        return clones

    def split_angle(self, level: int, axes: Matrix, key: int) -> float:
        angle = math.radians(self.varied(f"split_angle_{level}", key, Turn.SPLIT))
        return max(0.0, angle - slope(axes[:, 2]))

    def give_back(self, stem: Stem, angle: float, segment: int, segments: int) -> None:
        """Let the segments after this one turn back."""
        stem.pending = angle / (segments - segment - 1) if segments - segment > 1 else 0.0

    def advance(self, stem: Stem, segment: int, segments: int) -> None:
        """Add one segment to the path of a stem."""
        level = stem.level
        if segment > 0:
            curve, back = self[f"curve_{level}"], self[f"curve_back_{level}"]
            if back != 0.0:
                curve = 2.0 * curve if segment < segments / 2 else 2.0 * back
            key = below(stem.key, Site.SEGMENTS, segment)
            curve += max(0.0, self[f"curve_{level}_v"]) * (2.0 * uniform(key, Turn.CURVE) - 1.0)
            stem.axes = stem.axes @ about_x(math.radians(curve) / segments - stem.back)
            if level >= 2:
                stem.axes = stem.axes @ about_x(self.turn_to_sky(stem.axes, segments))
            stem.back, stem.pending = stem.back + stem.pending, 0.0
        frame = stem.axes
        if self[f"curve_{level}_v"] < 0.0:
            turn = 2.0 * math.pi * segment / segments
            inclination = math.radians(-self[f"curve_{level}_v"])
            frame = frame @ about_z(turn) @ about_x(inclination) @ about_z(-turn)
        stem.frames.append(frame)
        stem.steps.append(stem.steps[-1] + frame[:, 2] / segments)

    def turn_to_sky(self, axes: Matrix, segments: int) -> float:
        """Turn about x that raises the stem, but not beyond the vertical."""
        y, z = float(axes[:, 1] @ UP), float(axes[:, 2] @ UP)
        turn = self["attraction_up"] * slope(axes[:, 2]) * y / segments
        most = abs(math.atan2(y, z)) if self["attraction_up"] >= 0.0 else math.pi - abs(math.atan2(y, z))
        return -math.copysign(min(abs(turn), most), turn)

    def finish(self, whole: Stem, family: list[Stem]) -> None:
        """Lengths, radii and places of a whole stem and its clones."""
        length, level, parent = whole.length, whole.level, whole.parent
        if level > 0 and self["prune_ratio"] > 0.0:
            length = (1.0 - self["prune_ratio"]) * length + self["prune_ratio"] * self.fitted(whole, family)
        radius = whole.room
        if parent is not None:
            reference = self.unstretched if level == 1 else parent.length
            radius = min(radius, parent.radius * (length / reference) ** self["ratio_power"])
        for stem in family:
            stem.length, stem.radius = length, radius
            stem.points = [stem.start + length * step for step in stem.steps]
            stem.frames.append(stem.frames[-1])

    # Pruning

    def envelope(self, r: float) -> float:
        peak = self["prune_width_peak"]
        if not 0.0 <= r <= 1.0:
            return 0.0
        if r < 1.0 - peak:
            return (r / (1.0 - peak)) ** self["prune_power_high"]
        return ((1.0 - r) / peak) ** self["prune_power_low"] if peak > 0.0 else 1.0

    def is_inside(self, point: Matrix) -> bool:
        r = (self.height - point[1]) / (self.height * (1.0 - self["base_size"]))
        return math.hypot(point[0], point[2]) <= self["prune_width"] * self.scale * self.envelope(r)

    def fitted(self, whole: Stem, family: list[Stem]) -> float:
        """Largest length, by bisection, at which all nodes lie in the envelope."""

        def fits(share: float) -> bool:
            return all(
                self.is_inside(stem.start + whole.length * share * step) for stem in family for step in stem.steps
            )

        if fits(1.0):
            return whole.length
        low, high = 0.0, 1.0
        for _ in range(24):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if fits(middle) else (low, middle)
        return whole.length * low

    # Wind

    def blow(self) -> None:
        if self["wind_speed"] == 0.0:
            return
        angle = math.radians(self["wind_direction"])
        wind = np.array([math.cos(angle), 0.0, -math.sin(angle)])
        for stems in self.levels:
            for stem in stems:
                stem.rest_points, stem.rest_frames = stem.points, stem.frames
                self.bend(stem, wind)

    def bend(self, stem: Stem, wind: Matrix) -> None:
        segments = int(self[f"curve_res_{stem.level}"])
        if stem.source is not None:
            node = stem.first - stem.source.first
            turn = stem.source.frames[node - 1] @ stem.source.rest_frames[node - 1].T
            point = stem.source.points[node]
        elif stem.parent is not None:
            point, frame = self.joint(stem.parent, stem.share)
            node = self.segment_at(stem.parent, stem.share) - stem.parent.first
            turn = frame @ stem.parent.rest_frames[node].T
        else:
            point, turn = stem.points[0], np.eye(3)
        slender = min(200.0, stem.length / stem.radius if stem.radius > 0.0 else math.inf)
        tip = 4.0 * 30.0 * 0.5 * 1.2 * self["wind_speed"] ** 2 / (3.0 * math.pi * 8e9) * slender**3
        points, frames = [point], []
        for node in range(len(stem.rest_points) - 1):
            segment = node + stem.first
            before = 1.0 - (1.0 - max(0.0, (segment - 0.5) / segments)) ** 3
            angle = tip * (1.0 - (1.0 - (segment + 0.5) / segments) ** 3 - before)
            direction = turn @ stem.rest_frames[node][:, 2]
            between = math.acos(max(-1.0, min(1.0, float(direction @ wind))))
            axis = np.cross(direction, wind)
            if np.linalg.norm(axis) > 0.0:
                angle = min(angle * math.sin(between), between)
                turn = about(axis / np.linalg.norm(axis), angle) @ turn
            frames.append(turn @ stem.rest_frames[node])
            points.append(points[-1] + turn @ (stem.rest_points[node + 1] - stem.rest_points[node]))
        stem.points, stem.frames = points, [*frames, frames[-1]]

    # Leaves

    def foliage(self) -> list[Leaf]:
        """Leaves along stems or in fans at their tips; what rounding loses at one stem is carried on to the next."""
        leaves: list[Leaf] = []
        level = int(self["levels"]) - 1
        due, grown = 0.0, 0
        for stem in self.levels[level]:
            bare = self.bare_share(stem)
            num = abs(self["leaves"])
            if self["leaves"] > 0.0:
                num *= shape_ratio(4, stem.share if level > 0 else 1.0, 0.0)
                num *= (1.0 - self.bearing(stem)) / (1.0 - bare) if bare < 1.0 else 0.0
            due += round(num * self["leaf_quality"] * 2**24) / 2**24
            count = math.floor(due + 0.5) - grown
            grown += count
            leaves += self.along(stem, count) if self["leaves"] > 0.0 else self.fan(stem, count)
        return leaves

    def along(self, stem: Stem, count: int) -> Iterator[Leaf]:
        level = min(stem.level + 1, 3)
        stem.azimuth = 0.0
        for index, share in enumerate(self.places(stem, count)):
            key = below(stem.key, Site.LEAVES, index)
            point, frame = self.joint(stem, share)
            yield self.leaf(stem, share, point, self.turned(stem, level, index, share, key, frame), key)

    def fan(self, stem: Stem, count: int) -> Iterator[Leaf]:
        level = min(stem.level + 1, 3)
        for index in range(count):
            key = below(stem.key, Site.LEAVES, index)
            place = index / (count - 1) - 0.5 if count > 1 else 0.0
            angle = place * abs(self[f"rotate_{level}"]) + self[f"rotate_{level}_v"] * (
                2.0 * uniform(key, Site.ROTATE) - 1.0
            )
            frame = stem.frames[-1] @ about_y(math.radians(angle)) @ about_x(self.down_angle(stem, level, 1.0, key))
            yield self.leaf(stem, 1.0, stem.points[-1], frame, key)

    def leaf(self, stem: Stem, share: float, point: Matrix, frame: Matrix, key: int) -> Leaf:
        is_blossom = uniform(key, Site.BLOSSOM) < self["blossom_rate"]
        length = self["blossom_scale" if is_blossom else "leaf_scale"] / math.sqrt(self["leaf_quality"])
        width = length if is_blossom else length * self["leaf_scale_x"]
        return Leaf(stem, share * stem.length, point, self.to_light(frame, point), length, width, is_blossom)

    def to_light(self, frame: Matrix, point: Matrix) -> Matrix:
        """Turn the upper side outward about the vertical, then up."""
        bend = self["leaf_bend"]
        outside = math.atan2(point[0], point[2]) - math.atan2(frame[0, 1], frame[2, 1])
        outside = (outside + math.pi) % (2.0 * math.pi) - math.pi
        if math.hypot(point[0], point[2]) > 1e-9 * abs(point[1]):
            frame = about(UP, bend * outside) @ frame
        axis = np.cross(frame[:, 1], UP)
        return about(axis / np.linalg.norm(axis), bend * slope(frame[:, 1])) @ frame
