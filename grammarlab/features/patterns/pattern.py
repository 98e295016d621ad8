"""Tree patterns: countable properties of derivation trees.

Paths, symbol counts, skip-bigrams, adjacent siblings and subtrees are all patterns; they differ in shape only. A model
is described by the count of each pattern in its tree. The count is the number of embeddings: the mappings of the
pattern's nodes to nodes of the tree.

``str`` gives the text form, which `grammarlab.features.patterns.pattern_text` reads.

>>> str(Pattern("Tower", below=(Below((Pattern("Block", branch=(1,)),), child=2),)))
'Tower > Block@2:1'
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Pattern:
    """A node of the tree with conditions on its descendants."""

    symbol: str | None = None
    """The symbol that the node must have; None for any."""
    parameters: int | None = None
    """Number of parameters that its rule must have; None for any."""
    branch: tuple[int, ...] | None = None
    """Required beginning of the branch that rewrote it (`RuleName.branch`); None for any node, rewritten or leaf. The
    empty tuple requires a node that some rule rewrote."""
    below: tuple[Below, ...] = ()
    """Conditions; their counts are multiplied."""

    def __str__(self) -> str:
        return _text(self, None)


@dataclass(frozen=True, slots=True)
class Below:
    """A run of adjacent siblings below a node; the counts of its occurrences are added.

    Siblings are ordered by ``child``, then by ``repeat``.
    """

    run: tuple[Pattern, ...]
    """At least one; each next one matches the next sibling."""
    child: int | None = None
    """``child`` of the first node of the run; None for any."""
    deep: bool = False
    """Whether the run may be anywhere below the node, not only directly."""

    def __str__(self) -> str:
        return (">> " if self.deep else "") + self.run_text()

    def run_text(self) -> str:
        """Text of the siblings only."""
        return " + ".join(_text(node, None if i else self.child) for i, node in enumerate(self.run))


def _text(pattern: Pattern, child: int | None) -> str:
    text = pattern.symbol or "*"
    if pattern.parameters is not None:
        text += f"/{pattern.parameters}"
    if child is not None:
        text += f"@{child}"
    if pattern.branch is not None:
        text += ":" + (".".join(map(str, pattern.branch)) or "*")
    if len(pattern.below) == 1 and len(pattern.below[0].run) == 1:
        below = pattern.below[0]
        return f"{text} {'>>' if below.deep else '>'} {below.run_text()}"
    return text + (f"[{', '.join(map(str, pattern.below))}]" if pattern.below else "")


@dataclass(frozen=True, slots=True)
class Threshold:
    """Number of draws of one random expression below a bound."""

    site: str
    """The random expression, by its `Site.name`: the attribute's name for an attribute."""
    bound: float

    def __str__(self) -> str:
        return f"{self.site} < {self.bound:.6g}"


@dataclass(frozen=True, slots=True)
class Draw:
    """Mean of the draws of one random expression in a model; 0 without draws.

    For a choice, the value is the number of times that ``branch`` was taken.
    """

    site: str
    branch: int | None = None

    def __str__(self) -> str:
        return self.site if self.branch is None else f"{self.site}:{self.branch}"


@dataclass(frozen=True, slots=True)
class Present:
    """1 if a pattern occurs in a model, otherwise 0: for patterns that geometry repeats, such as windows."""

    feature: Pattern | Draw

    def __str__(self) -> str:
        return f"{self.feature} present"


Atom: TypeAlias = Pattern | Threshold | Draw
"""Features that are no function of others: what expressions read."""


@dataclass(frozen=True, slots=True)
class ConstantTerm:
    """A number."""

    value: float
    """Value of the constant, finite."""


@dataclass(frozen=True, slots=True)
class Measure:
    """A feature of the model."""

    feature: Atom


@dataclass(frozen=True, slots=True)
class Apply:
    """An operation on the results of earlier steps."""

    operation: str
    """One of `grammarlab.features.patterns.operations.OPERATIONS`."""
    operands: tuple[int, ...]
    """Numbers of earlier steps."""


Step: TypeAlias = ConstantTerm | Measure | Apply
ZERO = ConstantTerm(0.0)
"""The number 0 in a formula."""


