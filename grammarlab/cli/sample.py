"""``grammarlab sample``."""

from __future__ import annotations

from dataclasses import asdict, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.console import (
    Library,
    Scheduler,
    StartRule,
    StyleName,
    Unfinished,
    friendly_errors,
    print_json,
    say,
    was_given,
)
from grammarlab.errors import LanguageError, UsageError

MOST_PRINTS = 50
"""Largest number of printed lines that are shown."""

MOST_WARNINGS = 20
"""Largest number of warnings about missing assets that are shown."""

MOST_NAMES = 8
"""Largest number of names in a list."""

_REMARKS = {
    "record": ("line of the footprints is left out", "lines of the footprints are left out"),
    "geometry": ("geometry is left out", "geometries are left out"),
    "outline": ("bad outline is left out", "bad outlines are left out"),
    "repair": ("outline is repaired", "outlines are repaired"),
    "property": (
        "property is not used, and that of the file is used instead",
        "properties are not used, and those of the file are used instead",
    ),
    "coordinates": ("remark about the coordinates", "remarks about the coordinates"),
}
"""Message about one remark, and about several, by kind of remark."""

if TYPE_CHECKING:
    from grammarlab.errors import Finding
    from grammarlab.geometry.footprints.footprint import Remark
    from grammarlab.language.presets import RuleChoices
    from grammarlab.runs.sample.run import RunResult


class FileFormat(StrEnum):
    glb = "glb"
    obj = "obj"
    ply = "ply"
    usd = "usd"
    usdz = "usdz"
    stl = "stl"
    three_mf = "3mf"


class Instancing(StrEnum):
    none = "none"
    nodes = "nodes"
    gpu = "gpu"


class Origin(StrEnum):
    world = "world"
    footprint = "footprint"
    centre = "centre"
    local = "local"


class Renderer(StrEnum):
    auto = "auto"
    cast = "cast"
    gl = "gl"


class Scale(StrEnum):
    same = "same"
    each = "each"


def complete_grammar(incomplete: str) -> list[str]:
    """Shipped grammars and species whose names begin with a text, for shell completion."""
    from grammarlab.runs.sample.shipped import shipped_examples, shipped_facades, shipped_species

    examples = (*shipped_examples(), *shipped_facades(), *shipped_species())
    return [example.name for example in examples if example.name.startswith(incomplete)]


