"""Pages of models with their true scores."""

from pathlib import Path

import numpy as np
from PIL import Image

from grammarlab.runs.evaluate.pictures import COLUMNS, draw_examples
from grammarlab.runs.sample.contact_sheet import PAPER, lay_out
from grammarlab.runs.work.executor_choice import executor_of
from grammarlab.runs.work.executors import SERIAL
from tests.cases import takes_turns

SCENARIO = """
name = "boxes"
title = "Low boxes"
grammar = "boxes.cga"
num_models = 40
[[preference]]
score = 100
when = "$h < 2"
[[preference]]
score = 40
when = "{Red}"
"""


def test_a_page_has_a_row_for_every_group_that_is_not_empty(tmp_path: Path):
    rules = "attr h = rand(1, 5)\nLot --> 10% : extrude(h) Red else : extrude(h) Blue\nRed --> color(1, 0, 0) B."
    (tmp_path / "boxes.cga").write_text(rules + "\nBlue --> color(0, 0, 1) B.")
    (tmp_path / "boxes.toml").write_text(SCENARIO)
    path = draw_examples(tmp_path / "boxes.toml", tmp_path / "out", SERIAL)
    picture = np.asarray(Image.open(path))
    assert path.name == "boxes-scores.jpg"
    width, height = 1, 1
    while lay_out(3 * COLUMNS, COLUMNS, width, height).size()[0] < picture.shape[1]:
        width += 1
    while lay_out(3 * COLUMNS, COLUMNS, width, height).size()[1] < picture.shape[0]:
        height += 1
    page = lay_out(3 * COLUMNS, COLUMNS, width, height)
    assert picture.shape[1::-1] == page.size()

    def shown(row: int, column: int) -> bool:
        left, top = page.corner(row * COLUMNS + column)
        return bool((picture[top : top + height, left : left + width] != PAPER).any())

    # The first row has a picture, the last place of the rare case has none.
    assert shown(0, 0)
    assert shown(1, 0)
    assert shown(2, 0)
    assert not shown(1, COLUMNS - 1)


@takes_turns
def test_the_page_is_the_same_for_any_number_of_processes(tmp_path: Path):
    (tmp_path / "boxes.cga").write_text("attr h = rand(1, 5)\nLot --> extrude(h) Red\nRed --> B.")
    (tmp_path / "boxes.toml").write_text(SCENARIO)
    pages = [
        draw_examples(tmp_path / "boxes.toml", tmp_path / str(jobs), executor_of(jobs)).read_bytes() for jobs in (1, 2)
    ]
    assert pages[0] == pages[1]
