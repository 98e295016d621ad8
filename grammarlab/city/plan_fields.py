"""Fields of parcels for the conditions and formulas of plans, in natural units, and their values by expressions.

Names are those of the map's columns, with ``_`` for characters that a name cannot have, and these, which win over
columns of the same name: ``area`` in m², ``aspect`` >= 1 of the smallest box, ``frontage`` in metres along streets,
``street_width`` of the widest street in metres, ``elevation`` in metres, and the fields of the plan.

The language is that of scenarios (`grammarlab.features.expression`), and texts may be compared with ``==`` and ``!=``:
``use == 'shop' and area > 200``. A missing number fails every comparison but ``!=``; a missing text is empty.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats
from grammarlab.city.plan_tables import nearest
from grammarlab.errors import UsageError, shown
from grammarlab.features.expression import RESERVED, Expression
from grammarlab.features.patterns.operations import FUNCTIONS

FieldColumn: TypeAlias = "Floats | NDArray[np.bool_] | NDArray[np.object_]"
"""[N] numbers with NaN for none, flags, or texts."""
_NAME = re.compile(r"[^\W\d]\w*")
_WORD = r"[^\W\d]\w*"
_TEXT = r"""(?:"[^"\n]*"|'[^'\n]*')"""
_COMPARISON = re.compile(rf"(?<![\w.])(?:({_WORD})\s*(==|!=)\s*({_TEXT})|({_TEXT})\s*(==|!=)\s*({_WORD})(?!\w))")


