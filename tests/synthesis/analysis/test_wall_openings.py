"""Openings are the holes of walls, whatever fills them or stands before them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import mapbox_earcut as earcut
import numpy as np
import pytest
from numpy.typing import NDArray

from grammarlab.synthesis.analysis.example import Example, analyse
from grammarlab.synthesis.mesh.building_files import read_mesh
from tests.cases import some

Box = tuple[float, float, float, float]
"""Low x, low y, high x, high y, metres."""
WIDTH, HEIGHT, DEPTH = 14.0, 10.0, 8.0


@dataclass
class Drawing:
    """Polygons, each with points of its own, as programs write them that draw buildings."""

    points: list[tuple[float, float, float]] = field(default_factory=list[tuple[float, float, float]])
    faces: list[list[int]] = field(default_factory=list[list[int]])

    def rectangle(self, box: Box, z: float) -> None:
        """A polygon that faces z."""
        self.wall(box, z, [])

    def wall(self, box: Box, z: float, holes: list[Box], *, as_triangles: bool = False) -> None:
        """One polygon with holes, as triangles over shared points; or as so many triangles with points of their own."""
        x, y = (np.unique([each[k] for each in [box, *holes] for k in (axis, axis + 2)]) for axis in (0, 1))
        first, num = len(self.points) + 1, len(x)
        self.points += [(float(a), float(b), z) for b in y for a in x]
        for row, column in np.ndindex(len(y) - 1, num - 1):
            middle = (x[column] + x[column + 1]) / 2.0, (y[row] + y[row + 1]) / 2.0
            if any(hole[0] < middle[0] < hole[2] and hole[1] < middle[1] < hole[3] for hole in holes):
                continue
            a = first + row * num + column
            for face in ([a, a + 1, a + num + 1], [a, a + num + 1, a + num]):
                self.faces.append(face if not as_triangles else self._copied(face))

    def _copied(self, face: list[int]) -> list[int]:
        self.points += [self.points[index - 1] for index in face]
        return list(range(len(self.points) - 2, len(self.points) + 1))

    def around(self) -> None:
        """The other walls, the roof and the floor of a building behind the plane of z = 0."""
        corners = [(x, y, z) for z in (0.0, -DEPTH) for y in (0.0, HEIGHT) for x in (0.0, WIDTH)]
        for face in ((0, 4, 6, 2), (1, 3, 7, 5), (5, 7, 6, 4), (2, 6, 7, 3), (0, 1, 5, 4)):
            self.points += [corners[index] for index in face]
            self.faces.append(list(range(len(self.points) - 3, len(self.points) + 1)))

    def analysed(self, path: Path, turn: float = 0.0) -> Example:
        """The building, turned by an angle in radians."""
        rotation = np.array([[np.cos(turn), 0.0, np.sin(turn)], [0.0, 1.0, 0.0], [-np.sin(turn), 0.0, np.cos(turn)]])
        lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in (np.array(self.points) @ rotation.T).tolist()]
        lines += ["f " + " ".join(map(str, face)) for face in self.faces]
        path.write_text("\n".join(lines) + "\n")
        return analyse(read_mesh(path), "y")


def windows(seed: int) -> list[Box]:
    """Three rows of windows of different sizes, with some of them missing, and a door that reaches the ground."""
    random = np.random.default_rng(seed)
    boxes = [
        (x, y, x + float(random.uniform(0.8, 1.6)), y + float(random.uniform(0.9, 1.6)))
        for y in (1.0, 4.0, 7.0)
        for x in (1.0, 4.0, 7.0, 10.0)
        if random.random() < 0.8
    ]
    return [*boxes, (12.3, 0.0, 13.3, 2.1)]


def found(example: Example) -> NDArray[np.float64]:
    """[E, 4] the elements of the main wall, from the corner of the building on, in order."""
    elements = example.main.elements - np.tile(example.surface.points.min(axis=0)[:2], 2)
    return elements[np.lexsort(elements.T.round(2))]


def in_order(boxes: list[Box]) -> NDArray[np.float64]:
    table = np.array(boxes)
    return table[np.lexsort(table.T.round(2))]


@pytest.mark.parametrize("filling", ["flush", "recessed", "framed", "behind balconies", "turned", "triangles"])
@pytest.mark.parametrize("seed", some(range(5)))
def test_openings_are_the_holes_of_the_wall(filling: str, seed: int, tmp_path: Path) -> None:
    boxes, drawing = windows(seed), Drawing()
    drawing.wall((0.0, 0.0, WIDTH, HEIGHT), 0.0, boxes, as_triangles=filling == "triangles")
    drawing.around()
    for box in boxes:
        inner = (box[0] + 0.08, box[1] + 0.08, box[2] - 0.08, box[3] - 0.08)
        if filling == "framed":
            drawing.wall(box, -0.05, [inner])
            drawing.rectangle(inner, -0.08)
        else:
            drawing.rectangle(box, -0.1 if filling in ("recessed", "triangles") else 0.0)
        if filling == "behind balconies" and box[1] > 0.0:
            drawing.rectangle((box[0] - 0.3, box[1] - 0.2, box[2] + 0.3, box[1] + 0.7), 1.0)
    example = drawing.analysed(tmp_path / "house.obj", 0.3 if filling == "turned" else 0.0)
    assert found(example) == pytest.approx(in_order(boxes), abs=1e-3)


def test_the_window_in_a_loggia_counts_and_the_pane_in_a_frame_does_not(tmp_path: Path) -> None:
    loggia, window, framed, pane = (
        (1.0, 4.0, 5.0, 7.0),
        (2.0, 4.8, 4.0, 6.2),
        (8.0, 4.5, 10.0, 6.5),
        (8.3, 4.8, 9.7, 6.2),
    )
    drawing = Drawing()
    drawing.wall((0.0, 0.0, WIDTH, HEIGHT), 0.0, [loggia, framed])
    drawing.around()
    drawing.wall(loggia, -0.9, [window])
    drawing.rectangle(window, -0.95)
    drawing.wall(framed, -0.1, [pane])
    drawing.rectangle(pane, -0.12)
    assert found(drawing.analysed(tmp_path / "house.obj")) == pytest.approx(in_order([window, framed]), abs=1e-3)


def test_a_shutter_beside_a_window_belongs_to_it(tmp_path: Path) -> None:
    boxes = [(x, y, x + 1.0, y + 1.5) for y in (1.0, 5.0) for x in (1.5, 5.0, 8.5, 12.0)]
    drawing = Drawing()
    drawing.wall((0.0, 0.0, WIDTH, HEIGHT), 0.0, boxes)
    drawing.around()
    for box in boxes:
        drawing.rectangle(box, -0.1)
        drawing.rectangle((box[0] - 0.5, box[1], box[0] - 0.02, box[3]), 0.05)
    main = drawing.analysed(tmp_path / "house.obj").main
    assert main.grid.labels.shape == (2, 4)
    assert len(main.elements) == 8
    # No line between columns cuts a shutter off its window.
    assert all(not box[0] - 0.5 < line + WIDTH / 2.0 < box[2] for box in boxes for line in main.columns.line[1:-1])


def test_a_grille_has_no_windows_and_takes_bounded_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grammarlab.synthesis.analysis.wall_openings._MOST_OPENINGS", 30)
    drawing = Drawing()
    holes = [(x + 0.2, y + 0.2, x + 0.8, y + 0.8) for y in range(1, 6) for x in range(1, 9)]
    drawing.wall((0.0, 0.0, WIDTH, HEIGHT), 0.0, holes)
    drawing.around()
    for hole in holes:
        drawing.rectangle(hole, 0.0)
    drawing.rectangle((11.0, 4.0, 12.0, 6.0), 0.1)
    assert found(drawing.analysed(tmp_path / "grille.obj")) == pytest.approx(
        np.array([[11.0, 4.0, 12.0, 6.0]]), abs=0.1
    )


@pytest.mark.parametrize("turn", [0.0, 0.007])
def test_sizes_that_differ_by_centimetres_are_two_kinds_in_a_wall_that_is_not_quite_square(
    turn: float, tmp_path: Path
) -> None:
    # The other walls, square, decide how the building stands; the front leaves them by 10 cm from end to end.
    rows = [[(x, y, x + width, y + 1.4) for x in (1.0, 4.0, 7.0, 10.0)] for y, width in ((1.0, 1.0), (4.0, 1.06))]
    drawing = Drawing()
    drawing.wall((0.0, 0.0, WIDTH, HEIGHT), 0.0, [box for row in rows for box in row])
    drawing.points = [(x, y, z + np.tan(turn) * (x - WIDTH / 2.0)) for x, y, z in drawing.points]
    drawing.around()
    labels = drawing.analysed(tmp_path / "house.obj").main.grid.labels
    assert [len(set(row.tolist())) for row in labels] == [1, 1]
    assert labels[0, 0] != labels[1, 0]


def test_a_single_bar_makes_no_other_kind_and_a_railing_does(tmp_path: Path) -> None:
    boxes = [(x, y, x + 1.2, y + 1.8) for y in (1.0, 4.0, 7.0) for x in (1.0, 4.0, 7.0, 10.0)]
    drawing = Drawing()
    drawing.wall((0.0, 0.0, WIDTH, HEIGHT), 0.0, boxes)
    drawing.around()
    for box in boxes:
        drawing.rectangle(box, -0.2)
    x, y, right, top = boxes[5]
    drawing.rectangle((x + 0.55, y, x + 0.65, top), -0.1)
    x, y, right, _ = boxes[6]
    for bar in np.arange(x + 0.05, right - 0.05, 0.12).tolist():
        drawing.rectangle((bar, y, bar + 0.05, y + 0.9), -0.1)
    labels = drawing.analysed(tmp_path / "house.obj").main.grid.labels
    window = labels[0, 0]
    assert np.argwhere(labels != window).tolist() == [[1, 2]]


def test_the_depth_of_glass_makes_no_other_kind_unless_it_is_a_loggia(tmp_path: Path) -> None:
    boxes = [(x, y, x + 1.2, y + 1.5) for y in (1.0, 4.0, 7.0) for x in (1.0, 4.0, 7.0, 10.0)]
    drawing = Drawing()
    drawing.wall((0.0, 0.0, WIDTH, HEIGHT), 0.0, boxes)
    drawing.around()
    for box, depth in zip(boxes, [0.0, 0.1, 0.2, 0.25] * 2 + [0.05, 0.8, 0.15, 0.05], strict=True):
        drawing.rectangle(box, -depth)
    labels = drawing.analysed(tmp_path / "house.obj").main.grid.labels
    assert np.argwhere(labels != labels[0, 0]).tolist() == [[2, 1]]


def test_sides_of_an_opening_are_its_own_though_others_nearly_line_up(tmp_path: Path) -> None:
    # Pixels of this wall are 2.4 cm wide, and the windows of each row 1.5 cm wider than those below.
    boxes = [(x, y, x + 1.0 + 0.005 * y, y + 1.4) for y in (1.0, 4.0, 7.0) for x in (1.0, 4.0, 7.0, 10.0)]
    drawing = Drawing()
    rings = [[(x, y), (right, y), (right, top), (x, top)] for x, y, right, top in [(0.0, 0.0, WIDTH, HEIGHT), *boxes]]
    corners = np.array(rings).reshape(-1, 2)
    ends = 4 * np.arange(1, len(rings) + 1, dtype=np.uint32)
    drawing.points = [(x, y, 0.0) for x, y in corners.tolist()]
    drawing.faces = (earcut.triangulate_float64(corners, ends).reshape(-1, 3) + 1).tolist()
    drawing.around()
    for box in boxes:
        drawing.rectangle(box, -0.1)
    assert found(drawing.analysed(tmp_path / "house.obj")) == pytest.approx(in_order(boxes), abs=1e-4)


def test_a_piece_of_a_shop_in_the_cell_of_a_neighbour_is_no_wall(tmp_path: Path) -> None:
    windows = [(x, y, x + 1.0, y + 1.4) for y in (4.0, 7.0) for x in (1.0, 3.5, 6.0, 8.5, 11.0)]
    shop = (0.8, 0.5, 7.2, 2.5)
    drawing = Drawing()
    drawing.wall((0.0, 0.0, WIDTH, HEIGHT), 0.0, [*windows, shop])
    drawing.around()
    for box in windows:
        drawing.rectangle(box, -0.1)
    drawing.rectangle(shop, 0.0)
    grid = drawing.analysed(tmp_path / "house.obj").main.grid
    ground, window = grid.labels[0].tolist(), grid.labels[1, 0]
    left, middle, right, *walls = ground
    assert (grid.labels[1:] == window).all()
    assert len(set(walls)) == 1
    assert len({left, middle, right, walls[0], window}) == 5
