"""How well matches of synthetic scenes agree with their truth: the tables of docs/matching/limits.md.

    python benchmarks/measure_scans.py --scenes 5 --setting rows

A scene has 32 rectangles of at most 5 kinds and takes about 3 s. Settings: `single`, elements without rows; `rows`, a
facade of 4 x 8 whose rows agree in 85 %; `tree`, such a facade with neighbours hidden together; `half`, rows that
agree, with one half of every second window hidden. Prints a line for each amount of noise.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from grammarlab.matching.library import templates_by_name
from grammarlab.matching.plain import agreeing, compare
from grammarlab.matching.scenes import SceneOptions, rectangles
from grammarlab.runs.facade.match_files import match_elements

REGIMES = ((0.02, 0.3), (0.04, 0.6), (0.06, 0.8))
"""Noise in metres, part of the elements that are partly hidden."""
HALF = SceneOptions(rows=4, kinds=4, agreement=1.0, noise=0.01, occluded=0.5, hidden=(0.5, 0.5))
SETTINGS = {"single": SceneOptions(), "rows": SceneOptions(rows=4), "tree": SceneOptions(rows=4, tree=True)}


def main() -> None:
    """Measure one setting."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    parser.add_argument("--setting", choices=[*SETTINGS, "half"], default="single")
    parser.add_argument("--points", type=int, default=64, help="of an element of which nothing is hidden")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.scenes)
    if options.setting == "half":
        made = [replace(HALF, points=options.points)]
    else:
        base = replace(SETTINGS[options.setting], points=options.points)
        made = [replace(base, noise=noise, occluded=occluded) for noise, occluded in REGIMES]
    for each in made:
        told, found = np.array([_scores(each, seed) for seed in seeds]).transpose(1, 0, 2)
        error = found[:, 0].std() / np.sqrt(len(found))
        print(
            f"{options.setting}, noise {each.noise}, {each.occluded:.0%} partly hidden, {len(found)} scenes: "
            f"AMI k-means told {told[:, 0].mean():.2f}, default {found[:, 0].mean():.2f} +- {error:.2f}; "
            f"kinds {found[:, 1].mean():.1f} of {found[:, 2].mean():.1f}; "
            f"statements right {found[:, 4].sum() / max(found[:, 3].sum(), 1.0):.2f} of {found[:, 3].mean():.0f}; "
            f"hidden ones right {found[:, 5].sum():.0f} of {found[:, 6].sum():.0f}",
            flush=True,
        )


def _scores(options: SceneOptions, seed: int) -> list[list[float]]:
    """Of k-means and of the default: AMI, kinds found, kinds, statements of 90 %, how many of them are right; hidden
    elements that are right, and hidden elements."""
    scene = rectangles(options, seed)
    assert scene.truth is not None
    # Points that stray are 5 %.
    hidden = scene.counts < 0.95 * options.points
    names = ("adjusted_mutual_information", "kinds_found", "kinds", "sure", "sure_and_right")
    rows = []
    for method in ("kmeans", "default"):
        match = match_elements(scene, templates_by_name("rectangle"), method, 0)
        found = compare(match, scene.truth)
        right, _ = agreeing(match, scene.truth)
        rows.append([*(float(found[name]) for name in names), float(right[hidden].sum()), float(hidden.sum())])
    return rows


if __name__ == "__main__":
    main()
