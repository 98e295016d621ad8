"""``grammarlab label``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import Scheduler, friendly_errors, print_json, say
from grammarlab.cli.evaluate import PERSONS_HELP, complete_scenario
from grammarlab.files import check_overwrites
from grammarlab.learning.targets.distance_words import divergence_share


def label(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file or a shipped name.", autocompletion=complete_scenario)
    ],
    number: Annotated[int, typer.Option("-n", "--number", help="Number of scores.", min=1, max=100_000)] = 128,
    file: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Label file (.csv, .jsonl or .parquet). Default: SCENARIO_labels.csv.",
            dir_okay=False,
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option("--seed", help="Number of the person; it selects the scored models.", min=0, max=2**64 - 1)
    ] = 0,
    person: Annotated[str, typer.Option("--person", help=PERSONS_HELP)] = "exact",
    method: Annotated[
        str, typer.Option("--method", help="How models are chosen: default, paper, kde, sklearn, lightgbm.")
    ] = ("default"),
    scheduler: Scheduler = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the labels.")] = False,
) -> None:
    """Save scores that a simulated person gives to models.

    A new file is written after every round of questions; an existing one is replaced at the end. On a cluster a single
    worker does all rounds, and the file is written at the end.
    """
    saved: list[int] = []
    with friendly_errors(lambda: f"{file} has the first {saved[-1]:,} scores." if saved else ""):
        from grammarlab.cli.progress import progress
        from grammarlab.runs.evaluate.request import find_scenario
        from grammarlab.runs.evaluate.simulated_labels import label_models_of
        from grammarlab.runs.work.executor_choice import executor_of

        executor = executor_of(1, scheduler, say) if scheduler else None
        path = find_scenario(scenario)
        file = file or Path(f"{path.stem}_labels.csv")
        check_overwrites([file], [path])
        is_new = not file.exists()
        with progress(
            lambda _what, done, _total: saved.extend([done] if is_new else []), as_json=as_json
        ) as on_progress:
            result = label_models_of(
                path,
                file,
                number,
                seed=seed,
                method=method,
                person=person,
                executor=executor,
                on_progress=on_progress,
            )
        liked = sum(label.score > 0 for label in result.labels)
        js = result.curve.points[-1].js
        if as_json:
            values = {"file": str(file), "person": person, "labels": len(result.labels), "liked": liked, "js": js}
            print_json(values | {"factors": list(result.labels.factors)})
        else:
            say(
                f"{file}: {len(result.labels)} scores, {liked} above 0; "
                f"a file learned from them is {divergence_share(js)} off what is liked"
            )
