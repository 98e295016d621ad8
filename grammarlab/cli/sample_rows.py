"""``grammarlab sample --no-models``: models as rows of tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from grammarlab.cli.console import Unfinished, print_json, print_result, say
from grammarlab.cli.progress import progress

if TYPE_CHECKING:
    from grammarlab.runs.sample.request import SampleRequest
    from grammarlab.runs.sample.shard_run import ShardsResult
    from grammarlab.runs.work.executors import AbstractExecutor

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

    with progress(run.note, as_json=as_json) as on_progress:
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
        print_json(_as_json(result))
    else:
        plan = result.plan
        say(
            f"{plan.request.total_models:,} models of {request.name} in {plan.num_shards:,} tables, "
            f"{result.num_made:,} of them made now; {result.num_bytes / 1e6:,.3g} MB"
        )
        print_result(result.place)
    return result


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