def sample(
    context: typer.Context,
    grammar: Annotated[
        str, typer.Argument(help="A .cga, .toml or .xml file, or a shipped name.", autocompletion=complete_grammar)
    ] = "",
    num_models: Annotated[int, typer.Option("-n", "--num-models", help="Number of models per footprint.", min=1)] = 16,
    models_text: Annotated[
        str, typer.Option("--models", help="Only these models of the run, as in 3,7,9-12, each as in the whole run.")
    ] = "",
    seed: Annotated[int, typer.Option("--seed", help="Seed. Model k of a seed is always the same.", min=0)] = 0,
    output: Annotated[
        str,
        typer.Option("-o", "--output", help="Folder for the files; with --no-models also a URL. Default: out/GRAMMAR."),
    ] = "",
    attributes: Annotated[
        list[str] | None,
        typer.Option("--attr", help="Value of an attribute, name=value; may be repeated. Trees: detail=low."),
    ] = None,
    start_rule: StartRule = "",
    footprint: Annotated[
        str,
        typer.Option(
            "--footprint", help="20x12 (metres), WKT, or a map (GeoJSON and others) whose properties set attributes."
        ),
    ] = "",
    area: Annotated[
        str,
        typer.Option(
            "--on", help="Area to plant with n trees in all: a map (GeoJSON and others), WKT or 200x100 (metres)."
        ),
    ] = "",
    density: Annotated[
        float | None,
        typer.Option("--density", help="Trees per hectare of the area; -n is then the most. Larger areas keep them."),
    ] = None,
    gap: Annotated[
        float, typer.Option("--gap", help="Metres between crowns on the area; below 0 they reach into each other.")
    ] = 0.0,
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Folder of assets. Default: the asset folder of the file.")
    ] = None,
    style: StyleName = "",
    library: Library = None,
    file_format: Annotated[
        FileFormat, typer.Option("--format", help="Format of the model files; stl and 3mf are watertight solids.")
    ] = FileFormat.glb,
    no_models: Annotated[
        bool,
        typer.Option(
            "--no-models", help="No files of models: a row of each in Parquet tables, for many. The command continues."
        ),
    ] = False,
    shard_models: Annotated[
        int | None, typer.Option("--shard-models", help="With --no-models: models of a table. Default: 5,000.", min=1)
    ] = None,
    single_file: Annotated[bool, typer.Option("--single-file", help="All models in one file.")] = False,
    instancing: Annotated[
        Instancing,
        typer.Option("--instancing", help="GLB: merge by material, share meshes, or EXT_mesh_gpu_instancing."),
    ] = Instancing.none,
    origin: Annotated[
        Origin,
        typer.Option("--origin", help="Pivot of models; local is one near all of them, for programs of 32 bits."),
    ] = Origin.world,
    no_image: Annotated[bool, typer.Option("--no-image", help="Leave out the contact sheet.")] = False,
    columns: Annotated[
        int, typer.Option("--columns", help="Models per row of the sheet; 0 for about a square.", min=0)
    ] = 0,
    scale: Annotated[
        Scale,
        typer.Option("--scale", help="Scale of models on the sheet: all the same, or each fills its picture."),
    ] = Scale.each,
    renderer: Annotated[
        Renderer,
        typer.Option(
            "--renderer",
            help="cast: ray casting, the same picture everywhere; gl: OpenGL; auto: OpenGL if it works.",
        ),
    ] = Renderer.cast,
    manifest: Annotated[
        Path | None, typer.Option("--manifest", help="Repeat the run of this manifest and compare every file.")
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", help="Number of processes; 0 for one per core.", min=0)] = 0,
    scheduler: Scheduler = "",
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue an interrupted run; damaged files are made again.")
    ] = False,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="Print one JSON object about the run."),
    ] = False,
) -> None:
    """Sample models from a grammar or a species of trees.

    Writes model files, a contact sheet, derivations and a manifest.
    """
    run = Unfinished(needs="--resume")
    with friendly_errors(run.advice):
        from grammarlab.cli.console import note_slow_pictures
        from grammarlab.cli.progress import progress
        from grammarlab.language.presets import RuleChoices
        from grammarlab.runs.sample.domains import opened_models
        from grammarlab.runs.sample.manifest import read_manifest
        from grammarlab.runs.sample.request import SampleRequest, read_model_numbers
        from grammarlab.runs.sample.run import repeat_run, sample_run
        from grammarlab.runs.sample.shipped import find_rules
        from grammarlab.runs.work.executor_choice import executor_of

        executor = executor_of(jobs, scheduler, say)
        if manifest is not None:
            _refuse_with_manifest(context)
            earlier = read_manifest(manifest, assets)
            if was_given(context, "renderer"):
                earlier = replace(earlier, request=replace(earlier.request, renderer=renderer.value))
            target = Path(output or Path("out", earlier.request.name))
            if earlier.request.image and earlier.request.renderer != "gl":
                note_slow_pictures()
            if not resume and target.resolve() == (manifest if manifest.is_dir() else manifest.parent).resolve():
                raise UsageError(f"the run to repeat is in {target}: give another folder with -o.")
            with progress(run.note, as_json=as_json) as on_progress:
                result, different = repeat_run(
                    earlier, target, executor=executor, resume=resume, on_progress=on_progress
                )
            _print_summary(result, as_json, different)
            return
        if not grammar:
            raise UsageError("which grammar or species? Give a file or a name that `grammarlab list` shows.")
        source = find_rules(grammar, assets, RuleChoices(library, style))
        models = opened_models(source.suffix, source.text(), source.name, source.assets)
        print_left_out(grammar, models.left_out())
        chosen = read_model_numbers(models_text) if models_text else ()
        if chosen and not (footprint or area or was_given(context, "num_models")):
            num_models = max(num_models, chosen[-1] + 1)  # model k of a seed is the same in every run
        limit = {"num_models": num_models} if density is None or was_given(context, "num_models") else {}
        request = SampleRequest.of(
            grammar,
            footprint=footprint,
            on=area,
            density=density,
            gap=gap,
            assets=assets,
            library=library,
            style=style,
            **limit,
            models=chosen,
            seed=seed,
            attributes=models.attributes(attributes or []),
            start_rule=start_rule,
            file_format=file_format.value,
            single_file=single_file,
            instancing=instancing.value,
            image=not no_image,
            columns=columns,
            scale=scale.value,
            pivot=origin.value,
            renderer=renderer.value,
        )
        if no_models:
            from grammarlab.cli.sample_rows import sample_rows

            run.needs = ""
            _refuse_without_models(context)
            target = output or str(Path("out", request.name))
            print_remarks(sample_rows(request, target, shard_models, executor, run, as_json).plan.request.remarks)
            return
        if shard_models is not None:
            raise UsageError("--shard-models needs --no-models.")
        target = Path(output or Path("out", request.name))
        if request.image and request.renderer != "gl":
            note_slow_pictures()
        with progress(run.note, as_json=as_json) as on_progress:
            result = sample_run(request, target, executor=executor, resume=resume, on_progress=on_progress)
        _print_summary(result, as_json)


