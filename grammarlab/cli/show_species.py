"""Species of ``grammarlab show``: their parameters and kinds, or one of their trees."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grammarlab.cli.console import print_json, print_result
from grammarlab.cli.fitted_table import print_table, print_text

if TYPE_CHECKING:
    from grammarlab.runs.sample.shipped import RuleSource


def show_species(source: RuleSource, as_json: bool, everything: bool) -> None:
    """Print a species.

    Args:
        source: its file.
        as_json: whether to print one JSON object.
        everything: whether to list parameters with their default value.
    """
    from grammarlab.runs.sample.species_overview import species_values

    values = species_values(source)
    if as_json:
        print_json(values)
        return
    print_result(source.path)
    print_text(values["about"])
    entries = [entry for entry in values["parameters"] if everything or _is_special(entry)]
    num_hidden = len(values["parameters"]) - len(entries)
    rows = [(e["name"], *_cells(e), e["unit"], e["why"] or e["meaning"]) for e in entries]
    _print("Parameters", ("Parameter", "Value", "Range", "±", "Unit", "Why"), rows)
    if num_hidden:
        print_result(f"{num_hidden} more have their default value; --all lists them")
    if len(values["kinds"]) > 1:
        kinds = [(f"{kind['weight']:.3g}", kind["means"], _ranges(kind["ranges"])) for kind in values["kinds"]]
        _print("Kinds", ("Weight", "Means", "Ranges"), kinds)
    if values["acceptance"]:
        print_text(f"acceptance: {values['acceptance']}")


def show_tree(
    argument: str, model: int, seed: int, attributes: Sequence[str], assets: Path | None, as_json: bool
) -> None:
    """Print the parameters and measures of one tree; see `grammarlab.runs.sample.species_overview.tree_values`."""
    from grammarlab.runs.sample.species_overview import tree_values
    from grammarlab.trees.measures import MEASURES
    from grammarlab.trees.parameters import DEFAULTS, PARAMETERS, SPREAD

    values = tree_values(argument, model, seed, attributes, assets)
    if as_json:
        print_json(values)
        return
    kind = f", {values['means']}" if values["means"] else ""
    stems = ", ".join(f"{number:,}" for number in values["stems"])
    print_result(
        f"{values['species']}, model {model} of seed {seed}{kind}: {stems} stems by level, {values['leaves']:,} leaves"
    )
    if values["tries"] > 1:
        print_result(f"candidate {values['tries']:,}; the acceptance rule kept none of those before")
    rows = [
        (name, f"{value:.6g}", PARAMETERS[name if name in PARAMETERS else name.removesuffix(SPREAD)].unit)
        for (name, value), default in zip(values["parameters"].items(), DEFAULTS.tolist(), strict=True)
        if value != default
    ]
    _print("Parameters", ("Parameter", "Value", "Unit"), rows)
    measures = [(name, _measured(values["measures"][name]), m.unit, m.why) for name, m in MEASURES.items()]
    _print("Measures", ("Measure", "Value", "Unit", "Meaning"), measures)


def _is_special(entry: dict[str, Any]) -> bool:
    low, high = entry["range"]
    return bool(low != high or entry["value"] != entry["default"] or any(entry.get("spread_range", ())) or entry["why"])


def _cells(entry: dict[str, Any]) -> tuple[str, str, str]:
    """Value, range and spread."""
    spread = entry.get("spread", 0.0)
    spreads = _range(entry.get("spread_range", (0.0, 0.0)))
    return f"{entry['value']:.6g}", _range(entry["range"]), spreads or (f"{spread:.6g}" if spread else "")


def _measured(value: float) -> str:
    return f"{value:.4g}" if abs(value) < 10_000 else f"{value:,.0f}"


def _range(ends: Sequence[float]) -> str:
    return "" if ends[0] == ends[1] else f"{ends[0]:.6g} to {ends[1]:.6g}"


def _ranges(ranges: dict[str, list[float]]) -> str:
    return ", ".join(f"{name} {_range(ends) or f'{ends[0]:.6g}'}" for name, ends in ranges.items())


def _print(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table in which the parameters of a species are whole, since they are copied."""
    columns = {heading: [row[number] for row in rows] for number, heading in enumerate(headings)}
    print_table(
        title, columns, {"Parameter", "Measure", "Value", "Range", "±", "Unit", "Ranges"}.intersection(headings)
    )