@dataclass(frozen=True, eq=False)
class PlanFields:
    """Fields of N parcels."""

    table: pa.Table
    """[N] columns of the map."""
    numbers: Mapping[str, Floats]
    """[N] other fields by name, NaN where unknown."""

    @cached_property
    def columns(self) -> Mapping[str, str]:
        """Columns of the map by the names of their fields."""
        return {field_name(column): column for column in self.table.column_names}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all fields."""
        return tuple(dict.fromkeys((*self.numbers, *self.columns)))

    def column(self, name: str) -> FieldColumn:
        """The values of a field as the map has them.

        Raises:
            UsageError: If there is no such field, or it has other values.
        """
        if name in self.numbers:
            return self.numbers[name]
        if name not in self.columns:
            raise UsageError(f"unknown field {shown(name)}; {nearest(name, self.names) if self.names else 'no fields'}")
        column = self.table.column(self.columns[name])
        kind = column.type.value_type if pa.types.is_dictionary(column.type) else column.type
        if pa.types.is_boolean(kind) and not column.null_count:
            return column.to_numpy(zero_copy_only=False).astype(np.bool_)
        if (
            pa.types.is_boolean(kind)
            or pa.types.is_integer(kind)
            or pa.types.is_floating(kind)
            or pa.types.is_decimal(kind)
        ):
            return pc.cast(column, pa.float64(), safe=False).to_numpy(zero_copy_only=False).astype(np.float64)
        try:
            return pc.fill_null(pc.cast(column, pa.string()), "").to_numpy(zero_copy_only=False).astype(object)
        except pa.ArrowException as error:
            raise UsageError(f"field {shown(name)}: expected numbers, flags or texts, found {kind}") from error

    def as_numbers(self, name: str) -> Floats:
        """[N] a field as numbers, NaN where there is none; texts that are numbers count as such.

        Raises:
            UsageError: If there is no such field, or none of its texts is a number.
        """
        column = self.column(name)
        if column.dtype != np.object_:
            return column.astype(np.float64)
        numbers = np.array([_number(text) for text in column.tolist()], np.float64)
        if len(numbers) and np.isnan(numbers).all() and (column != "").any():
            example = next(text for text in column.tolist() if text)
            raise UsageError(f"field {shown(name)} has texts such as {shown(example)}; compare it: {name} == 'text'")
        return numbers

    def equal(self, name: str, value: float | bool | str) -> Flags:
        """[N] whether a field has a value.

        Raises:
            UsageError: If there is no such field.
        """
        column = self.column(name)
        if column.dtype == np.object_:
            text = value if isinstance(value, str) else str(value).lower() if isinstance(value, bool) else None
            if text is not None:
                return np.asarray(column == text, dtype=np.bool_)
            return np.array([_number(cell) for cell in column.tolist()], np.float64) == float(value)
        number = _number(value) if isinstance(value, str) else float(value)
        return column.astype(np.float64) == number

    def holds(self, text: str) -> Flags:
        """[N] whether a condition holds.

        Raises:
            UsageError: If it is not an expression, or a field is unknown.
        """
        values, _ = self._evaluate(text)
        return (values != 0.0) & ~np.isnan(values)

    def formula(self, text: str) -> tuple[FieldColumn, Flags]:
        """[N] values of an expression or of one field, and whether there is a value.

        A formula without a number that it reads has no value, unless it decides by ``choose`` what happens then.

        Raises:
            UsageError: If it is not an expression, or a field is unknown.
        """
        if _NAME.fullmatch(text) and (text in self.numbers or text in self.columns):
            column = self.column(text)
            if column.dtype == np.object_:
                return column, np.asarray(column != "", dtype=np.bool_)
            return column, ~np.isnan(column) if column.dtype == np.float64 else np.ones(len(column), np.bool_)
        values, is_complete = self._evaluate(text)
        return values, is_complete | ("choose" in _NAME.findall(text))

    def _evaluate(self, text: str) -> tuple[Floats, Flags]:
        """[N] values of an expression, and whether all numbers that it reads are known."""
        plain, comparisons = _without_texts(text)
        names = [name for name in dict.fromkeys(_NAME.findall(plain)) if name not in RESERVED]
        used = [name for name in names if name in comparisons or name in self.numbers or name in self.columns]
        definitions = {name: Expression.parse(f"{{F{index}}}") for index, name in enumerate(used)}
        others = {name: Expression.parse("0") for name in self.names if name not in definitions}
        expression = Expression.parse(plain, {**definitions, **others})
        name_of = {definition.features[0]: name for name, definition in definitions.items()}
        columns = np.zeros((self.table.num_rows, len(expression.features)))
        for index, feature in enumerate(expression.features):
            if feature not in name_of:
                raise UsageError(f"expected names of fields, found {feature}")
            columns[:, index] = self._read(name_of[feature], comparisons)
        is_complete = np.logical_not(np.isnan(columns).any(axis=1))
        return expression.evaluate(columns), np.asarray(is_complete, np.bool_)

    def _read(self, name: str, comparisons: Mapping[str, tuple[str, str, str]]) -> Floats:
        """[N] numbers of a field, or 1 where it compares to a text."""
        if name not in comparisons:
            return self.as_numbers(name)
        field, sign, text = comparisons[name]
        is_equal = self.equal(field, text)
        return (is_equal if sign == "==" else ~is_equal).astype(np.float64)


def field_name(column: str) -> str:
    """Name of the field of a column.

    >>> field_name("Land use"), field_name("2020"), field_name("max")
    ('Land_use', '_2020', 'max_')
    """
    name = re.sub(r"\W", "_", column)
    name = name if _NAME.fullmatch(name) else f"_{name}"
    return f"{name}_" if name in RESERVED or name in FUNCTIONS else name


def check_condition(text: str) -> None:
    """Check that a text is an expression, whatever fields there are.

    Raises:
        UsageError: If it is not; with its place.
    """
    plain, _ = _without_texts(text)
    names = set(_NAME.findall(plain)) - RESERVED
    Expression.parse(plain, {name: Expression.parse("0") for name in names})


def _without_texts(text: str) -> tuple[str, Mapping[str, tuple[str, str, str]]]:
    """An expression with names instead of comparisons with texts, and field, sign and text by these names."""
    comparisons: dict[str, tuple[str, str, str]] = {}

    def name_of(match: re.Match[str]) -> str:
        field, sign, quoted = (match[1], match[2], match[3]) if match[1] else (match[6], match[5], match[4])
        name = f"__text_{len(comparisons)}"
        comparisons[name] = (field, sign, quoted[1:-1])
        return name

    return _COMPARISON.sub(name_of, text), comparisons


def _number(text: object) -> float:
    """A text as a number; NaN if it is not one."""
    try:
        return float(str(text).strip().replace(",", "."))
    except ValueError:
        return np.nan
