"""Shipped scenario files, and the files of SCENARIOS arguments."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

from grammarlab.about import PACKAGE
from grammarlab.errors import UsageError
from grammarlab.evaluation.scenario import SUFFIX
from grammarlab.files import existing

FIGURES = "figures"
"""The folder of named experiments in the folder of scenarios (`evaluate_figures`)."""


TASTES = "tastes"
"""The folder in that of scenarios with further scenarios of many kinds, for tuning and testing a learner."""


def scenarios_folder() -> Path:
    """Folder of the shipped scenarios: inside an installed package, or next to it in a checkout."""
    inside = PACKAGE / "scenarios"
    return inside if inside.is_dir() else PACKAGE.parent / "scenarios"


def shipped_scenarios() -> dict[str, Path]:
    """The shipped scenario files by name, without those of the tastes."""
    return {file.stem: file for file in sorted(scenarios_folder().glob(f"*{SUFFIX}"))}


def named_scenarios() -> dict[str, Path]:
    """All shipped scenario files with unique names, including the tastes."""
    tastes = sorted((scenarios_folder() / TASTES).glob(f"*/*{SUFFIX}"))
    return shipped_scenarios() | {file.stem: file for file in tastes}


def find_scenario(argument: str) -> Path:
    """Scenario file of a SCENARIO argument: a file, or a shipped name.

    Raises:
        UsageError: If there is no scenario with that name, or there are several.
    """
    found = find_scenarios(argument)
    if len(found) != 1:
        raise UsageError(f"expected one scenario, found {len(found)} in {argument!r}.")
    return found[0]


def find_scenarios(argument: str) -> tuple[Path, ...]:
    """Scenario files of a SCENARIOS argument: a file, all files of a folder, a shipped name, or several.

    Args:
        argument: text of the argument; several are separated by commas.

    Raises:
        UsageError: If there is nothing with that name; the message has the nearest names.
    """
    if (path := existing(argument)) is not None:
        if path.is_file():
            return (path,)
        found = tuple(sorted(path.glob(f"*{SUFFIX}")))
        if not found:
            raise UsageError(f"the folder {argument!r} has no scenario: expected files with the suffix {SUFFIX}.")
        return found
    shipped = named_scenarios()
    if argument in shipped:
        return (shipped[argument],)
    if "," in argument:
        return tuple(path for part in argument.split(",") for path in find_scenarios(part))
    names, wanted = {name.lower(): name for name in shipped}, Path(argument)
    near = [names[name] for name in get_close_matches(wanted.stem.lower(), names, n=1, cutoff=0.5)]
    folder = existing(str(wanted.parent))
    neighbours = [file.name for file in folder.glob(f"*{SUFFIX}")] if folder is not None else []
    near += get_close_matches(wanted.name, neighbours, n=1, cutoff=0.6)
    hint = f" Did you mean {' or '.join(repr(name) for name in near)}?" if near else ""
    raise UsageError(
        f"no scenario file or folder {argument!r}, and no shipped scenario with that name.{hint} "
        f"Shipped: {', '.join(shipped)}."
    )