@dataclass(frozen=True, slots=True)
class Formula:
    """A function of other features, as in an expression (`grammarlab.features.expression`).

    Formulas are equal if their steps are. ``str`` is an expression that is parsed as an equal formula.

    >>> print(Formula.of("equal", Pattern("A", branch=(0,)), Pattern("B", branch=(0,))))
    equal({A:0}, {B:0})
    """

    steps: tuple[Step, ...] = field(repr=False)
    """Steps in the order in which the text mentions them first, each once; the last one is the result."""

    @classmethod
    def of(cls, operation: str, *operands: Formula | Atom | float) -> Formula:
        """An operation on features or numbers, not all of them numbers."""
        numbers: dict[Step, int] = {}
        results = [_included(operand, numbers) for operand in operands]
        return cls((*numbers, Apply(operation, tuple(results))))

    @classmethod
    def of_steps(cls, steps: Sequence[Step]) -> Formula:
        """A formula of the steps, in any order of computation, that the last one depends on."""
        waiting, numbers = [(len(steps) - 1, False)], dict[int, int]()
        while waiting:
            index, is_ready = waiting.pop()
            step = steps[index]
            if index in numbers:
                continue
            if isinstance(step, Apply) and not is_ready:
                waiting += [(index, True), *((operand, False) for operand in reversed(step.operands))]
            else:
                numbers[index] = len(numbers)
        return cls(tuple(_moved(steps[index], numbers) for index in numbers))

    @property
    def features(self) -> tuple[Atom, ...]:
        """Features that the formula reads, each once."""
        return tuple(dict.fromkeys(step.feature for step in self.steps if isinstance(step, Measure)))

    def __str__(self) -> str:
        texts: list[str] = []
        for step in self.steps:
            texts.append(step_text(step, self.steps, texts))
        text = texts[-1]
        return text[1:-1] if isinstance(self.steps[-1], Apply) and text.startswith("(") else text


def _included(operand: Formula | Atom | float, numbers: dict[Step, int]) -> int:
    """Number of the result of an operand, whose steps are added to others."""
    if not isinstance(operand, Formula):
        step = Measure(operand) if isinstance(operand, Atom) else ConstantTerm(float(operand))
        return numbers.setdefault(step, len(numbers))
    if not numbers:  # the first operand keeps its numbers
        numbers.update((step, index) for index, step in enumerate(operand.steps))
        return len(numbers) - 1
    moved: dict[int, int] = {}
    for index, step in enumerate(operand.steps):
        moved[index] = numbers.setdefault(_moved(step, moved), len(numbers))
    return moved[len(operand.steps) - 1]


def _moved(step: Step, numbers: Mapping[int, int]) -> Step:
    """A step whose operands have other numbers."""
    return Apply(step.operation, tuple(numbers[i] for i in step.operands)) if isinstance(step, Apply) else step


def step_text(step: Step, steps: tuple[Step, ...], texts: Sequence[str]) -> str:
    """Text of a step in an expression, from the texts of the steps before it."""
    if isinstance(step, ConstantTerm):
        return f"({_number(step.value)})" if step.value < 0.0 else _number(step.value)
    if isinstance(step, Apply):
        return _application(step, steps, [texts[index] for index in step.operands])
    if isinstance(step.feature, Threshold):
        return f"(${step.feature.site} < {_number(step.feature.bound)})"
    return f"{{{step.feature}}}" if isinstance(step.feature, Pattern) else f"${step.feature}"


def _application(step: Apply, steps: tuple[Step, ...], operands: Sequence[str]) -> str:
    if step.operation == "not":
        return f"(not {operands[0]})"
    if step.operation.isidentifier() and step.operation not in {"and", "or"}:
        return f"{step.operation}({', '.join(operands)})"
    first, second = (steps[index] for index in step.operands)
    # A comparison of a draw with a number is read as "its threshold > 0".
    is_threshold = isinstance(first, Measure) and isinstance(first.feature, Threshold)
    if step.operation == ">" and second == ZERO and is_threshold:
        return operands[0]
    return f"({operands[0]} {step.operation} {operands[1]})"


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")


Feature: TypeAlias = Pattern | Threshold | Draw | Present | Formula
