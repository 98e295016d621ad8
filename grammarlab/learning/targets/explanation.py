"""A learned preference in words: a few kinds of designs that are liked, and a few that are not.

The predictions of a pool become a small regression tree, whose leaves are kinds of designs that differ in a few parts
or choices. If parts add up, a tree would repeat itself in all its branches; then each part is described with its
points.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import MANY, ROUNDING, SEVERAL, Floats, Ints
from grammarlab.features.columns.column_names import BESIDE, threshold_words
from grammarlab.features.columns.formula_names import (
    COMBINATION,
    MAX_LENGTH,
    MOST_NAMED,
    ONE_OF,
    RELATION,
    formula_words,
    is_statement,
)
from grammarlab.features.patterns.pattern import (
    ZERO,
    Apply,
    Draw,
    Feature,
    Formula,
    Measure,
    Pattern,
    Present,
    Step,
    Threshold,
)
from grammarlab.language.dimensions import DEGREES
from grammarlab.language.display_names import DisplayNames
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.contrasts import choice_of
from grammarlab.learning.designs.design_tables import DesignTable
from grammarlab.learning.targets.divergence import agreement
from grammarlab.learning.targets.statements import (
    IS,
    IS_NOT,
    OF_THESE,
    Statement,
    all_of,
    all_shown,
    any_of,
    counted_thing,
    quantity,
    shown,
    whole_numbers,
)
from grammarlab.preference.base import LIKED_SHARE, MAX_SCORE, NEGLIGIBLE_SHARE, SCORE_STEP
from grammarlab.preference.regression_tree import Split, grow, leaves_of, means_of

MAX_PARTS = 6
"""Largest number of parts on each side."""
_MAX_UNEXPLAINED = 0.1
"""Share that words may leave out: of the divergence between the grammar and the learned density by a tree, and of the
highest score by kinds that are not liked."""
_MAX_BESIDE_SUM = 0.05
"""Largest share of the variance of scores that a sum of parts does not explain, for a description as a sum."""
_MIN_POINTS = 3.0
"""Smallest number of points of a described part, and by which kinds differ."""
_MAX_RARITY = 400
"""Smallest share of designs of a kind: one in 400."""
_NO_CHOICE = re.compile(r"^(any|number of) | then ")
"""What names of choices of one symbol do not have."""
_STATEMENT_STARTS, _STATEMENT_ENDS = (
    ("all ", "no ", "not ", "same choice"),
    (" alike", " alternate", " mirrored", " never fall", " by turns"),
)
"""Beginnings and ends of names of columns that are statements, not things."""
_NUMBER_OF = "number of "
"""What names of columns begin with that count a part."""
_KINDS_OF = "number of kinds of "
"""What names of columns begin with that count which alternatives of a part occur."""
_THESE = "these: "
"""What names of columns without the number begin with that count things of which each is there or not."""
_ALL_OF = ("and", "*", "/")
"""Operations of things that are there or not, which hold if all of them are there."""
_NUMBER = re.compile(r" \(\d+\)$")
"""What tells names of columns apart that would be equal."""
_WITH = " with "
"""What connects two choices that go together."""
_DENIALS = (re.compile(r"^(no|not|none|at most) | does not hold$| never$"), re.compile(r" ≠ "))
"""What conditions have that say what is missing."""


@dataclass(frozen=True, slots=True)
class ContrastWords:
    """A choice that matters to a person, to be shown as two designs that differ in it alone."""

    text: str
    """The choice, such as ``Crown = Mast``."""
    feature: Feature
    """How often it is taken."""
    without: float
    """Mean score of designs without it, 0 to 100."""
    having: float
    """Mean score of designs with it, 0 to 100."""
    examples: tuple[Address, ...]
    """Some designs of the space itself that have it, the most liked ones first."""


@dataclass(frozen=True, slots=True)
class Words:
    """Liked and disliked kinds of designs."""

    likes: tuple[str, ...]
    """Liked kinds, best first: ``Crown = Mast, Ground = Podium (82)`` is a kind of designs with its mean score,
    ``Crown = Mast (+20)`` a part with the points that it adds."""
    dislikes: tuple[str, ...]
    """Disliked kinds, most frequent first."""
    knowledge: tuple[str, ...] = ()
    """What is not known yet, see `grammarlab.learning.targets.unknown_part`."""
    contrasts: tuple[ContrastWords, ...] = ()
    """Choices of which the kinds speak, the most important ones first."""
    voices: tuple[str, ...] = ()
    """Those sentences of ``knowledge`` that say that the scores are not of one taste."""

    @property
    def lines(self) -> tuple[str, ...]:
        """What is not known yet, and a sentence for each side that is not empty."""
        sides = (("Likes", self.likes), ("Does not like", self.dislikes))
        return (*self.knowledge, *(f"{side}: {'; '.join(kinds)}." for side, kinds in sides if kinds))


@dataclass(frozen=True, slots=True)
class _Range:
    """Range of a kind of designs in one column."""

    column: int
    low: float
    """Lower bound, included; minus infinity for none."""
    high: float
    """Upper bound, excluded; infinity for none."""


def words_of(
    table: DesignTable,
    scores: Floats,
    weights: Floats,
    addresses: Sequence[Address] = (),
    display: DisplayNames | None = None,
) -> Words:
    """Description of predictions.

    Args:
        table: table of the designs.
        scores: [m] predicted for the first m designs of the table, 0 to 100.
        weights: [m] >= 0, importance weight of each design.
        addresses: [m] addresses of the designs; without them, contrasts have no examples.
        display: words of people for the identifiers of the grammar; None for the identifiers themselves.
    """
    rows = table.values(len(scores))
    if not (weights * scores).any() or np.ptp(scores) == 0.0:
        return Words((), ())
    names = _ColumnWords(table, rows, display or DisplayNames({}, {}, {}))
    tree = _small_tree(rows, scores, weights, names)
    words = _parts(tree, rows, scores, weights, names) or _kinds(tree, rows, scores, weights, names)
    if not (words.likes or words.dislikes):
        return words
    return replace(words, contrasts=tuple(_contrasts(tree, rows, scores, weights, names, addresses)))


def _small_tree(rows: Floats, scores: Floats, weights: Floats, names: _ColumnWords) -> tuple[Split, ...]:
    """Smallest tree that explains most of the predictions; of equally good ones, that by choices and draws only."""
    total = agreement(scores, np.ones(len(scores)), weights).js
    near: list[tuple[int, float, tuple[Split, ...]]] = []
    nearest: tuple[float, tuple[Split, ...]] = (np.inf, ())
    is_place = np.array([" › " in name for name in names.table.names], dtype=bool)
    every = np.ones(len(is_place), dtype=bool)
    for is_candidate, is_last in ((names.simple & ~is_place, False), (~is_place, False), (every, True)):
        if near and is_last:
            break  # what is said of places inside others is harder to read than one more condition
        columns = names.order[is_candidate[names.order]]
        tree = grow(rows, scores, weights, columns, SEVERAL, len(rows) // _MAX_RARITY)
        for size in range(1, min(len(tree), near[0][0] if near else len(tree)) + 1):
            leaf = leaves_of(tree[:size], rows)
            unexplained = agreement(scores, means_of(leaf, size + 1, scores, weights)[leaf], weights).js
            nearest = min(nearest, (unexplained, tree[:size]))
            if unexplained <= _MAX_UNEXPLAINED * total:
                near.append((size, unexplained, tree[:size]))
                break
    if not near:
        return nearest[1]
    first, last = near[0], near[-1]
    return last[2] if (last[0], last[1] + NEGLIGIBLE_SHARE * total) < first[:2] else first[2]


def _parts(tree: Sequence[Split], rows: Floats, scores: Floats, weights: Floats, names: _ColumnWords) -> Words | None:
    """The parts that a tree tests, with the points each adds; None if a sum does not explain the scores."""
    tests = list(dict.fromkeys((split.column, split.bound) for split in tree))
    if len(tests) < 2 or len({column for column, _ in tests}) < len(tests):
        return None
    has = np.column_stack([np.ones(len(rows)), *(rows[:, column] >= bound for column, bound in tests)])
    roots = np.sqrt(weights)[:, None]
    added = np.linalg.lstsq(has * roots, scores * roots[:, 0], rcond=None)[0]
    mean = weights @ scores / weights.sum()
    residual_share = weights @ (scores - has @ added) ** 2 / max(float(weights @ (scores - mean) ** 2), ROUNDING)
    # A conjunction is not a sum: its parts add up to a negative score if all of them are missing.
    if residual_share > _MAX_BESIDE_SUM or np.abs(added).max() > MAX_SCORE:
        return None
    ranked = sorted(zip(tests, added[1:].tolist(), strict=True), key=lambda item: -abs(item[1]))
    sides: tuple[list[str], list[str]] = ([], [])
    parts = [
        _Part(column, bound, points, (int(names.table.groups[column]), bound))
        for (column, bound), points in ranked
        if abs(points) >= _MIN_POINTS
    ]
    while parts:
        first = parts[0]
        # Alternatives of a choice that add the same are one part.
        alike = [
            part for part in parts if part.choice == first.choice and abs(part.points - first.points) <= _MIN_POINTS
        ]
        alike = alike if first.bound <= 1.0 else [first]
        condition = any_of([names.condition(_Range(part.column, part.bound, np.inf)) for part in alike])
        text = shown(condition, names.display)
        points = float(np.mean([part.points for part in alike]))
        parts = [part for part in parts if part not in alike]
        if not parts and not any(sides):
            has_any = np.any([rows[:, part.column] >= part.bound for part in alike], axis=0)
            mean, rest = (float(np.average(scores[each], weights=weights[each])) for each in (has_any, ~has_any))
            alone = (f"{text} ({mean:.0f}; others {rest:.0f})",)
            return Words(alone, ()) if mean > rest else Words((), alone)
        sides[points < 0.0].append(f"{text} ({points:+.0f})")
    return Words(tuple(sides[0][:MAX_PARTS]), tuple(sides[1][:MAX_PARTS]))


class _Part(NamedTuple):
    """A part that adds points: designs with at least so much of a column."""

    column: int
    bound: float
    points: float
    choice: tuple[int, float]
    """Group of the column, and the bound: equal for alternatives of a choice."""


def _kinds(tree: Sequence[Split], rows: Floats, scores: Floats, weights: Floats, names: _ColumnWords) -> Words:
    """The most frequent liked leaves, and the most frequent others."""
    leaf = leaves_of(tree, rows)
    means = means_of(leaf, len(tree) + 1, scores, weights)
    if means.max() < SCORE_STEP:
        return Words((), ())
    mass = np.bincount(leaf, weights, len(tree) + 1).tolist()
    kinds = _merged([_Kind(*each) for each in zip(_ranges(tree), mass, means.tolist(), strict=True) if each[1] > 0.0])
    best = max(kind.mean for kind in kinds)

    def text(some: Sequence[_Kind]) -> tuple[str, ...]:
        return tuple(f"{names.text(kind.ranges)} ({kind.mean:.0f})" for kind in some)

    likes = [kind for kind in kinds if kind.mean >= LIKED_SHARE * best and 0 < len(kind.ranges) <= SEVERAL]
    likes = sorted(likes, key=lambda kind: -kind.mass * kind.mean)[:MOST_NAMED]
    likes.sort(key=lambda kind: -kind.mean)
    dislikes = [kind for kind in kinds if kind.mean < _MAX_UNEXPLAINED * best and 0 < len(kind.ranges) <= MOST_NAMED]
    dislikes = sorted(dislikes, key=lambda kind: -kind.mass)[:MOST_NAMED]
    are_all = len(likes) + len(dislikes) == len(kinds)
    if not are_all or min(len(likes), len(dislikes)) != 1 or np.ptp([kind.mean for kind in likes]) > _MIN_POINTS:
        return Words(text(likes), text(dislikes))
    # All other designs are those of the other side, which would say the same again.
    is_like = len(dislikes) > 1 or (len(likes) == 1 and _is_told(*(names.kind(k.ranges) for k in (*likes, *dislikes))))
    (kind,), others = (likes, dislikes) if is_like else (dislikes, likes)
    rest = np.average([other.mean for other in others], weights=[other.mass for other in others])
    alone = (f"{names.text(kind.ranges)} ({kind.mean:.0f}; others {rest:.0f})",)
    return Words(alone, ()) if is_like else Words((), alone)


class _Kind(NamedTuple):
    """A kind of designs."""

    ranges: dict[int, _Range]
    """Its range of each column, without columns of which everything is in it."""
    mass: float
    mean: float
    """Mean score."""


def _merged(kinds: list[_Kind]) -> list[_Kind]:
    """Kinds, those as one that a single condition distinguishes and whose mean scores hardly differ."""
    for (first, one), (second, other) in combinations(enumerate(kinds), 2):
        ranges = _union(one.ranges, other.ranges)
        if ranges is not None and abs(one.mean - other.mean) <= _MIN_POINTS:
            mass = one.mass + other.mass
            merged = _Kind(ranges, mass, (one.mass * one.mean + other.mass * other.mean) / mass)
            return _merged([*kinds[:first], merged, *kinds[first + 1 : second], *kinds[second + 1 :]])
    return kinds


def _union(ranges: dict[int, _Range], others: dict[int, _Range]) -> dict[int, _Range] | None:
    """Ranges of the designs in either of two kinds; None if more than one condition distinguishes these."""
    columns = [column for column in ranges.keys() | others.keys() if ranges.get(column) != others.get(column)]
    if len(columns) != 1 or ranges.keys() != others.keys():
        return None
    (column,) = columns
    first, second = sorted((ranges[column], others[column]), key=lambda each: each.low)
    if first.high != second.low:
        return None
    union = replace(first, high=second.high)
    rest = {each: interval for each, interval in ranges.items() if each != column}
    return rest if np.isinf(union.low) and np.isinf(union.high) else {**ranges, column: union}


def _is_told(kind: Sequence[Statement], other: Sequence[Statement]) -> bool:
    """Whether a kind is described rather than all others: not if only the others say what there is."""
    texts = (", ".join(each.text for each in statements) for statements in (kind, other))
    denials, other_denials = (sum(bool(denial.search(text)) for denial in _DENIALS) for text in texts)
    return denials <= other_denials


def _contrasts(
    tree: Sequence[Split],
    rows: Floats,
    scores: Floats,
    weights: Floats,
    names: _ColumnWords,
    addresses: Sequence[Address],
) -> Iterator[ContrastWords]:
    """The choices that a tree tests and that change the mean score; a tree begins with the test that explains most."""
    table = names.table
    columns = [column for column in dict.fromkeys(split.column for split in tree) if choice_of(table.features[column])]
    for column in columns[:MOST_NAMED]:
        has = rows[:, column] > ROUNDING
        if not (weights[has].any() and weights[~has].any()):
            continue
        without, having = (float(np.average(scores[part], weights=weights[part])) for part in (~has, has))
        best_first = sorted(np.flatnonzero(has[: len(addresses)]).tolist(), key=lambda row: -scores[row])
        examples = [addresses[row] for row in best_first if not addresses[row].flat][:MANY]
        text = " = ".join(table.names[column].removeprefix("number of ").rsplit(" → ", 1))
        yield ContrastWords(names.display.text(text), table.features[column], without, having, tuple(examples))


def _ranges(tree: Sequence[Split]) -> list[dict[int, _Range]]:
    """Ranges of the designs of each leaf, by column."""
    leaves: list[dict[int, _Range]] = [{}]
    for split in tree:
        ranges = leaves[split.leaf]
        before = ranges.get(split.column, _Range(split.column, -np.inf, np.inf))
        leaves.append({**ranges, split.column: _Range(split.column, max(before.low, split.bound), before.high)})
        leaves[split.leaf] = {**ranges, split.column: _Range(split.column, before.low, min(before.high, split.bound))}
    return leaves


class _ColumnWords:
    """Words for conditions on columns."""

    def __init__(self, table: DesignTable, rows: Floats, display: DisplayNames) -> None:
        self.table = table
        self.display = display
        self._rows = rows
        self.is_integer = ~table.continuous
        if table.logarithmic is not None:
            self.is_integer |= table.logarithmic & (np.abs(rows - np.rint(rows)) <= ROUNDING * rows).all(axis=0)
        self.lowest, self.highest = rows.min(axis=0), rows.max(axis=0)

    @property
    def order(self) -> Ints:
        """Columns, the described one of equivalent ones first.

        Choices are first, then what rules make, what is there or not, and short names.
        """
        names, is_chosen = self.table.names, self.simple | self._made_by_choice
        length = np.array([len(name.removeprefix(_NUMBER_OF)) for name in names], dtype=np.int64)
        is_count = self.is_integer & (self.highest > 1.0)
        return np.lexsort((np.arange(len(names)), length, is_count, self._is_leaf, ~is_chosen)).astype(np.int64)

    @property
    def simple(self) -> NDArray[np.bool_]:
        """[F] whether columns are random choices of one symbol, or draws."""
        labels = self.table.labels
        choices = [
            " → " in name
            and " › " not in name
            and (labels is None or (choice := choice_of(feature)) is None or choice.symbol in labels.drawn)
            for name, feature in zip(self.table.names, self.table.features, strict=True)
        ]
        return np.array(choices, dtype=bool) | ~self.is_integer

    @property
    def _is_leaf(self) -> NDArray[np.bool_]:
        """[F] whether columns count symbols that no rule rewrites: what a rule stands for says more than its parts."""
        ruled = set() if self.table.labels is None else {rule.symbol for rule in self.table.labels.rules}
        are_leaves = [
            isinstance(f, Pattern) and f == Pattern(f.symbol) and f.symbol not in ruled for f in self.table.features
        ]
        return np.array(are_leaves, dtype=bool)

    @property
    def _made_by_choice(self) -> NDArray[np.bool_]:
        """[F] whether columns count symbols that are alternatives of random choices."""
        symbols = set() if self.table.labels is None else set(self.table.labels.exchangeable)
        are_made = [
            isinstance(f, Pattern) and f == Pattern(f.symbol) and f.symbol in symbols for f in self.table.features
        ]
        return np.array(are_made, dtype=bool)

    def text(self, ranges: dict[int, _Range]) -> str:
        """A kind of designs in the words of people."""
        return all_shown(self.kind(ranges), self.display)

    def kind(self, ranges: dict[int, _Range]) -> list[Statement]:
        """All conditions on a kind of designs, without implied ones."""
        groups = self.table.groups
        chosen = {
            int(groups[column]) for column, interval in ranges.items() if self._is_choice(column) and interval.low > 0.0
        }
        conditions = [
            interval
            for column, interval in ranges.items()
            if not (self._is_choice(column) and interval.low <= 0.0 and int(groups[column]) in chosen)
        ]
        # Present properties are more informative than missing ones.
        present = [interval for interval in conditions if interval.low > 0.0]
        missing = [interval for interval in conditions if interval.low <= 0.0]
        affirmed, denied = list(map(self.condition, present)), list[Statement]()
        for group in dict.fromkeys(int(groups[interval.column]) for interval in missing):
            same = [interval for interval in missing if groups[interval.column] == group]
            rest = self._rest_of_choice([interval.column for interval in same])
            if rest is None:
                denied += map(self.condition, same)
            else:
                affirmed.append(rest)
        return [*affirmed, *denied]

    def _rest_of_choice(self, excluded: Sequence[int]) -> Statement | None:
        """The alternatives of a choice that are left, if they are not more than the others; None for anything else."""
        names, groups = self.table.names, self.table.groups
        place = names[excluded[0]].rpartition(" → ")[0]
        alternatives = np.flatnonzero(groups == groups[excluded[0]]).tolist()
        is_one = place and all(names[column].rpartition(" → ")[0] == place for column in alternatives)
        rest = [column for column in alternatives if column not in excluded]
        if not is_one or not rest or len(rest) > len(excluded):
            return None
        if not all(map(self._is_choice, alternatives)) or (self._rows[:, alternatives].sum(axis=1) != 1.0).any():
            return None
        return any_of([self.condition(_Range(column, 0.5, np.inf)) for column in rest])

    def condition(self, interval: _Range) -> Statement:
        """One condition."""
        column, name = interval.column, self.table.names[interval.column]
        if statement := self._alternatives(interval) or self._every_summand(interval):
            return statement
        if compared := self._comparison(interval) or self._of_product(interval):
            return Statement(compared)
        return (
            self._choice(interval)
            if self._is_choice(column)
            else self._amount(name, self.table.features[column], interval)
        )

    def _alternatives(self, interval: _Range) -> Statement | None:
        """Which alternatives a range of their numbers leaves, or excludes; None for other conditions."""
        feature = self.table.features[interval.column]
        if not isinstance(feature, Formula):
            return None
        *_, choice = feature.steps
        if not isinstance(choice, Apply) or choice.operation != "which":
            return None
        operands = [feature.steps[index] for index in choice.operands]
        numbers: dict[Feature, int] = {}
        for number, operand in enumerate(operands, 1):
            if isinstance(operand, Measure):
                numbers.setdefault(operand.feature, number)
            elif operand != ZERO:
                return None
        if not self._are_exclusive(list(numbers)):
            return None
        has_none = self.lowest[interval.column] < 1.0 and interval.low <= 0.0 < interval.high
        # Where none of them is possible, only the others are denied.
        parts = [
            self._thing_said(alternative, not has_none)
            for alternative, number in numbers.items()
            if (interval.low <= number < interval.high) != has_none
        ]
        statements = [part for part in parts if part is not None]
        if not statements or len(statements) < len(parts):
            return None
        return all_of(statements) if has_none and len(statements) > 1 else any_of(statements)

    def _are_exclusive(self, features: Sequence[Feature]) -> bool:
        """Whether features are alternatives of one choice at one place, of which no design has two."""
        columns = [self.table.features.index(each) for each in features if each in self.table.features]
        places = {self.table.words.place(each) if isinstance(each, Pattern) else "" for each in features}
        is_one_choice = len(places) == 1 and len({int(self.table.groups[column]) for column in columns}) == 1
        if len(columns) < len(features) or not is_one_choice:
            return False
        return bool(((self._rows[:, columns] > 0.0).sum(axis=1) <= 1).all())

    def _every_summand(self, interval: _Range) -> Statement | None:
        """That all things are there of which a sum counts how many are, or not all; None for other conditions."""
        feature = self.table.features[interval.column]
        if (
            not isinstance(feature, Formula)
            or not isinstance(last := feature.steps[-1], Apply)
            or last.operation != "+"
        ):
            return None
        operands = [feature.steps[index] for index in last.operands]
        read = [step.feature for step in feature.steps if isinstance(step, Measure)]
        least = len(operands) - 1.0
        are_all, is_one_missing = interval.low > least, interval.low <= 0.0 and least < interval.high <= least + 1.0
        if not (are_all or is_one_missing) or not all(map(self._is_property, read)):
            return None
        is_named = [
            isinstance(step, Measure) or (isinstance(step, Apply) and step.operation == "not") for step in operands
        ]
        parts = [self._said(operand, feature, are_all) for operand in operands]
        statements = [part for part in parts if part is not None]
        if not all(is_named) or len(statements) < len(parts) or len(read) < len(parts):
            return None
        return all_of(statements) if are_all else any_of(statements)

    def _comparison(self, interval: _Range) -> str:
        """What a bound near 0 on a difference says: ``a below b``; empty for other conditions."""
        column, feature = interval.column, self.table.features[interval.column]
        spread = self.highest[column] - self.lowest[column]
        bounds = [bound for bound in (interval.low, interval.high) if np.isfinite(bound)]
        if not isinstance(feature, Formula) or len(bounds) != 1 or abs(bounds[0]) >= NEGLIGIBLE_SHARE * spread:
            return ""
        *terms, difference = feature.steps
        if not isinstance(difference, Apply) or difference.operation != "-" or self.is_integer[column]:
            return ""
        compared = Apply(">=" if np.isfinite(interval.low) else "<", difference.operands)
        text = formula_words(Formula((*terms, compared)), self.table.words)
        return f"{text} holds" if text.startswith(RELATION) else text

    def _of_product(self, interval: _Range) -> str:
        """What a number of things says that only counts beside properties; empty for other conditions."""
        feature = self.table.features[interval.column]
        if not isinstance(feature, Formula) or interval.low <= 0.0 or self._is_choice(interval.column):
            return ""
        factors = list(_factors(feature, feature.steps[-1]))
        numbers = [factor for factor in factors if factor is not None and not self._is_property(factor)]
        parts = [self._thing_said(factor, True) for factor in factors if factor is not None and factor not in numbers]
        properties = [part.text for part in parts if part is not None]
        if len(numbers) != 1 or len(properties) != len(factors) - 1 or not properties:
            return ""
        return ", ".join([*properties, self._amount(self.table.words[numbers[0]], numbers[0], interval).text])

    def _is_property(self, feature: Feature) -> bool:
        """Whether designs have something or not: a column of 0 and 1, as of what no design draws several times."""
        return feature in self.table.features and self._is_choice(self.table.features.index(feature))

    def _is_choice(self, column: int) -> bool:
        """Whether a column is a property that designs have or not: its values are 0 and 1."""
        return bool(self.is_integer[column]) and self.lowest[column] == 0.0 and self.highest[column] == 1.0

    def _choice(self, interval: _Range) -> Statement:
        """Whether designs have a property."""
        name, feature = self.table.names[interval.column], self.table.features[interval.column]
        before, arrow, after = name.removeprefix("any ").rpartition(" → ")
        # Of 0 or 1 kinds of a part there is 1 where the part is.
        has, thing = interval.low > 0.0, name.removeprefix(_KINDS_OF).removeprefix(_NUMBER_OF).removeprefix("any ")
        if thing.startswith(_THESE):
            thing = f"{ONE_OF}{thing.removeprefix(_THESE)}"
        if thing.startswith(ONE_OF):
            return Statement(thing if has else f"none{thing.removeprefix('one')}")
        if thing.startswith(RELATION):
            return Statement(f"{thing} {'holds' if has else 'does not hold'}")
        if thing.startswith(COMBINATION):
            return Statement(f"{thing}: {'1' if has else 'none'}")
        of_things = self._said(feature.steps[-1], feature, has) if isinstance(feature, Formula) else None
        if of_things and _WITH not in name:
            return of_things
        if BESIDE in thing:
            return Statement(thing if has else thing.replace(BESIDE, f" not{BESIDE}"))
        bare = _NUMBER.sub("", thing)
        is_sentence = bare.startswith(_STATEMENT_STARTS) or bare.endswith(_STATEMENT_ENDS)
        is_sentence |= _WITH in bare and all(" = " in choice for choice in bare.split(_WITH))
        if isinstance(feature, Formula) and (arrow or (is_statement(feature) and not is_sentence)):
            return Statement(name if has else f"not ({name})")
        if arrow:
            return Statement.of_choice(before, IS if has else IS_NOT, after)
        return Statement(thing if has else f"{'not' if is_sentence else 'no'} {thing}")

    def _said(self, step: Step, formula: Formula, holds: bool) -> Statement | None:
        """What a step of a formula of things that are there or not says if it holds, or if not; None for anything else.

        In a statement, a sum of numbers of things is above 0 if any of them is there, a product or a quotient if all
        are: a quotient of nothing is 0.
        """
        if isinstance(step, Measure):
            return self._thing_said(step.feature, holds)
        if not isinstance(step, Apply):
            return None
        operands = [formula.steps[index] for index in step.operands]
        if step.operation == "not" or (step.operation == ">" and operands[1] == ZERO):
            return self._said(operands[0], formula, holds if step.operation == ">" else not holds)
        if step.operation in (*_ALL_OF, "or", "+"):
            sign = "and" if (step.operation in _ALL_OF) == holds else "or"
            parts = [self._said(operand, formula, holds) for operand in operands]
            statements = [part for part in parts if part]
            if len(statements) < len(parts):
                return None
            joined = any_of(statements) if sign == "or" else all_of(statements)
            return joined if len(joined.text) <= MAX_LENGTH else None
        if step.operation in ("==", "!="):
            return self._equality(operands, holds == (step.operation == "=="))
        return None

    def _equality(self, operands: Sequence[Step], are_equal: bool) -> Statement | None:
        """Whether both or neither of two properties are there; None for anything else."""
        features = [operand.feature for operand in operands if isinstance(operand, Measure)]
        columns = [self.table.features.index(feature) for feature in features if feature in self.table.features]
        things = [thing for feature in features if (thing := self._thing_said(feature, True))]
        absent = [thing for feature in features if (thing := self._thing_said(feature, False))]
        if len(columns) != 2 or not all(map(self._is_choice, columns)) or len(things) < 2:
            return None
        if (self._rows[:, columns] > 0.0).all(axis=1).any():
            first, second = (thing.text for thing in things)
            text = f"both or neither of {first} and {second}" if are_equal else f"{first} or {second} but not both"
            return Statement(text, "but")
        return all_of(absent) if are_equal else any_of(things)

    def _thing_said(self, feature: Feature, holds: bool) -> Statement | None:
        """That something is there, or is not; None for what is no part, choice or bound of a draw."""
        if isinstance(feature, Threshold):
            return Statement(threshold_words(feature, holds))
        if isinstance(feature, Draw) and feature.branch is not None:
            return self._choice_said(feature, feature.site, str(feature.branch), holds)
        name = self.table.words[feature]
        if not isinstance(feature, Pattern | Present) or BESIDE in name or _WITH in name or _NO_CHOICE.search(name[4:]):
            return None
        thing = name.removeprefix(_NUMBER_OF).removeprefix("any ")
        place, arrow, value = thing.rpartition(" → ")
        if not arrow:
            return Statement(thing if holds else f"no {thing}")
        return self._choice_said(feature, place, value, holds)

    def _choice_said(self, feature: Feature, place: str, value: str, holds: bool) -> Statement:
        """That something is chosen, or is not: ``never`` where it can be chosen several times."""
        if holds or self._is_property(feature):
            return Statement.of_choice(place, IS if holds else IS_NOT, value)
        return Statement(f"{place} = {value} never")

    def _amount(self, name: str, feature: Feature, interval: _Range) -> Statement:
        """How much of something designs have.

        Args:
            name: name of the feature.
            feature: what is counted or measured; the feature of the column, or a factor of it.
            interval: range of the column.
        """
        low, high = interval.low, interval.high
        if np.ceil(high) - 1.0 == self.lowest[interval.column] > 0.0:
            low = self.lowest[interval.column]  # less never occurs
        whole = whole_numbers(low, high)
        if self.is_integer[interval.column] and " + " in name and not set("(·−") & set(name):
            things = name.split(" + ")
            numbered = self._number_of(things, low, high) if self.highest[interval.column] <= len(things) else ""
            return Statement(numbered or f"{whole}{OF_THESE}{', '.join(map(counted_thing, things))}")
        place, arrow, value = name.rpartition(" → ")
        is_choice = bool(arrow) and not isinstance(feature, Formula)
        if is_choice and self.is_integer[interval.column]:
            if whole == "1 or more":
                return Statement.of_choice(place, IS, value)
            often = {"none": "never", "1": "once"}
            return Statement(f"{place} = {value} {often.get(whole, f'{whole} times')}")
        if isinstance(feature, Pattern) and not arrow:
            thing = name.removeprefix(_NUMBER_OF)
            often = {"none": f"no {thing}", "1 or more": thing}
            return Statement(often.get(whole, f"{_NUMBER_OF if ' ' not in thing else ''}{thing}: {whole}"))
        subject = f"{name}:" if " " in name else name
        if self.is_integer[interval.column]:
            return Statement(f"{subject} {whole}")
        unit = self.table.units[interval.column] if self.table.units else ""
        return Statement(f"{subject} {quantity(low, high)}{'' if unit in ('', DEGREES) else ' '}{unit}")

    def _number_of(self, things: Sequence[str], low: float, high: float) -> str:
        """How many of equal choices there are: ``2 of Ground floor, Upper floor are Office``; empty for others."""
        choices = [thing.removeprefix("not ") for thing in things]
        if any(choice.count(" → ") != 1 or _NO_CHOICE.search(choice) for choice in choices):
            return ""
        places, values = zip(*(choice.split(" → ") for choice in choices), strict=True)
        are_denied = {thing.startswith("not ") for thing in things}
        if len(set(values)) > 1 or len(are_denied) > 1:
            return ""
        if True in are_denied:  # as many are the value as are not denied
            low, high = len(things) - np.ceil(high) + 1.0, len(things) - np.ceil(low) + 1.0
        num = whole_numbers(low, high)
        return f"{num} of {', '.join(places)} {'is' if num in ('1', 'at most 1') else 'are'} {values[0]}"


def _factors(formula: Formula, step: Step) -> Iterator[Feature | None]:
    """What a product multiplies; None for a factor that is not a feature."""
    if isinstance(step, Apply) and step.operation == "*":
        for index in step.operands:
            yield from _factors(formula, formula.steps[index])
    else:
        yield step.feature if isinstance(step, Measure) else None
