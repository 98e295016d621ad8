"""Typed values of the tables of a TOML file, with a finding for every mistake."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeVar

from grammarlab.errors import Finding, LanguageError, Location, TomlError, shown
from grammarlab.toml_text import toml_table
from grammarlab.trees.species_places import Path as Keys
from grammarlab.trees.species_places import Places

_MOST_FINDINGS = 50
"""Findings that are kept; later ones are dropped."""
_MOST_CHARACTERS = 20_000
"""Largest number of characters of a text."""
_Choice = TypeVar("_Choice", bound=str)


class PlanTables:
    """Reader of one file. A value with a mistake is replaced by its default, and `findings` has the mistake.

    Args:
        text: the whole file.
        file: its name, for messages.

    Raises:
        LanguageError: If it is not TOML.
    """

    def __init__(self, text: str, file: str) -> None:
        self._text = text
        self._places = Places(text, file)
        self.findings: list[Finding] = []
        try:
            self.root: Mapping[str, Any] = toml_table(text)
        except TomlError as error:
            place = Location(error.line or 1, error.column or 1, 1, file)
            raise LanguageError((Finding("error", "syntax", error.message, place),), text) from None

    def raise_findings(self) -> None:
        """Raise the findings, if there are any, as a `LanguageError`."""
        if self.findings:
            ordered = sorted(self.findings, key=lambda finding: finding.location)
            raise LanguageError(tuple(ordered), self._text)

    def report(self, code: str, message: str, keys: Keys, hint: str = "", *, at_key: bool = False) -> None:
        """Add an error about a value, or about its key."""
        place = self._places.of_key(keys) if at_key else self._places.of_value(keys)
        if len(self.findings) < _MOST_FINDINGS:
            self.findings.append(Finding("error", code, message, place, hint))

    def value(self, keys: Keys) -> Any:
        """The value at some keys; None if it is missing."""
        value: Any = self.root
        for key in keys:
            has_key = key in value if isinstance(value, Mapping) else _is_index(value, key)
            if not has_key:
                return None
            value = value[key]
        return value

    def table(self, keys: Keys, allowed: Collection[str] | None) -> Mapping[str, Any]:
        """A table, empty if it is missing.

        Args:
            keys: its keys.
            allowed: allowed keys in it; None for all.
        """
        value = self.value(keys)
        if value is None:
            return {}
        if not isinstance(value, Mapping):
            self.report("wrong-type", f"expected a table for {_name(keys)}, found {shown(value)}", keys)
            return {}
        for key in value:
            if allowed is not None and key not in allowed:
                message = f"unknown key {shown(key)}" + (f" in {_name(keys)}" if keys else "")
                self.report("unknown-name", message, (*keys, key), nearest(key, allowed), at_key=True)
        return value

    def tables(self, key: str, most: int) -> int:
        """Number of the tables of a list of tables."""
        value = self.value((key,))
        if value is None:
            return 0
        if not isinstance(value, list):
            self.report("wrong-type", f"expected tables under [[{key}]], found {shown(value)}", (key,))
            return 0
        if len(value) > most:
            self.report("too-many", f"expected at most {most} tables [[{key}]], found {len(value)}", (key,))
        return min(len(value), most)

    def text(self, keys: Keys, default: str = "", *, required: bool = False) -> str:
        """A text; a required one is not empty."""
        value = self.value(keys)
        if value is None and not required:
            return default
        if not isinstance(value, str) or (required and not value.strip()):
            expected = f'{keys[-1]} = "…", a text'
            self.report("wrong-type", f"expected {expected}, found {shown(value)}", keys)
            return default
        if len(value) > _MOST_CHARACTERS or "\0" in value:
            self.report("wrong-text", f"expected a text of at most {_MOST_CHARACTERS:,} printable characters", keys)
            return default
        return value

    def choice(self, keys: Keys, allowed: Sequence[_Choice]) -> _Choice | None:
        """One of several words; None if it is missing or another one."""
        value = self.value(keys)
        for word in allowed:
            if word == value:
                return word
        if value is not None:
            words = " or ".join(f'"{word}"' for word in allowed)
            self.report("wrong-value", f"expected {keys[-1]} = {words}, found {shown(value)}", keys)
        return None

    def number(self, keys: Keys, default: float, low: float, high: float) -> float:
        """A number from ``low`` to ``high``."""
        value = self.value(keys)
        return default if value is None else self._number(value, keys, low, high, default)

    def optional_number(self, keys: Keys, low: float, high: float) -> float | None:
        """A number from ``low`` to ``high``; None if it is missing."""
        return None if self.value(keys) is None else self.number(keys, low, low, high)

    def numbers(
        self, keys: Keys, default: tuple[float, ...], low: float, high: float, most: int | None = None
    ) -> tuple[float, ...]:
        """A list of numbers from ``low`` to ``high``: as many as in the default, or at most ``most`` of them."""
        value = self.value(keys)
        if value is None:
            return default
        lengths = range(1, most + 1) if most else (len(default),)
        if not isinstance(value, list) or len(value) not in lengths:
            count = f"1 to {most}" if most else str(len(default))
            example = ", ".join(f"{number:g}" for number in default)
            message = f"expected {keys[-1]} = [{example}], {count} numbers, found {shown(value)}"
            self.report("wrong-type", message, keys)
            return default
        return tuple(self._number(item, keys, low, high, low) for item in value)

    def integer(self, keys: Keys, default: int, low: int, high: int) -> int:
        """A whole number from ``low`` to ``high``."""
        value = self.value(keys)
        if value is None:
            return default
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            self.report("wrong-value", f"expected a whole number from {low} to {high}, found {shown(value)}", keys)
            return default
        return value

    def _number(self, value: object, keys: Keys, low: float, high: float, default: float) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            self.report("wrong-type", f"expected a number for {keys[-1]}, found {shown(value)}", keys)
            return default
        if not low <= value <= high:
            self.report("out-of-range", f"expected {keys[-1]} from {low:g} to {high:g}, found {value:g}", keys)
            return default
        return float(value)


def nearest(name: str, names: Collection[str]) -> str:
    """Advice about an unknown name.

    >>> nearest("zone", ["zones", "streets"])
    'did you mean zones?'
    """
    near = get_close_matches(name, names, n=1, cutoff=0.6)
    return f"did you mean {near[0]}?" if near else f"expected one of {', '.join(names)}"


def _is_index(value: object, key: str | int) -> bool:
    return isinstance(value, list) and isinstance(key, int) and key < len(value)


def _name(keys: Keys) -> str:
    return "[" + ".".join(str(key) for key in keys if isinstance(key, str)) + "]"
