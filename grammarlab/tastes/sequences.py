"""Productions about choices at several places: made alike, by turns, mirrored, of how many kinds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial, reduce
from itertools import combinations, permutations
from typing import Any

import numpy as np

from grammarlab.arrays import MANY, MANY_COLUMNS, MOST_COLUMNS, Ints
from grammarlab.features.patterns.operations import SEQUENCE_RELATIONS
from grammarlab.features.patterns.pattern import Atom, Formula
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.choice_places import Choice, are_short, as_quantities
from grammarlab.tastes.quantities import Block, Later, Quantities, Recipe, as_block, blocks


def choices(elements: Elements) -> Iterator[Block]:
    """The number of the alternative at a place."""
    return as_block(elements.numbers)


def equal_choices(elements: Elements) -> Iterator[Block]:
    """Two comparable choices are made alike."""
    kinds = [choice.line.kind for choice in elements.choices]
    pairs = [pair for pair in combinations(range(len(kinds)), 2) if kinds[pair[0]] == kinds[pair[1]]]
    apart = [pair for pair in pairs if not elements.overlaps[pair] and _are_short(elements, pair)]
    indices = np.array(apart[:MOST_COLUMNS], dtype=np.int64).reshape(-1, 2)
    return blocks(lambda do, a, b: do("equal", a, b), [elements.numbers] * 2, indices)


def relations(elements: Elements) -> Iterator[Block]:
    """Relations of three or more comparable choices in their order."""
    for group in _by_length(sequences_of(elements)):
        for name in SEQUENCE_RELATIONS:
            yield from blocks(_applying(name), [elements.numbers] * group.shape[1], group)


def likenesses(elements: Elements) -> Iterator[Block]:
    """How many of the other parts of a sequence are like one that is not its first."""
    for group in _by_length(sequences_of(elements)):
        leaders = [
            (leader, *(other for other in sequence if other != leader))
            for sequence in group.tolist()
            for leader in sequence[1:]
        ]
        yield from blocks(_applying("like_first"), [elements.numbers] * group.shape[1], np.array(leaders))


def halves(elements: Elements) -> Iterator[Block]:
    """How much more often an alternative is chosen in the first half of a sequence than in the second."""
    for sequence in sequences_of(elements):
        members = [elements.choices[index] for index in sequence]
        number = np.stack([choice.number for choice in members], axis=1)
        # Each alternative is named once for its part, and once more where it is the one that counts.
        for one in np.unique(number[number > 0]).tolist() if _are_short(elements, (*sequence, *sequence)) else ():
            formulas = Later([partial(_once_more, choice, one) for choice in members])
            parts = Quantities(formulas, (number > 0) + (number == one).astype(np.float64))
            yield from blocks(_applying("balance"), [parts] * len(members), np.arange(len(members))[None])


def gradations(elements: Elements) -> Iterator[Block]:
    """Comparable choices never fall, or never rise, in the order of the text or in one that a person sees."""
    for sequence in sequences_of(elements):
        members = [elements.choices[index] for index in sequence]
        listed = [elements.numbers.take(np.array(sequence))] + [
            as_quantities([replace(choice, order=order) for choice in members], elements.num)
            for order in elements.orders_of(members)
        ]
        forward = np.arange(len(sequence))[None]
        for number, ranks in enumerate(listed):
            for indices in (forward, forward[:, ::-1])[number == 0 :]:
                yield from blocks(_applying("ascending"), [ranks] * len(sequence), indices)


def positions(elements: Elements) -> Iterator[Block]:
    """The position of the first part of a sequence that has an alternative."""
    for sequence in sequences_of(elements):
        for flags in _alternatives(elements, sequence):
            yield from blocks(_applying("which"), [flags] * len(flags), np.arange(len(flags))[None])


def orders(elements: Elements) -> Iterator[Block]:
    """A part with one alternative is somewhere after a part with another one."""
    for sequence in sequences_of(elements):
        most = max(elements.choices[index].num_alternatives for index in sequence)
        for first, second in permutations(range(1, most + 1), 2):
            yield from blocks(_followed(first, second), [elements.numbers] * len(sequence), np.array([sequence]))


def matching_sequences(elements: Elements) -> Iterator[Block]:
    """In how many places two sequences of one length and kind are alike, and whether in all."""
    sequences = sequences_of(elements)
    kinds = [elements.choices[sequence[0]].line.kind for sequence in sequences]
    pairs = [(i, j) for i, j in combinations(range(len(kinds)), 2) if kinds[i] == kinds[j]]
    same = [(sequences[i], sequences[j]) for i, j in pairs if len(sequences[i]) == len(sequences[j])]
    for first, second in same[:MANY_COLUMNS]:
        if not elements.overlaps[np.ix_(first, second)].any() and _are_short(elements, first + second):
            for reordered in dict.fromkeys((second, second[::-1])):
                indices = np.array([[*first, *reordered]])
                for recipe in (_alike(len(first)), _all_alike(len(first))):
                    yield from blocks(recipe, [elements.numbers] * indices.shape[1], indices)


def sequences_of(elements: Elements) -> list[tuple[int, ...]]:
    """Indices of comparable choices in the order of the rules, three or more, none of them a case of another.

    What is said about all of them is short enough to be read back.
    They have the same line of symbols (a symbol that calls itself counts once), or the same node at the top and the
    same symbol or role at the end, or only this. What is said about all of them is short enough to be read back.
    """
    choices, shared = elements.choices, elements.lines.roles.shared
    groups: dict[object, list[int]] = {}
    for index, choice in enumerate(choices):
        kind, chain = choice.line.kind, choice.line.chain
        shortened = tuple(symbol for symbol, above in zip(chain, (object(), *chain), strict=False) if symbol != above)
        last = "" if kind in shared else chain[-1]
        for key in ((kind, shortened), (kind, last, chain[0], len(chain)), (kind, last)):
            groups.setdefault(key, []).append(index)
    sequences: dict[tuple[int, ...], None] = {}
    for group in groups.values():
        members = sorted(_apart(choices, group), key=lambda index: (choices[index].way, index))
        present = sum(((choices[index].number > 0).astype(np.int64) for index in members), np.zeros(elements.num, int))
        is_sequence = 3 <= len(members) <= MANY and present.max(initial=0) > 1
        if is_sequence and _are_short(elements, members):
            sequences.setdefault(tuple(members))
    return list(sequences)[:MANY_COLUMNS]


def _alternatives(elements: Elements, sequence: Sequence[int]) -> list[Quantities]:
    """For each alternative of a sequence, whether its parts have it: those that can, two or more."""
    members = [elements.choices[index] for index in sequence]
    listed: list[Quantities] = []
    for number in range(1, 1 + max(choice.num_alternatives for choice in members)):
        flags = {
            formula: (choice.number == number).astype(np.float64)
            for choice in members
            for formula in choice.alternatives[number - 1 : number]
            if formula is not None
        }
        if len(flags) > 1:
            listed.append(Quantities(tuple(flags), np.stack(list(flags.values()), axis=1)))
    return listed


def _once_more(choice: Choice, number: int) -> Formula | Atom:
    """2 for one of the alternatives of a choice, 1 for each other one, 0 without the choice."""
    named = [*choice.alternatives, *choice.alternatives[number - 1 : number]]
    counts = [count for count in named if count is not None]
    return reduce(partial(Formula.of, "+"), counts[1:], counts[0])


def _are_short(elements: Elements, indices: Sequence[int]) -> bool:
    return are_short([elements.choices[index].line for index in indices])


def _apart(choices: Sequence[Choice], group: Sequence[int]) -> list[int]:
    """Choices without those of nodes that an earlier one has."""
    used, indices = set[int](), list[int]()
    for index in group:
        rows = choices[index].line.rows.tolist()
        if used.isdisjoint(rows):
            used.update(rows)
            indices.append(index)
    return indices


def _by_length(sequences: Sequence[tuple[int, ...]]) -> Iterator[Ints]:
    for length in sorted({len(sequence) for sequence in sequences}):
        yield np.array([sequence for sequence in sequences if len(sequence) == length])


def _applying(name: str) -> Recipe:
    return lambda do, *parts: do(name, *parts)


def _followed(first: int, second: int) -> Recipe:
    return lambda do, *parts: do("followed", float(first), float(second), *parts)


def _alike(length: int) -> Recipe:
    def recipe(do: Any, *parts: Any) -> Any:
        total = do("equal", parts[0], parts[length])
        for first, second in zip(parts[1:length], parts[length + 1 :], strict=True):
            total = do("+", total, do("equal", first, second))
        return total

    return recipe


def _all_alike(length: int) -> Recipe:
    """All places that both sequences have, at least two."""

    def recipe(do: Any, *parts: Any) -> Any:
        both = [do("*", first, second) for first, second in zip(parts[:length], parts[length:], strict=True)]
        number = do("!=", both[0], 0.0)
        for other in both[1:]:
            number = do("+", number, do("!=", other, 0.0))
        return do("and", do(">", number, 1.0), do("==", _alike(length)(do, *parts), number))

    return recipe