def _refuse_with_manifest(context: typer.Context) -> None:
    """Refuse options that a manifest already defines: all but folders, jobs, output and renderer."""
    free = {"output", "assets", "renderer", "manifest", "jobs", "scheduler", "resume", "as_json"}
    for name in context.params:
        if name not in free and was_given(context, name):
            option = name.removesuffix("_text").replace("_", " ")
            raise UsageError(f"--manifest repeats a run with its own options: leave out {option}.")


def _refuse_without_models(context: typer.Context) -> None:
    """Refuse options of files and pictures, of which there are none."""
    for name in ("models_text", "file_format", "single_file", "instancing", "origin", "columns", "scale", "renderer"):
        if was_given(context, name):
            option = {"file_format": "format", "models_text": "models"}.get(name, name.replace("_", "-"))
            raise UsageError(f"--no-models writes no files of models: leave out --{option}.")


def choices_of(
    grammar: str, start_rule: str, attributes: list[str] | None, style: str, library: Path | None
) -> RuleChoices:
    """The choices of a user for a file, which tells the types of the values; prints its imports that cannot be read.

    Raises:
        GrammarlabError: If the file cannot be read, or a value has another type than its attribute. Syntax errors are
            left to those who use the rules, unless there are values.
    """
    from grammarlab.language.attribute_values import read_attributes
    from grammarlab.language.grammar import Grammar, may_import
    from grammarlab.language.presets import RuleChoices
    from grammarlab.runs.sample.checks import unread_imports
    from grammarlab.runs.sample.shipped import SUFFIX, find_rules

    choices = RuleChoices(library, style, start_rule)
    source = find_rules(grammar, choices=RuleChoices(library, style))
    if source.suffix != SUFFIX:
        if attributes:
            raise UsageError(f"{grammar}: only attributes of {SUFFIX} files can be chosen; leave out --attr.")
        return choices
    text = source.text()
    if not attributes and not may_import(text):
        return choices
    try:
        parsed = Grammar.parse(text, source.file)
    except LanguageError:
        if attributes:
            raise
        return choices
    if attributes:
        choices = replace(choices, attributes=read_attributes(attributes, parsed))
    print_left_out(grammar, unread_imports(parsed))
    return choices


def print_left_out(grammar: str, findings: tuple[Finding, ...]) -> None:
    """Print ignored, unsupported and unknown features of the rules in a line each; `check` lists their places."""
    harmless = {
        finding.message.partition(" is left out")[0].split()[-1] for finding in findings if finding.code == "left-out"
    }
    serious = {finding.message.partition(" is CGA")[0] for finding in findings if finding.severity != "warning"}
    unknown = {finding.message.split("'")[1] for finding in findings if finding.code == "unknown-symbol"}
    places = f"(`grammarlab check {grammar}` lists the places)"
    if harmless:
        say(f"ignored, since no shape or colour depends on it: {_first(sorted(harmless))}")
    if serious:
        say(f"not supported: {_first(sorted(serious))} {places}")
    if unknown:
        say(f"warning: neither a rule nor an operation, so that shapes end there: {_first(sorted(unknown))} {places}")
    if any(finding.code == "bad-import" for finding in findings):
        from grammarlab.language.importing import LIBRARY_HINT

        say(LIBRARY_HINT)


def print_if_alike(text: str, suffix: str) -> None:
    """Say so if the models of a rule text cannot differ."""
    from grammarlab.runs.sample.checks import draws_nothing
    from grammarlab.runs.sample.shipped import SUFFIX

    if suffix == SUFFIX and draws_nothing(text):
        from grammarlab.language.grammar import Grammar

        can_set = any(not attribute.constant for attribute in Grammar.parse(text).attributes.values())
        say(
            "all models are equal: the rules draw nothing at random, as attr height = rand(9, 30) and "
            f"60% : Brick else : Glass do{'; --attr NAME=VALUE makes others' if can_set else ''}"
        )


def _first(names: list[str]) -> str:
    listing = ", ".join(names[:MOST_NAMES])
    return listing if len(names) <= MOST_NAMES else f"{listing} and {len(names) - MOST_NAMES} more"


def _print_summary(result: RunResult, as_json: bool, different: tuple[str, ...] | None = None) -> None:
    from grammarlab.runs.sample.clearing import in_short
    from grammarlab.runs.sample.manifest import place_in_words

    _print_output(result.prints)
    print_remarks(result.request.remarks)
    _print_missing_assets(result)
    if result.kept_files:
        names = in_short(result.kept_files)
        say(f"kept in {result.folder}, since they are not as the earlier run recorded them: {names}")
    if result.missing_images:
        say(f"no such image in {result.request.assets}: {_first(list(result.missing_images))}")
    if as_json:
        print_json(_as_json(result) | ({} if different is None else {"different_files": list(different)}))
    else:
        count = len(result.models)
        say(f"{count} model{'s' * (count != 1)} of {result.request.name} in {result.folder}")
        if result.request.stand is not None:
            say(str(result.request.stand))
        if count > 1 and not result.request.footprints:
            print_if_alike(result.request.text, result.request.suffix)
        _print_acceptance(result)
        if result.sheet is not None:
            say(f"picture: {result.sheet}")
        if result.plan is not None:
            say(f"plan: {result.plan}")
    if location := place_in_words(result.request):
        say(location)
    if different:
        say(f"not equal to the manifest: {', '.join(different)}. Compare the versions in both manifests.")
    elif different is not None:
        say("all files are equal to those of the manifest, bit for bit.")


