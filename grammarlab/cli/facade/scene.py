"""``grammarlab facade scene``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console.report import friendly_errors, print_result


def scene(
    output: Annotated[Path, typer.Option("-o", "--output", help="File to write: .json or .npz.", dir_okay=False)],
    elements: Annotated[int, typer.Option("-n", "--elements", help="Number of rectangles.", min=1)] = 32,
    kinds: Annotated[
        int, typer.Option("--kinds", help="Number of different sizes; they share widths and heights.", min=1)
    ] = 5,
    noise: Annotated[
        float, typer.Option("--noise", help="Standard deviation of each coordinate in metres.", min=0.0, max=10.0)
    ] = 0.02,
    occluded: Annotated[
        float, typer.Option("--occluded", help="Share of the elements of which .1 to .6 is hidden.", min=0.0, max=1.0)
    ] = 0.3,
    points: Annotated[int, typer.Option("--points", help="Points per element.", min=1, max=100_000)] = 64,
    rows: Annotated[int, typer.Option("--rows", help="Rows of a facade; 0 for single elements.", min=0, max=1000)] = 0,
    tree: Annotated[bool, typer.Option("--tree", help="Hide neighbours behind a tree.")] = False,
    house: Annotated[bool, typer.Option("--house", help="Make the house of Figure 5.7 instead of rectangles.")] = False,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the scene.", min=0)] = 0,
) -> None:
    """Make a synthetic scene for `facade match`, with its truth."""
    with friendly_errors():
        from grammarlab.facade.templates import scenes
        from grammarlab.facade.templates.reading.document import save_elements

        options = scenes.SceneOptions(
            elements=elements, kinds=kinds, noise=noise, occluded=occluded, points=points, rows=rows, tree=tree
        )
        made = scenes.house(noise=noise, seed=seed) if house else scenes.rectangles(options, seed)
        output.parent.mkdir(parents=True, exist_ok=True)
        save_elements(made, output)
        print_result(output)
