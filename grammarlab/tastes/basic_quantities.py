"""The quantities that everything else is made of: counts of nodes, draws, and choices at places."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from scipy.sparse import csr_array

from grammarlab.arrays import MOST_COLUMNS, NUM_LEVELS, Flags, Floats
from grammarlab.derivation.forest import Forest, Site
from grammarlab.features.columns.paths import is_quantity
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Below, Draw, Formula, Pattern
from grammarlab.tastes.choice_lines import Lines
from grammarlab.tastes.choice_pairs import Pair, pairs_beside
from grammarlab.tastes.choice_places import MAX_CHOICES, Choice, Outcome, as_quantities, choices_of, summed
from grammarlab.tastes.labelled_nodes import LabelledNodes
from grammarlab.tastes.quantities import Quantities, joined
from grammarlab.tastes.roles import Roles
from grammarlab.tastes.visible_orders import Orders

Readers: TypeAlias = Mapping[str, tuple[Pattern, ...]]
_NONE: Readers = {}


@dataclass(frozen=True)
class Elements:
    """Quantities of n models that vary among them."""

    draws: Quantities
    """Random numbers."""
    used: Quantities
    """[as many] The same where a model uses them, else 0."""
    counts: Quantities
    """Counts of nodes and of outcomes of choices; branches of rules before symbols before children of symbols."""
    nodes: LabelledNodes
    """The nodes of the models; none for designs that have no parts."""
    orders: Orders = field(default_factory=dict)
    """Orders of alternatives that a person sees."""
    outcomes: tuple[Outcome, ...] = ()
    """Random choices outside rules, and those side by side together of which a model uses one."""

    @classmethod
    def of(cls, forests: Sequence[Forest], readers: Readers = _NONE, orders: Orders = MappingProxyType({})) -> Elements:
        """The quantities of models of one grammar.

        Args:
            forests: the models.
            readers: branches that use some of the draws (`grammarlab.tastes.attribute_readers`).
            orders: orders of alternatives that a person sees.

        Raises:
            UsageError: If the columns of a forest are not trees.
        """
        nodes, sites = LabelledNodes.of(forests), forests[0].sites if forests else ()
        names = dict.fromkeys(site.name for site in sites if is_quantity(site))
        draws = distinct(_counted(forests, [Draw(name) for name in names]))
        outcomes = _counted(forests, _outcomes(nodes, sites))
        counts = distinct(joined([_branches(nodes), _symbols(nodes), outcomes, _children(nodes)], nodes.num_models))
        chosen = list(islice(_chosen(forests, outcomes, readers), MAX_CHOICES))
        return cls(draws, _used(forests, draws, readers), counts, nodes, orders, (*chosen, *_exclusive(chosen)))

    @classmethod
    def of_columns(cls, columns: Mapping[str, Floats], num: int) -> Elements:
        """Designs without parts that have numbers by name.

        Args:
            columns: [num] values by name.
            num: number of designs.
        """
        values = np.stack([np.zeros(num), *columns.values()], axis=1)[:, 1:]
        nodes = LabelledNodes.of(())
        none = Quantities((), np.zeros((num, 0)))
        draws = distinct(Quantities(tuple(map(Draw, columns)), values))
        return cls(draws, draws, none, replace(nodes, num_models=num))

    @property
    def num(self) -> int:
        """Number of models."""
        return self.nodes.num_models

    @cached_property
    def numerals(self) -> Quantities:
        """Counts of three values or more: numbers of things."""
        # A count of two values only says whether there is one more.
        several = [len(np.unique(column)) > 2 for column in self.counts.values.T]
        return self.counts.take(np.flatnonzero(several))

    @cached_property
    def flags(self) -> Quantities:
        """Counts that are 0 or 1."""
        return self.counts.take(np.flatnonzero(self.counts.values.max(axis=0, initial=0.0) == 1.0))

    @cached_property
    def lines(self) -> Lines:
        """Choices of few alternatives, with the nodes above them."""
        return Lines(self.nodes, Roles.of(self.nodes))

    @cached_property
    def choices(self) -> tuple[Choice, ...]:
        """Choices at places that a model has at most once."""
        return choices_of(self.lines)

    @cached_property
    def overlaps(self) -> Flags:
        """[K, K] whether two of `choices` have a node in common."""
        rows = [choice.line.rows for choice in self.choices]
        pointers = np.cumsum([0, *map(len, rows)])
        nodes = np.concatenate([np.zeros(0, dtype=np.int64), *rows])
        shape = len(rows), len(self.nodes.label)
        has = csr_array((np.ones(len(nodes), dtype=np.int64), nodes, pointers), shape=shape)
        return (has @ has.T).toarray() > 0

    @cached_property
    def beside(self) -> tuple[tuple[Pair, Pair | None], ...]:
        """Comparable choices of parts side by side, and with another part between if there are such."""
        return tuple(pairs_beside(self.lines))

    def orders_of(self, sequence: Sequence[Choice]) -> Sequence[tuple[int, ...]]:
        """Numbers of the alternatives of comparable choices in each of the orders that a person sees.

        Each order has all numbers: some choices of a sequence may have more alternatives than others.
        """
        every = range(1, 1 + max(choice.num_alternatives for choice in sequence))
        orders = (order for choice in sequence for order in self._orders_of(choice))
        return tuple(dict.fromkeys(order for order in orders if sorted(order) == list(every)))

    def _orders_of(self, choice: Choice) -> Iterator[tuple[int, ...]]:
        rules = self.nodes.labels.rules
        numbers = {
            (rules[label].symbol, rules[label].branch): number
            for number, labels in enumerate(choice.line.labels, 1)
            for label in labels
        }
        for symbol in dict.fromkeys(symbol for symbol, _ in numbers):
            for order in self.orders.get(symbol, ()):
                yield tuple(numbers[symbol, branch] for branch in order if (symbol, branch) in numbers)

    @cached_property
    def numbers(self) -> Quantities:
        """Numbers of the alternatives of `choices`."""
        return as_quantities(self.choices, self.num)


def _chosen(forests: Sequence[Forest], outcomes: Quantities, readers: Readers) -> Iterator[Outcome]:
    """Choices outside rules, in all models, and in those that have a branch that uses them."""
    draws = [draw for draw in outcomes.formulas if isinstance(draw, Draw)]
    for site in dict.fromkeys(draw.site for draw in draws):
        columns = [index for index, draw in enumerate(draws) if draw.site == site]
        values = outcomes.values[:, columns]
        if len(columns) > NUM_LEVELS or not len(values) or (values.sum(axis=1) > 1.0).any():
            continue
        uses, formulas = _uses(forests, readers.get(site, ())), [draws[column] for column in columns]
        number = (values @ np.arange(1, len(columns) + 1)).astype(np.int64)
        yield Outcome(number, tuple(formulas))
        if uses is not None:
            seen = (Formula.of("and", Formula.of(">", uses[0], 0.0), draw) for draw in formulas)
            yield Outcome(np.where(uses[1], number, 0), tuple(seen))


def _exclusive(outcomes: Sequence[Outcome]) -> Iterator[Outcome]:
    """Choices declared side by side of which no model uses two, such as the colour of each material, as one choice."""
    run: list[Outcome] = []
    # What all models have is no part of a choice.
    for outcome in (*(outcome for outcome in outcomes if outcome.number.min() == 0), None):
        if outcome is not None and not any(((outcome.number > 0) & (other.number > 0)).any() for other in run):
            run.append(outcome)
            continue
        if len(run) > 1:
            before = np.cumsum([0, *(other.num_alternatives for other in run[:-1])]).tolist()
            number = sum((one.number > 0) * (one.number + more) for one, more in zip(run, before, strict=True))
            yield Outcome(np.asarray(number), tuple(each for other in run for each in other.alternatives))
        run = [] if outcome is None else [outcome]


def _uses(forests: Sequence[Forest], patterns: Sequence[Pattern]) -> tuple[Pattern | Formula, Flags] | None:
    """How often some branches are taken, and [n] whether at all; None if all models have one, or none has."""
    uses = summed(patterns)
    if uses is None:
        return None
    has = np.concatenate([count(forest, patterns).sum(axis=1) for forest in forests]) > 0.0
    return (uses, has) if has.any() and not has.all() else None


def _used(forests: Sequence[Forest], draws: Quantities, readers: Readers) -> Quantities:
    """Draws times whether a model has a branch that uses them."""
    formulas, columns = list(draws.formulas), [*draws.values.T]
    for index, draw in enumerate(draws.formulas):
        uses = _uses(forests, readers.get(draw.site, ()) if isinstance(draw, Draw) else ())
        if uses is not None:
            formulas[index] = Formula.of("*", Formula.of(">", uses[0], 0.0), draw)
            columns[index] = columns[index] * uses[1]
    return Quantities(tuple(formulas), np.stack([np.zeros(len(draws.values)), *columns], axis=1)[:, 1:])


def _branches(nodes: LabelledNodes) -> Quantities:
    """Counts of the branches of rules."""
    counts, used = nodes.count(nodes.model, nodes.label, nodes.labels.unknown + 1), nodes.alternatives[:MOST_COLUMNS]
    return Quantities(tuple(map(nodes.pattern, used)), counts[:, list(used)])


def _symbols(nodes: LabelledNodes) -> Quantities:
    """Counts of the nodes of each symbol."""
    names = nodes.labels.symbols[:MOST_COLUMNS]
    inside = nodes.symbol < len(names)
    return Quantities(tuple(map(Pattern, names)), nodes.count(nodes.model[inside], nodes.symbol[inside], len(names)))


def _children(nodes: LabelledNodes) -> Quantities:
    """Counts of the nodes of a symbol that are children of another symbol."""
    names, inner = nodes.labels.symbols, np.flatnonzero(nodes.parent >= 0)
    codes = nodes.symbol[nodes.parent[inner]] * len(names) + nodes.symbol[inner]
    kinds, index = np.unique(codes, return_inverse=True)
    inside = np.flatnonzero(index < MOST_COLUMNS)
    counts = nodes.count(nodes.model[inner[inside]], index[inside], min(len(kinds), MOST_COLUMNS))
    edges = [divmod(kind, len(names)) for kind in kinds[:MOST_COLUMNS].tolist()]
    return Quantities(tuple(Pattern(names[a], below=(Below((Pattern(names[b]),)),)) for a, b in edges), counts)


def _outcomes(nodes: LabelledNodes, sites: Sequence[Site]) -> list[Draw]:
    """Outcomes of random choices outside rules, such as those of attributes."""
    symbols = set(nodes.labels.symbols)
    choices = {
        site.name: max(site.choices, 2) for site in sites if not is_quantity(site) and site.definition not in symbols
    }
    return [Draw(name, branch) for name, number in choices.items() for branch in range(number)]


def _counted(forests: Sequence[Forest], features: Sequence[Draw]) -> Quantities:
    values = np.concatenate([np.zeros((0, len(features))), *(count(forest, features) for forest in forests)])
    return Quantities(tuple(features), values)


def distinct(quantities: Quantities) -> Quantities:
    """The quantities that vary, without those equal to an earlier one."""
    first: dict[bytes, int] = {}
    for index, column in enumerate(quantities.values.T):
        if len(column) and np.ptp(column) > 0.0:
            first.setdefault(column.tobytes(), index)
    return quantities.take(np.array(list(first.values()), dtype=np.int64))
