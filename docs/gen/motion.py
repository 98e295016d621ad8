"""Pictures of samples while a grammar is learned, as one animated WebP: ``python -m docs.gen.motion learned.webp``."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image, ImageDraw, ImageFont, ImageOps

import grammarlab as gl
from grammarlab.runs.sample.contact_sheet import PAPER
from grammarlab.runs.sample.shipped import find_rules

NUMBERS = (0, 16, 32, 64, 128)
"""Scores that were learned from, one sheet each."""
SCENARIO, GRAMMAR, SEED, NUM_MODELS, COLUMNS = "B1", "building", 5, 8, 4
WIDTH = 900
"""Pixels of a sheet."""
HEADING = 44
"""Pixels above the models."""
MILLISECONDS = 1600
"""Time of each sheet; the last one is shown twice as long."""


def save_motion(labels: gl.Labels, file: Path) -> None:
    """Save sheets of the same models of the same seed, from grammars learned from more and more scores.

    Args:
        labels: scores of models of the shipped grammar, at least as many as the last number.
        file: the ``.webp`` file.
    """
    with TemporaryDirectory() as folder:
        sheets = [_sheet(labels, number, Path(folder)) for number in NUMBERS]
    height = max(sheet.height for sheet in sheets)
    frames = [ImageOps.pad(sheet, (WIDTH, height), color=PAPER, centering=(0, 0)) for sheet in sheets]
    durations = [MILLISECONDS] * (len(frames) - 1) + [2 * MILLISECONDS]
    frames[0].save(file, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=80, method=6)


def _sheet(labels: gl.Labels, number: int, folder: Path) -> Image.Image:
    source = find_rules(GRAMMAR)
    text = source.text()
    if number:
        learned = folder / f"{number}.cga"
        gl.learn_from_labels(GRAMMAR, replace(labels, rows=labels.rows[:number]), learned, labels_from=SCENARIO)
        text = learned.read_text(encoding="utf-8")
    request = gl.SampleRequest(
        name=GRAMMAR, text=text, assets=source.assets, num_models=NUM_MODELS, seed=SEED, columns=COLUMNS
    )
    gl.sample_run(request, folder / str(number))
    with Image.open(folder / str(number) / f"{GRAMMAR}.png") as picture:
        sheet = picture.convert("RGB").resize((WIDTH, WIDTH * picture.height // picture.width))
    draw = ImageDraw.Draw(sheet)
    draw.rectangle((0, 0, WIDTH, HEADING), fill=PAPER)
    says = f"after {number} scores" if number else "as it is"
    draw.text((WIDTH // 40, HEADING // 4), f"{GRAMMAR}, {says}", fill="#1d2125", font=ImageFont.load_default(22))
    return sheet


if __name__ == "__main__":
    save_motion(gl.read_labels(Path(sys.argv[1])), Path(sys.argv[2]))
