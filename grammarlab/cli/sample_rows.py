"""``grammarlab sample --no-models``: models as rows of tables, with progress for people and for programs."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from grammarlab.cli.console import Unfinished, print_event, print_result, progress, say

if TYPE_CHECKING:
    from grammarlab.runs.sample.request import SampleRequest
    from grammarlab.runs.sample.shard_run import ShardsResult
    from grammarlab.runs.work.executors import AbstractExecutor

_EVENT_SECONDS, _LINE_SECONDS = 1.0, 60.0
"""Seconds between events for programs, and between lines where there is no terminal."""
_MOST_FINDINGS = 20
"""Largest number of warnings that are printed."""


def sample_rows(
    request: SampleRequest,
    target: str,
    shard_models: int | None,
    executor: AbstractExecutor,
    run: Unfinished,
    as_json: bool,
) -> ShardsResult:
    """Sample the models of a request as rows, and print the result."""
    from grammarlab.runs.sample.shard_plan import SHARD_MODELS
    from grammarlab.runs.sample.shard_run import sample_shards

    with progress(run.note) as show:
        if as_json:
            notes = _at_times(_EVENT_SECONDS, lambda values: print_event("progress", values))
        else:
            notes = _at_times(_LINE_SECONDS, _say_progress)

        def on_progress(task: str, done: int, total: int) -> None:
            show(task, done, total)
            notes(done, total)

        result = sample_shards(
            request, target, shard_models=shard_models or SHARD_MODELS, executor=executor, on_progress=on_progress
        )
    findings = result.findings()
    for finding in findings[:_MOST_FINDINGS]:
        say(f"{finding.location}: {finding.severity}: {finding.message} [{finding.code}]")
    if len(findings) > _MOST_FINDINGS:
        say(f"… and {len(findings) - _MOST_FINDINGS:,} more warnings; --json lists them")
    for text in result.prints[:_MOST_FINDINGS]:
        say(text.replace("\n", " "))
    if as_json:
        print_event("finished", _as_json(result))
    else:
        plan = result.plan
        say(
            f"{plan.request.total_models:,} models of {request.name} in {plan.num_shards:,} tables, "
            f"{result.num_made:,} of them made now; {result.num_bytes / 1e6:,.3g} MB"
        )
        print_result(result.place)
    return result


def _at_times(seconds: float, note: Callable[[dict[str, Any]], object]) -> Callable[[int, int], None]:
    """A function of the numbers of finished and of all models that gives notes with rate and time left, at times."""
    first: list[tuple[float, int]] = []
    last = 0.0

    def show(done: int, total: int) -> None:
        nonlocal last
        now = time.monotonic()
        first.append((now, done)) if not first else None
        start, before = first[0]
        if now - last < seconds and done < total:
            return
        last = now
        rate = (done - before) / (now - start) if now > start else 0.0
        seconds_left = round((total - done) / rate, 1) if rate else None
        note({"done": done, "total": total, "per_second": round(rate, 3), "seconds_left": seconds_left})

    return show


def _say_progress(values: dict[str, Any]) -> None:
    """A line for a log; a terminal has a bar."""
    if not sys.stderr.isatty() and values["seconds_left"]:
        left = f"{values['seconds_left'] / 60:,.0f} min left"
        say(f"{values['done']:,} of {values['total']:,} models, {values['per_second']:,.3g} per second, {left}")


def _as_json(result: ShardsResult) -> dict[str, Any]:
    plan = result.plan
    return {
        "grammar": plan.request.name,
        "hash": plan.request.text_hash,
        "seed": plan.request.seed,
        "place": result.place,
        "models": plan.request.total_models,
        "shards": plan.num_shards,
        "made": result.num_made,
        "bytes": result.num_bytes,
        "machine": plan.machine.as_json(),
        "prints": list(result.prints),
        "warnings": [finding.as_dict() for finding in result.findings()],
    }
