"""Declarations and calls of operations and built-in functions, and the interface of the compiler of their arguments."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.state.shapes import ARRAY, Shapes, Value, kind_of, number_column, part_keys, take_value
from grammarlab.derivation.state.workspace import Code, Workspace
from grammarlab.errors import DerivationError, Location
from grammarlab.language.syntax.syntax_tree import Choice, Expression

BuiltinFunction: TypeAlias = "Callable[[FunctionCall], Value]"


class Argument(NamedTuple):
    """One argument of an operation."""

    value: Value
    """The argument evaluated for all shapes; for a keyword, the word itself."""
    keyword: bool = False
    """Whether it is a keyword of the operation, such as ``xz`` in ``center(xz)``."""
    relative: bool = False
    """Whether it was written ``'x``: a share of the scope's size."""
    floating: bool = False
    """Whether it was written ``~x``."""


class Condition(NamedTuple):
    """An expression before the colon of a part, evaluated on each component: ``top || geometry.area > 3``."""

    code: Callable[[Shapes, Workspace], Value]
    selectors: frozenset[str]
    """The selectors that it uses; their values are in `Shapes.state` under their names."""
    block: int
    """Number of the block in the rule branch, for the components' random keys."""


class Head(NamedTuple):
    """Head of one part of a block: the text before its colon."""

    argument: Argument
    joined: bool = False
    """Whether it was written with ``=``: one shape of all selected components, not one shape per component."""
    group: int = -1
    """Index of the repeated group that contains the part; -1 for none."""
    connected: bool = False
    """Whether it was written with ``=:``: one shape of each connected set of selected components."""
    condition: Condition | None = None
    """Condition for selecting a component, instead of `argument`."""
    text: str = ""
    """Text of the head, for blocks with selectors."""
    block: int = -1
    """Block of parts at random positions: the number of the block whose keys give the positions."""
    depth: Argument | None = None
    """Depth of a section of a perimeter: ``length : depth : …``."""


class BoundCall(NamedTuple):
    """An operation about to be applied to N shapes."""

    name: str
    shapes: Shapes
    arguments: tuple[Argument, ...]
    origin: Shapes
    """[N] the same shapes at the beginning of the rule, block or bracket around the operation."""
    workspace: Workspace
    location: Location
    has_index: bool = True
    """Whether anything may read the indices of its parts, if it has parts."""
    bare: tuple[bool, ...] = ()
    """Whether nothing reads the geometry of the shapes of each part, so that they need none."""

    @property
    def words(self) -> tuple[str, ...]:
        """The keywords among the arguments, in order."""
        return tuple([str(argument.value) for argument in self.arguments if argument.keyword])

    @property
    def values(self) -> tuple[Argument, ...]:
        """The arguments that are not keywords, in order."""
        return tuple([argument for argument in self.arguments if not argument.keyword])

    def rows(self, rows: NDArray[np.integer]) -> BoundCall:
        """The same operation on some of the shapes."""
        arguments = tuple([argument._replace(value=take_value(argument.value, rows)) for argument in self.arguments])
        return self._replace(shapes=self.shapes.take(rows), origin=self.origin.take(rows), arguments=arguments)

    def number(self, argument: Argument) -> float | Floats:
        """A number, the same for all or [N]; 0 and a warning for NaN and infinity.

        Raises:
            DerivationError: If it is not a number.
        """
        value = argument.value
        if type(value) is float and math.isfinite(value):
            return value
        if isinstance(value, str) or (isinstance(value, np.ndarray) and value.dtype.kind in "iu"):
            raise self.error(f"{self.name} expected a number, found a {kind_of(value)}")
        if isinstance(value, np.ndarray):
            column = value.astype(np.float64, copy=False)
            is_finite = np.isfinite(column)
            return column if is_finite.all() else self._finite(column, is_finite)
        return float(value) if np.isfinite(value) else float(self._finite(np.array([value]), np.array([False]))[0])

    def _finite(self, column: Floats, is_finite: NDArray[np.bool_]) -> Floats:
        self.warn(f"{self.name} expected a finite number, found {column[~is_finite][0]}; 0 is used")
        return np.where(is_finite, column, 0.0)

    def length(self, argument: Argument, axis: int) -> float | Floats:
        """A length in metres along a scope axis, ``'x`` resolved; the same for all or [N]."""
        number = self.number(argument)
        return number * self.shapes.size[:, axis] if argument.relative else number

    def column(self, argument: Argument) -> Floats:
        """A number as a column [N]."""
        return number_column(self.number(argument), self.shapes.num)

    def text(self, argument: Argument) -> str | NDArray[np.int32]:
        """A string, the same for all or string ids [N].

        Raises:
            DerivationError: If it is not a string.
        """
        value = argument.value
        if isinstance(value, str) or (isinstance(value, np.ndarray) and value.dtype.kind == "i"):
            return value  # type: ignore[return-value, ty:invalid-explicit-return]
        raise self.error(f"{self.name} expected a string, found a {kind_of(value)}")

    def warn(self, message: str, hint: str = "") -> None:
        """Record a warning at the place of the operation; shapes go on."""
        self.workspace.recorder.add_warning(message, self.location, hint)

    def error(self, message: str, hint: str = "") -> DerivationError:
        """An error at the place of the operation."""
        return DerivationError(message, self.location, hint)


