"""How well matches of synthetic scenes agree with their truth: the table of docs/facade-scans.md.

    python benchmarks/measure_scans.py --scenes 20 --setting rows

A scene has 32 rectangles of at most 5 kinds; a scene takes about 5 s. Prints a line for each amount of noise.
"""

from __future__ import annotations

import argparse

import numpy as np

from grammarlab.facade.templates.kinds.scoring import compare
from grammarlab.facade.templates.library import named
from grammarlab.facade.templates.scenes import SceneOptions, rectangles
from grammarlab.runs.facade.match import match_elements

REGIMES = ((0.02, 0.3), (0.04, 0.6), (0.06, 0.8))
"""Noise in metres, part of the elements that are partly hidden."""
SETTINGS = {"single": (0, False), "rows": (4, False), "tree": (4, True)}
"""Rows, and whether neighbours are hidden together."""


def main() -> None:
    """Measure one setting."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    parser.add_argument("--setting", choices=sorted(SETTINGS), default="single")
    parser.add_argument("--points", type=int, default=64, help="of an element of which nothing is hidden")
    options = parser.parse_args()
    rows, tree = SETTINGS[options.setting]
    for noise, occluded in REGIMES:
        made = SceneOptions(noise=noise, occluded=occluded, points=options.points, rows=rows, tree=tree)
        seeds = range(options.first, options.first + options.scenes)
        told, found = np.array([_scores(made, seed) for seed in seeds]).transpose(1, 0, 2)
        error = found[:, 0].std() / np.sqrt(len(found))
        print(
            f"{options.setting}, noise {noise}, {occluded:.0%} partly hidden, {len(found)} scenes: "
            f"AMI k-means told {told[:, 0].mean():.2f}, default {found[:, 0].mean():.2f} +- {error:.2f}; "
            f"kinds {found[:, 1].mean():.1f} of {found[:, 2].mean():.1f}; "
            f"statements right {found[:, 4].sum() / max(found[:, 3].sum(), 1.0):.2f} of {found[:, 3].mean():.0f}",
            flush=True,
        )


def _scores(options: SceneOptions, seed: int) -> list[list[float]]:
    """Of k-means and of the default: AMI, kinds found, kinds, statements of 90 %, and how many of them are right."""
    scene = rectangles(options, seed)
    assert scene.truth is not None
    found = [compare(match_elements(scene, named("rectangle"), each, 0), scene.truth) for each in ("kmeans", "default")]
    names = ("adjusted_mutual_information", "kinds_found", "kinds", "sure", "sure_and_right")
    return [[float(each[name]) for name in names] for each in found]


if __name__ == "__main__":
    main()
