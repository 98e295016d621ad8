"""The scenario files that grammarlab ships, and what a SCENARIOS argument means."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

from grammarlab.about import PACKAGE
from grammarlab.errors import UsageError
from grammarlab.evaluation.scenario import SUFFIX

FIGURES = "figures"
"""The folder beside the scenarios that holds named experiments (`evaluate_figures`)."""


TASTES = "tastes"
"""The folder beside the scenarios whose folders hold further ones, of many kinds: to tune a learner and to test it."""


def scenarios_folder() -> Path:
    """Where the shipped scenarios lie: inside an installed package, or beside it in a checkout."""
    inside = PACKAGE / "scenarios"
    return inside if inside.is_dir() else PACKAGE.parent / "scenarios"


def shipped_scenarios() -> dict[str, Path]:
    """The shipped scenario files by name, without those of the tastes."""
    return {file.stem: file for file in sorted(scenarios_folder().glob(f"*{SUFFIX}"))}


def named_scenarios() -> dict[str, Path]:
    """All shipped scenario files that have a name of their own, those of the tastes included."""
    tastes = sorted((scenarios_folder() / TASTES).glob(f"*/*{SUFFIX}"))
    return shipped_scenarios() | {file.stem: file for file in tastes}


def find_scenario(argument: str) -> Path:
    """The one scenario file that a SCENARIO argument means: a file, or a shipped name.

    Raises:
        UsageError: when there is none of that name, or there are several.
    """
    found = find_scenarios(argument)
    if len(found) != 1:
        raise UsageError(f"expected one scenario, found {len(found)} in {argument!r}.")
    return found[0]


def find_scenarios(argument: str) -> tuple[Path, ...]:
    """The scenario files that a SCENARIOS argument means: a file, all files of a folder, a shipped name, or several.

    Args:
        argument: what the user typed; commas between several.

    Raises:
        UsageError: when there is nothing of that name; names the nearest.
    """
    path = Path(argument)
    if path.is_file():
        return (path,)
    if path.is_dir():
        found = tuple(sorted(path.glob(f"*{SUFFIX}")))
        if not found:
            raise UsageError(f"the folder {argument!r} holds no scenario: no file that ends in {SUFFIX}.")
        return found
    shipped = named_scenarios()
    if argument in shipped:
        return (shipped[argument],)
    if "," in argument:
        return tuple(path for part in argument.split(",") for path in find_scenarios(part))
    names = {name.lower(): name for name in shipped}
    wanted = path.stem.lower()
    near = [names[name] for name in get_close_matches(wanted, names, n=1, cutoff=0.5)]
    neighbours = [p.name for p in path.parent.glob(f"*{SUFFIX}")] if path.parent.is_dir() else []
    near += get_close_matches(path.name, neighbours, n=1, cutoff=0.6)
    hint = f" Did you mean {' or '.join(repr(name) for name in near)}?" if near else ""
    raise UsageError(
        f"no scenario file or folder {argument!r}, and no shipped scenario of that name.{hint} "
        f"Shipped: {', '.join(shipped)}."
    )
