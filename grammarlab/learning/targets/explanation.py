"""A learned preference in words: a few kinds of designs that are liked, and a few that are not.

The predictions of a pool become a small regression tree, whose leaves are kinds of designs that differ in a few parts
or choices. If parts add up, a tree would repeat itself in all its branches; then each part is described with its
points.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import ROUNDING, Floats, Ints
from grammarlab.density.exact.name_words import MOST_NAMED
from grammarlab.features.columns.formula_names import COMBINATION, ONE_OF, RELATION, formula_words, is_statement
from grammarlab.features.patterns.pattern import Apply, Feature, Formula
from grammarlab.language.dimensions import DEGREES
from grammarlab.language.display_names import DisplayNames
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.contrasts import choice_of
from grammarlab.learning.designs.design_tables import DesignTable
from grammarlab.learning.targets.divergence import agreement
from grammarlab.preference.base import LIKED_SHARE, MAX_SCORE, NEGLIGIBLE_SHARE, SCORE_STEP
from grammarlab.preference.regression_tree import Split, grow, leaves_of, means_of

MAX_PARTS = 6
"""Largest number of parts on each side."""
_MAX_EXAMPLES = 16
"""Designs with a choice to choose from, since the seed of one may give the same design without it."""
_MAX_LEAVES = 8
"""Largest number of leaves of the tree that is described."""
_MAX_UNEXPLAINED = 0.1
"""Share that words may leave out: of the divergence between the grammar and the learned density by a tree, and of the
highest score by kinds that are not liked."""
_MAX_BESIDE_SUM = 0.05
"""Largest share of the variance of scores that a sum of parts does not explain, for a description as a sum."""
_MIN_POINTS = 3.0
"""Smallest number of points of a described part."""
_MAX_RARITY = 400
"""Smallest share of designs of a kind: one in 400."""
_NO_CHOICE = re.compile(r"^(any|number of) | then ")
"""What names of choices of one symbol do not have."""
_STATEMENT_STARTS, _STATEMENT_ENDS = (
    ("all ", "no ", "not ", "same choice"),
    (" alike", " alternate", " mirrored", " never fall", " by turns"),
)
"""Beginnings and ends of names of columns that are statements, not things."""
_NUMBER = re.compile(r" \(\d+\)$")
"""What tells names of columns apart that would be equal."""
_WITH = " with "
"""What connects two choices that go together."""


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

    def displayed(self, names: DisplayNames) -> Words:
        """The kinds in the words of people instead of the identifiers of a grammar."""
        likes, dislikes = (tuple(map(names.text, side)) for side in (self.likes, self.dislikes))
        contrasts = tuple(replace(contrast, text=names.text(contrast.text)) for contrast in self.contrasts)
        return Words(likes, dislikes, self.knowledge, contrasts)

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


def words_of(table: DesignTable, scores: Floats, weights: Floats, addresses: Sequence[Address] = ()) -> Words:
    """Description of predictions.

    Args:
        table: table of the designs.
        scores: [m] predicted for the first m designs of the table, 0 to 100.
        weights: [m] >= 0, importance weight of each design.
        addresses: [m] addresses of the designs; without them, contrasts have no examples.
    """
    rows = table.values(len(scores))
    if not (weights * scores).any() or np.ptp(scores) == 0.0:
        return Words((), ())
    names = _ColumnWords(table, rows)
    tree = _small_tree(rows, scores, weights, names)
    words = _parts(tree, rows, scores, weights, names) or _kinds(tree, rows, scores, weights, names)
    if not (words.likes or words.dislikes):
        return words
    return replace(words, contrasts=tuple(_contrasts(tree, rows, scores, weights, names, addresses)))


def _small_tree(rows: Floats, scores: Floats, weights: Floats, names: _ColumnWords) -> tuple[Split, ...]:
    """Smallest tree that explains most of the predictions, by choices and draws only if these are enough."""
    bound = _MAX_UNEXPLAINED * agreement(scores, np.ones(len(scores)), weights).js
    nearest: tuple[float, tuple[Split, ...]] = (np.inf, ())
    for columns in (names.order[names.simple[names.order]], names.order):
        tree = grow(rows, scores, weights, columns, _MAX_LEAVES, len(rows) // _MAX_RARITY)
        for size in range(1, len(tree) + 1):
            leaf = leaves_of(tree[:size], rows)
            unexplained = agreement(scores, means_of(leaf, size + 1, scores, weights)[leaf], weights).js
            nearest = min(nearest, (unexplained, tree[:size]))
            if unexplained <= bound:
                return tree[:size]
    return nearest[1]


def _parts(tree: Sequence[Split], rows: Floats, scores: Floats, weights: Floats, names: _ColumnWords) -> Words | None:
    """The parts that a tree tests, with the points each adds; None if a sum does not explain the scores."""
    tests = list(dict.fromkeys((split.column, split.bound) for split in tree))
    if len(tests) < 2 or len({column for column, _ in tests}) < len(tests):
        return None
    has = np.column_stack([np.ones(len(rows)), *(rows[:, column] >= bound for column, bound in tests)])
    roots = np.sqrt(weights)[:, None]
    added = np.linalg.lstsq(has * roots, scores * roots[:, 0], rcond=None)[0]
    mean = weights @ scores / weights.sum()
    residual_share = weights @ (scores - has @ added) ** 2 / max(float(weights @ (scores - mean) ** 2), 1e-12)
    # A conjunction is not a sum: its parts add up to a negative score if all of them are missing.
    if residual_share > _MAX_BESIDE_SUM or np.abs(added).max() > MAX_SCORE:
        return None
    ranked = sorted(zip(tests, added[1:].tolist(), strict=True), key=lambda item: -abs(item[1]))
    sides: tuple[list[str], list[str]] = ([], [])
    for (column, bound), points in ranked:
        if abs(points) >= _MIN_POINTS:
            sides[points < 0.0].append(f"{names.condition(_Range(column, bound, np.inf))} ({points:+.0f})")
    return Words(tuple(sides[0][:MAX_PARTS]), tuple(sides[1][:MAX_PARTS]))


def _kinds(tree: Sequence[Split], rows: Floats, scores: Floats, weights: Floats, names: _ColumnWords) -> Words:
    """The most frequent liked leaves, and the most frequent others."""
    leaf = leaves_of(tree, rows)
    means = means_of(leaf, len(tree) + 1, scores, weights)
    mass = np.bincount(leaf, weights, len(tree) + 1).astype(np.float64)
    if means.max() < SCORE_STEP:
        return Words((), ())
    ranges = _ranges(tree)

    def select(is_candidate: NDArray[np.bool_], by: Floats, most: int) -> list[int]:
        candidates = [
            index for index in np.argsort(-by, kind="stable").tolist() if is_candidate[index] and mass[index] > 0.0
        ]
        return [index for index in candidates if 0 < len(ranges[index]) <= most][:MOST_NAMED]

    def text(indices: Sequence[int]) -> tuple[str, ...]:
        return tuple(f"{names.kind(ranges[index])} ({means[index]:.0f})" for index in indices)

    likes = select(means >= LIKED_SHARE * means.max(), mass * means, _MAX_LEAVES)
    dislikes = select(means < _MAX_UNEXPLAINED * means.max(), mass, MOST_NAMED)
    return Words(text(sorted(likes, key=lambda index: -means[index])), text(dislikes))


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
        examples = [addresses[row] for row in best_first if not addresses[row].flat][:_MAX_EXAMPLES]
        text = " = ".join(table.names[column].removeprefix("number of ").rsplit(" → ", 1))
        yield ContrastWords(text, table.features[column], without, having, tuple(examples))


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

    def __init__(self, table: DesignTable, rows: Floats) -> None:
        self.table = table
        self.is_integer = ~table.continuous
        if table.logarithmic is not None:
            self.is_integer |= table.logarithmic & (np.abs(rows - np.rint(rows)) <= ROUNDING * rows).all(axis=0)
        self.lowest, self.highest = rows.min(axis=0), rows.max(axis=0)

    @property
    def order(self) -> Ints:
        """Columns, short names first: of equivalent columns the first one is described."""
        names = self.table.names
        return np.array(sorted(range(len(names)), key=lambda column: (len(names[column]), column)), dtype=np.int64)

    @property
    def simple(self) -> NDArray[np.bool_]:
        """[F] whether columns are choices of one symbol, or draws."""
        choices = [" → " in name and " › " not in name for name in self.table.names]
        return np.array(choices, dtype=bool) | ~self.is_integer

    def kind(self, ranges: dict[int, _Range]) -> str:
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
        return ", ".join(
            self.condition(interval) for interval in sorted(conditions, key=lambda interval: interval.low <= 0.0)
        )

    def condition(self, interval: _Range) -> str:
        """One condition."""
        column, name = interval.column, self.table.names[interval.column]
        if compared := self._comparison(interval):
            return compared
        return " ".join(self._choice(interval) if self._is_choice(column) else self._amount(name, interval))

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

    def _is_choice(self, column: int) -> bool:
        """Whether a column is a property that designs have or not: its values are 0 and 1."""
        return bool(self.is_integer[column]) and self.lowest[column] == 0.0 and self.highest[column] == 1.0

    def _choice(self, interval: _Range) -> Iterator[str]:
        name, feature = self.table.names[interval.column], self.table.features[interval.column]
        before, arrow, after = name.removeprefix("any ").rpartition(" → ")
        has, thing = interval.low > 0.0, name.removeprefix("number of ").removeprefix("any ")
        if thing.startswith(ONE_OF):
            yield thing if has else f"none{thing.removeprefix('one')}"
            return
        if thing.startswith(RELATION):
            yield f"{thing} {'holds' if has else 'does not hold'}"
            return
        if thing.startswith(COMBINATION):
            yield f"{thing}: {'1' if has else 'none'}"
            return
        bare = _NUMBER.sub("", thing)
        is_sentence = bare.startswith(_STATEMENT_STARTS) or bare.endswith(_STATEMENT_ENDS)
        is_sentence |= _WITH in bare and all(" = " in choice for choice in bare.split(_WITH))
        if isinstance(feature, Formula) and (arrow or (is_statement(feature) and not is_sentence)):
            yield name if has else f"not ({name})"
            return
        denial = "not" if is_sentence else "no"
        yield f"{before} {'=' if has else '≠'} {after}" if arrow else thing if has else f"{denial} {thing}"

    def _amount(self, name: str, interval: _Range) -> Iterator[str]:
        low, high = interval.low, interval.high
        if self.is_integer[interval.column] and " + " in name and not set("(·−") & set(name):
            things = name.split(" + ")
            numbered = self._number_of(things, low, high) if self.highest[interval.column] <= len(things) else ""
            yield numbered or f"{self._whole(low, high)} of these: {', '.join(map(_thing, things))}"
            return
        place, arrow, value = name.rpartition(" → ")
        is_choice = bool(arrow) and not isinstance(self.table.features[interval.column], Formula)
        if is_choice and self.is_integer[interval.column]:
            num = self._whole(low, high)
            yield f"{place} = {value} " + {"none": "never", "1": "once"}.get(num, f"{num} times")
            return
        yield f"{name}:" if " " in name else name
        if self.is_integer[interval.column]:
            yield self._whole(low, high)
            return
        unit = self.table.units[interval.column] if self.table.units else ""
        yield self._quantity(low, high) + ("" if unit in ("", DEGREES) else " ") + unit

    @staticmethod
    def _quantity(low: float, high: float) -> str:
        """A range of a continuous number, whose bounds never occur themselves."""
        first, last = (f"{bound:.3g}" if abs(bound) < 999.5 else f"{bound:,.0f}" for bound in (low, high))
        if np.isfinite(low + high):
            return f"{first} to {last}"
        return f"at least {first}" if np.isfinite(low) else f"at most {last}"

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
        num = self._whole(low, high)
        return f"{num} of {', '.join(places)} {'is' if num in ('1', 'at most 1') else 'are'} {values[0]}"

    @staticmethod
    def _whole(low: float, high: float) -> str:
        """Whole numbers between bounds; the ends themselves are given."""
        first, last = np.ceil(low), np.ceil(high) - 1.0
        if not np.isfinite(last):
            return f"{first:.0f} or more"
        if not np.isfinite(first):
            return "none" if last == 0.0 else f"at most {last:.0f}"
        return f"{first:.0f}" if first == last else f"{first:.0f} to {last:.0f}"


def _thing(name: str) -> str:
    """A summand of a number of things: ``no Door`` for ``not number of Door``."""
    if name.startswith("not ") and " → " in name:
        return name.removeprefix("not ").replace(" → ", " ≠ ")
    return name.replace("not number of ", "no ").removeprefix("number of ").replace(" → ", " = ")
