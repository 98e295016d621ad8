"""Commands on rule files and species: ``list``, ``check`` and ``format``."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grammarlab.cli.console import FAILURE, Library, friendly_errors, print_content, print_json, print_result, say
from grammarlab.errors import LanguageError, UsageError
from grammarlab.option_names import with_options

if TYPE_CHECKING:
    from grammarlab.runs.sample.domains import CheckedText


class Target(StrEnum):
    """Kinds of files that another kind is written as."""

    species = "species"
    arbaro = "arbaro"

    @property
    def suffix(self) -> str:
        """Suffix of such files."""
        return {Target.species: ".toml", Target.arbaro: ".xml"}[self]


def format_file(
    file: Annotated[str, typer.Argument(help="A .cga, .toml (species) or .xml (Arbaro) file, or a shipped name.")],
    check: Annotated[
        bool, typer.Option("--check", help="Exit with 1 if the file would change; write nothing.")
    ] = False,
    in_place: Annotated[bool, typer.Option("--in-place", "-i", help="Write the file instead of printing it.")] = False,
    target: Annotated[
        Target | None,
        typer.Option("--to", help="Convert trees. Default: the kind of the file, and species for those of Arbaro."),
    ] = None,
) -> None:
    """Print a file in the canonical style.

    Comments of rule files are included. Trees are converted from and to Arbaro.
    """
    with friendly_errors():
        from grammarlab.files import rewrite_text
        from grammarlab.language.grammar import read_text
        from grammarlab.runs.sample.domains import domain_of, suffix_of
        from grammarlab.runs.sample.shipped import find_rules

        if check and in_place:
            raise UsageError("--check and --in-place exclude each other.")
        source = find_rules(file)
        path, suffix = source.path, suffix_of(source.path)
        new_suffix = target.suffix if target else source.suffix
        if (check or in_place) and suffix != new_suffix:
            raise UsageError(f"{path}: a converted file is printed: leave out --check and --in-place.")
        text = read_text(path)
        formatted = domain_of(suffix).formatted(text, str(path), new_suffix)
        changed = formatted != text
        if check:
            say(f"{path}: {'would change' if changed else 'is formatted'}")
            raise typer.Exit(FAILURE if changed else 0)
        if not in_place:
            print_content(formatted)
        elif changed:
            rewrite_text(path, formatted)
            say(f"{path}: formatted")


def list_examples(
    sheet: Annotated[
        Path | None, typer.Option("--sheet", help="Draw the first model of each to this PNG file.", dir_okay=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List the grammars, also those of facades, and the species of trees that come with grammarlab."""
    from grammarlab.runs.sample.shipped import shipped_examples, shipped_facades, shipped_species

    with friendly_errors():
        groups = {"examples": shipped_examples(), "facades": shipped_facades(), "species": shipped_species()}
        if sheet is not None:
            from grammarlab.runs.sample.shipped_sheet import save_sheet
            from grammarlab.runs.work.executor_choice import executor_of

            if sheet.suffix.lower() != ".png":
                raise UsageError(
                    f"--sheet: expected the name of a .png file, as in `--sheet grammars.png`, found {str(sheet)!r}."
                )
            save_sheet([source for sources in groups.values() for source in sources], sheet, executor_of(0))
            say(f"picture: {sheet}")
        if as_json:
            print_json(
                {
                    key: [{"name": e.name, "description": e.description()} for e in sources]
                    for key, sources in groups.items()
                }
            )
            return
        width = max((len(e.name) for sources in groups.values() for e in sources), default=0)
        for sources in groups.values():
            for example in sources:
                print_result(f"{example.name:<{width}}  {example.description()}")


def check(
    grammar: Annotated[
        str,
        typer.Argument(metavar="FILE", help="A .cga, .toml or .xml file, a shipped name, or a folder."),
    ],
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Folder of assets. Default: the asset folder of the file.")
    ] = None,
    library: Library = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List all findings about a rule file or a species.

    Findings are errors, unsupported features and warnings. Imported files are included. Of a folder, it tells how many
    rule files give a model, and what the others lack, the most wanted first.

    The exit code is 1 if there is an error.
    """
    with friendly_errors():
        from grammarlab.language.presets import RuleChoices
        from grammarlab.runs.sample.checks import check_source
        from grammarlab.runs.sample.shipped import find_rules

        if Path(grammar).is_dir():
            _check_folder(Path(grammar), library, as_json)
            return
        source = find_rules(grammar, assets, RuleChoices(library))
        file = source.path
        try:
            checked: Sequence[CheckedText] = check_source(source)
        except LanguageError as error:
            if not as_json:
                raise
            checked = [error]  # that it cannot be read is a finding, too
        findings = [finding for checked_file in checked for finding in checked_file.findings]
        counts = {kind: sum(f.severity == kind for f in findings) for kind in ("error", "unsupported", "warning")}
        if as_json:
            print_json({"file": str(file), **counts, "findings": [finding.as_dict() for finding in findings]})
        else:
            for checked_file in checked:
                lines = checked_file.text.splitlines()
                for finding in checked_file.findings:
                    print_result(with_options(finding.render(lines)) + "\n")
            print_result(_summary(file, counts))
        if counts["error"]:
            raise typer.Exit(FAILURE)


_MOST_REASONS = 20
"""Largest number of features, and of files, that are printed for a folder."""


def _check_folder(folder: Path, library: Path | None, as_json: bool) -> None:
    """Print how many rule files of a folder run, and what the others lack."""
    from grammarlab.runs.sample.folder_checks import check_folder

    checked = check_folder(folder, library)
    if as_json:
        print_json({"folder": str(folder), **checked.as_dict()})
        return
    counts = checked.counts()
    nouns = {
        "runs": "give a model",
        "no start rule": "have no rule to begin with",
        "import": "miss an imported file",
        "error": "have an error",
        "stops": "stop in a derivation",
    }
    print_result(f"{folder}: {len(checked.files):,} rule files")
    for outcome, noun in nouns.items():
        if outcome in counts:
            print_result(f"  {counts[outcome]:,} {noun}")
    if wanted := checked.wanted():
        print_result("not supported, by the number of files that name it:")
        for feature, number in wanted[:_MOST_REASONS]:
            print_result(f"  {number:,}  {feature}")
    failing = [file for file in checked.files if file.outcome in ("error", "stops", "import")]
    for file in failing[:_MOST_REASONS]:
        print_result(f"{file.file}: {file.reason}")
    if len(failing) > _MOST_REASONS:
        print_result(f"… and {len(failing) - _MOST_REASONS:,} more; --json lists them")


def _summary(file: Path, counts: dict[str, int]) -> str:
    nouns = {"error": "error", "unsupported": "unsupported feature", "warning": "warning"}
    parts = [f"{count} {nouns[kind]}{'s' * (count != 1)}" for kind, count in counts.items() if count]
    return f"{file}: {', '.join(parts) or 'nothing to complain about'}"