OperationFunction: TypeAlias = Callable[[BoundCall], Shapes]


class BoundPart(NamedTuple):
    """The shapes that one part of a block is applied to."""

    shapes: Shapes
    """[K] expanded shapes; their nodes ascend."""
    number: NDArray[np.integer]
    """[K] index among all parts of the same shape, from 0: the address of the part."""


BlockFunction: TypeAlias = Callable[[BoundCall, tuple[Head, ...]], list[BoundPart]]


class FunctionCall(NamedTuple):
    """A built-in function about to be evaluated for N shapes."""

    name: str
    shapes: Shapes
    arguments: tuple[Value, ...]
    workspace: Workspace
    address: int
    """Number of the call in the text, for random functions."""
    site: int
    """Index into the sites of the forest, for random functions; -1 otherwise."""
    location: Location


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation on shapes, one in and one out."""

    apply: OperationFunction
    keywords: frozenset[str] = frozenset()
    """Keywords, which are not looked up as names."""
    num_arguments: tuple[int, int] = (0, 0)
    """Fewest and most arguments."""
    names_target: bool = False
    """Whether the first argument is the name of the changed attribute, as in ``set(height, 3)``."""


@dataclass(frozen=True, slots=True)
class BlockOperation:
    """An operation with a block: one shape in, many out."""

    divide: BlockFunction
    keywords: frozenset[str] = frozenset()
    num_arguments: tuple[int, int] = (0, 0)
    selectors: frozenset[str] = frozenset()
    """Allowed words before the colons."""


@dataclass(frozen=True, slots=True)
class Builtin:
    """A built-in function."""

    evaluate: BuiltinFunction
    num_arguments: tuple[int, int]
    random: bool = False
    takes_arrays: bool = False
    keywords: frozenset[str] = frozenset()
    """Keywords, which are not looked up as names."""


class Compiler(Protocol):
    """Compiles the expressions of one definition."""

    def expression(self, node: Expression) -> Code:
        """Code for one expression."""
        ...

    def choice(self, choice: Choice) -> Code:
        """Code for a choice whose leaves are expressions."""
        ...

    def with_selectors(self, selectors: frozenset[str]) -> Compiler:
        """A compiler for expressions in which these words are selectors of a block."""
        ...


def selected(
    call: BoundCall, condition: Condition, parts: Shapes, number: NDArray[np.integer], picked: Callable[[str], NDArray]
) -> NDArray[np.bool_]:
    """[K] whether a condition selects each component; a number selects the component with that number.

    Args:
        call: the operation with the block.
        condition: the condition.
        parts: [K] the components as shapes, still with the keys of the shapes that they are parts of.
        number: [K] the place of each among all components of its shape.
        picked: [K] the components that a selector picks.

    Raises:
        DerivationError: If the value of the condition is a string or an array.
    """
    words = {name: picked(name) for name in condition.selectors}
    key = part_keys(parts.key, condition.block, number)
    value = condition.code(parts._replace(key=key, state={**parts.state, **words}), call.workspace)
    kind = kind_of(value)
    if kind in ("string", ARRAY):
        raise call.error(f"{call.name} expects selectors, numbers or conditions before the colons, found a {kind}")
    return np.broadcast_to(value if kind == "bool" else number == np.rint(value), parts.num)