def _print_acceptance(result: RunResult) -> None:
    """Print the share of candidates that an acceptance rule kept."""
    if result.accept_rate is None and not result.not_accepted:
        return
    from grammarlab.features.acceptance import MAX_TRIES, MAX_USUAL_TRIES

    if result.accept_rate is not None:
        say(f"the acceptance rule kept {result.accept_rate:.3g} of the candidates, at most {MAX_TRIES:,} of each model")
    if result.not_accepted:
        listing = ", ".join(f"{model.index}" for model in result.not_accepted[:MOST_NAMES])
        say(
            f"warning: none of {MAX_USUAL_TRIES:,} candidates was accepted for {len(result.not_accepted):,} models, "
            f"such as {listing}: their best candidates are used. "
            "Liked models are too rare in this file: learn it again."
        )


def print_remarks(remarks: tuple[Remark, ...]) -> None:
    """Print what is not used of the footprints: a count of each kind, and the first of them."""
    for kind, (singular, plural) in _REMARKS.items():
        remarks_of_kind = [remark for remark in remarks if remark.kind == kind]
        if not remarks_of_kind:
            continue
        say(f"{len(remarks_of_kind):,} {singular if len(remarks_of_kind) == 1 else plural}:")
        for remark in remarks_of_kind[:MOST_NAMES]:
            say(f"  {remark!s}")
        if len(remarks_of_kind) > MOST_NAMES:
            say(f"  … and {len(remarks_of_kind) - MOST_NAMES:,} more; the manifest lists them")


def _print_missing_assets(result: RunResult) -> None:
    """Print what the rules passed over and missing meshes, each with its place in the rules."""
    for finding in result.warnings[:MOST_WARNINGS]:
        say(f"{finding.location}: {finding.severity}: {finding.message} [{finding.code}]")
    if len(result.warnings) > MOST_WARNINGS:
        say(f"… and {len(result.warnings) - MOST_WARNINGS:,} more warnings")
    findings = result.missing_asset_warnings()
    for finding in findings[:MOST_WARNINGS]:
        say(f"{finding.location}: {finding.severity}: {finding.message} [{finding.code}]")
    if len(findings) > MOST_WARNINGS:
        say(f"… and {len(findings) - MOST_WARNINGS:,} more missing assets; --json lists them")
    if findings:
        say(f"  hint: {findings[0].hint}")


def _print_output(texts: tuple[str, ...]) -> None:
    """Print the output of the rules."""
    for text in texts[:MOST_PRINTS]:
        say(text.replace("\n", " "))
    if len(texts) > MOST_PRINTS:
        say(f"… and {len(texts) - MOST_PRINTS:,} more printed lines; --json lists them")


def _as_json(result: RunResult) -> dict[str, Any]:
    from grammarlab.runs.sample.manifest import place_of

    request = result.request
    return {
        "grammar": request.name,
        "hash": request.text_hash,
        "seed": request.seed,
        "models": [{**asdict(model), "file": str(result.folder / model.file)} for model in result.models],
        "prints": list(result.prints),
        "kept_files": list(result.kept_files),
        "warnings": [finding.as_dict() for finding in (*result.warnings, *result.missing_asset_warnings())],
        "place": place_of(request),
        "remarks": [asdict(remark) for remark in request.remarks],
        **_acceptance_as_json(result),
        **_stand_as_json(result),
        "sheet": None if result.sheet is None else str(result.sheet),
        "derivations": str(result.derivations),
        "manifest": str(result.manifest),
    }


def _stand_as_json(result: RunResult) -> dict[str, Any]:
    stand = result.request.stand
    if stand is None:
        return {}
    values = stand.as_json()
    plan = None if result.plan is None else str(result.plan)
    return {"stand": {name: values[name] for name in values if name != "outlines"}, "plan": plan}


def _acceptance_as_json(result: RunResult) -> dict[str, Any]:
    from grammarlab.features.acceptance import MAX_TRIES

    if result.accept_rate is None:
        return {}
    not_accepted = [model.index for model in result.not_accepted]
    return {"accept_rate": result.accept_rate, "most_tries": MAX_TRIES, "not_accepted": not_accepted}
