"""What a person decides about a city: pins of parcels, and the grammars of zones in its plan."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import tomlkit
from tomlkit.exceptions import TOMLKitError

from grammarlab.city.parcel_addresses import EXCLUDED, Pin, Pins, read_pins, save_pins
from grammarlab.city.plan import Plan, parse_plan
from grammarlab.errors import AssetError, UsageError
from grammarlab.files import read_bounded, rewrite_text

CITY = "city.json"
"""File in the folder of a city that names its plan."""
MAX_PLAN_BYTES = 1 << 20
"""Largest size of a plan in bytes."""


@dataclass(frozen=True, slots=True)
class Choices:
    """The pins of a city, and the text of its plan."""

    pins: Pins
    plan: str
    """TOML; empty for a city whose plan is unknown."""


def read_choices(plan: Path) -> tuple[Choices, Plan]:
    """The choices about the city of a plan, and the plan.

    Raises:
        UsageError: If there is no plan.
        LanguageError: If it has mistakes.
        AssetError: If the pins cannot be read.
    """
    try:
        text = read_bounded(plan, MAX_PLAN_BYTES).decode("utf-8")
    except (OSError, AssetError, UnicodeDecodeError) as error:
        raise UsageError(f"the plan of the city cannot be read: {error}") from error
    parsed = parse_plan(text, plan)
    return Choices(read_pins(parsed.pins), text), parsed


def plan_of(folder: Path) -> Path | None:
    """The plan that a city was built from; None if it is not known, or not on this machine."""
    try:
        path = Path(json.loads(read_bounded(folder / CITY, MAX_PLAN_BYTES))["plan"])
        return path if path.is_file() else None
    except (OSError, AssetError, ValueError, LookupError, TypeError, RecursionError):
        return None


def save_choices(path: Path, pins: Path, before: Choices, after: Choices) -> None:
    """Write what has changed, each file atomically.

    Args:
        path: file of the plan.
        pins: file of the pins.
        before: what the files have.
        after: what they get.

    Raises:
        UsageError: If the plan has changed elsewhere.
    """
    if after.plan != before.plan:
        if path.read_bytes().decode("utf-8") != before.plan:
            raise UsageError(f"{path}: the plan has changed on disk; open the city again to go on.")
        parse_plan(after.plan, path)
        rewrite_text(path, after.plan)
    if after.pins.rows != before.pins.rows:
        save_pins(after.pins, pins)


def changed_parcels(before: Choices, after: Choices) -> frozenset[str]:
    """Ids of the parcels with another pin."""
    changed = {*before.pins.rows} ^ {*after.pins.rows}
    return frozenset(pin.id for pin in changed)


def changed_zones(before: Plan, after: Plan) -> frozenset[str]:
    """Names of the zones with another grammar."""
    grammars = {zone.name: zone.grammar for zone in before.zones}
    return frozenset(zone.name for zone in after.zones if grammars.get(zone.name) != zone.grammar)


def with_grammar(plan: str, zone: str, grammar: str) -> str:
    r"""The text of a plan with another grammar for a zone; all else, comments included, stays.

    Raises:
        UsageError: If the plan has no such zone.

    >>> print(with_grammar('[[zones]]  # old town\nname = "a"\ngrammar = "building"\n', "a", "a-learned.cga"))
    [[zones]]  # old town
    name = "a"
    grammar = "a-learned.cga"
    <BLANKLINE>
    """
    try:
        document = tomlkit.parse(plan)
        found = [table for table in document["zones"] if table["name"] == zone]
        found[0]["grammar"] = grammar
        return tomlkit.dumps(document)
    except (TOMLKitError, LookupError, TypeError) as error:
        raise UsageError(f"the plan has no zone {zone!r} whose grammar can be replaced.") from error


def state_of(pin: Pin) -> str:
    """What a pin does with the building of its parcel, in one word."""
    if pin.zone == EXCLUDED:
        return "excluded"
    if pin.model is not None or pin.seed is not None:
        return "pinned"
    return "rerolled" if pin.reroll else "free"
