"""Alignments by CP-SAT: the model of the specification, independent of the package's method."""

from collections import Counter
from dataclasses import dataclass
from itertools import combinations, pairwise

from ortools.sat.python import cp_model


@dataclass
class Row:
    begun: list  # [letter][column] whether the letter begins in this column or before
    ended: list  # [letter][column] whether it ends in this column or before
    inside: list  # [letter][column]
    whole: list  # [letter] whether it is not split
    filled: list  # [column]
    opaque: list  # [column]
    partial: list  # [column]
    fixed: list  # [column]
    size: list  # [column]
    loose: list  # [column] number of letters without a fixed width


def optimum(words, canvas, tolerance, error_price, merge_price):
    """The least cost of an alignment of letters with integer sizes; None if there is none."""
    least, most = canvas - tolerance, canvas + tolerance
    columns = sum(letter.opaque and not letter.transparent for word in words for letter in word)
    if columns == 0:
        return None
    model = cp_model.CpModel()
    used = [model.new_bool_var("") for _ in range(columns)]
    for before, after in pairwise(used):
        model.add_implication(after, before)
    rows = [_row(model, word, used) for word in words]
    for one, word in enumerate(words):
        first = words.index(word)
        for mine, other in zip(rows[one].inside, rows[first].inside, strict=True):
            for a, b in zip(mine, other, strict=True):
                model.add(a == b)
    total, errors = [], []
    elastic = []
    top = most + 1
    for at in range(columns):
        model.add_bool_or([row.opaque[at] for row in rows] + [used[at].negated()])
        high, error = model.new_int_var(0, top, ""), model.new_int_var(0, tolerance, "")
        model.add_max_equality(high, [row.size[at] for row in rows])
        wide = model.new_bool_var("")
        model.add(sum(row.fixed[at] for row in rows) == 0).only_enforce_if(wide)
        model.add(sum(row.fixed[at] for row in rows) >= 1).only_enforce_if(wide.negated())
        for one, row in enumerate(rows):
            model.add(error >= high - row.size[at]).only_enforce_if(row.fixed[at])
            above = [other.opaque[at] for other in rows[:one]]
            bare = model.new_bool_var("")
            model.add_bool_or([row.filled[at], *above, bare, used[at].negated()])
            model.add(error >= high).only_enforce_if(bare)
            model.add_bool_or([bare.negated(), wide.negated(), used[at].negated()])
            shielded = [
                inside[at]
                for letter, inside in zip(words[one], row.inside, strict=True)
                if letter.unoccludable and not letter.transparent
            ]
            for upper in range(one):
                if words[upper] != words[one]:
                    for each in shielded:
                        model.add_implication(each, rows[upper].partial[at].negated())
        open_end = model.new_bool_var("")
        model.add_bool_and([wide, used[at]]).only_enforce_if(open_end)
        model.add_bool_or([wide.negated(), used[at].negated(), open_end])
        elastic.append(open_end)
        total.append(high)
        errors.append(error)
    _spread(model, words, rows, total, elastic, tolerance, top)
    model.add(sum(total) <= most)
    some = model.new_bool_var("")
    model.add_bool_or([some.negated(), *elastic])
    model.add(sum(total) >= least).only_enforce_if(some.negated())
    merged = sum(sum(map(sum, row.inside)) - sum(row.filled) for row in rows)
    model.minimize(error_price * sum(errors) + merge_price * merged)
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    status = solver.solve(model)
    if status == cp_model.INFEASIBLE:
        return None
    assert status == cp_model.OPTIMAL
    return round(solver.objective_value)


def _spread(model, words, rows, total, elastic, tolerance, top):
    """Constraints on letters without a fixed width: their shares of columns differ little within a symbol."""
    distinct = dict(zip(words, rows, strict=True))
    often = Counter(letter.symbol for word in distinct for letter in word if letter.size is None)
    spreads = {}
    for word, row in distinct.items():
        for at, letter in enumerate(word):
            if letter.size is None and often[letter.symbol] < 2:
                continue
            if letter.size is not None and not letter.transparent:
                continue
            torn = letter.size is None or row.whole[at].negated()
            parts = []
            for column, high in enumerate(total):
                part, wide = model.new_int_var(0, 4 * top, ""), model.new_int_var(0, 4 * top, "")
                inside = row.inside[at][column]
                model.add(part == 0).only_enforce_if(inside.negated())
                model.add(wide <= high - row.size[column]).only_enforce_if(elastic[column].negated())
                model.add(part <= wide)
                single = model.new_bool_var("")
                model.add(row.loose[column] <= 1).only_enforce_if(single)
                model.add(row.loose[column] >= 2).only_enforce_if(single.negated())
                model.add(part >= high - row.size[column]).only_enforce_if([inside, single])
                parts.append(part)
            spread = model.new_int_var(0, 4 * top * len(total), "")
            if torn is True:
                model.add(spread == sum(parts))
            else:
                model.add(spread == sum(parts)).only_enforce_if(torn)
                model.add(spread == round(letter.size or 0)).only_enforce_if(torn.negated())
                spreads.setdefault(letter.symbol, []).append(round(letter.size or 0))
            spreads.setdefault(letter.symbol, []).append(spread)
    for each in spreads.values():
        for one, other in combinations(each, 2):
            model.add(one - other <= tolerance)
            model.add(other - one <= tolerance)


def _row(model, word, used):
    columns = range(len(used))
    begun = [[model.new_bool_var("") for _ in columns] for _ in word]
    ended = [[model.new_bool_var("") for _ in columns] if letter.transparent else begun[at]
             for at, letter in enumerate(word)]  # fmt: skip
    for each in (*begun, *ended):
        for before, after in pairwise(each):
            model.add_implication(before, after)
        model.add(each[-1] == 1)
    inside, whole = [], []
    for start, end in zip(begun, ended, strict=True):
        cells = []
        for at in columns:
            cell = model.new_bool_var("")
            gone = end[at - 1] if at else 0
            model.add_implication(end[at], start[at])
            model.add(cell == start[at] - gone)
            model.add_implication(cell, used[at])
            cells.append(cell)
        inside.append(cells)
        one = model.new_bool_var("")
        model.add(sum(cells) == 1).only_enforce_if(one)
        model.add(sum(cells) >= 2).only_enforce_if(one.negated())
        whole.append(one)
    for at in range(len(word) - 1):
        one, other = word[at], word[at + 1]
        tight = one.attached or one.transparent or other.attached or other.transparent
        for column in columns:
            model.add_implication(begun[at + 1][column], ended[at][column])
            gone = ended[at][column - 1] if column else 0
            if one.transparent != other.transparent:
                model.add(begun[at + 1][column] <= gone)
            if tight:
                model.add(begun[at + 1][column] >= gone)
    if word and (word[0].attached or word[0].transparent):
        model.add(begun[0][0] == 1)
    if word and (word[-1].attached or word[-1].transparent):
        for column in columns[1:]:
            model.add_implication(ended[-1][column - 1], used[column].negated())
    return _elements(model, word, begun, ended, inside, whole, columns)


def _elements(model, word, begun, ended, inside, whole, columns):
    filled, opaque, partial, fixed, size, many = [], [], [], [], [], []
    for column in columns:
        some = _any(model, [cells[column] for cells in inside])
        weak = [inside[at][column] for at, letter in enumerate(word) if letter.transparent or not letter.opaque]
        solid, part, exact = (model.new_bool_var("") for _ in range(3))
        model.add(solid == 0).only_enforce_if(some.negated())
        any_weak = _any(model, weak)
        model.add_bool_or([solid, some.negated(), any_weak])
        model.add_implication(solid, any_weak.negated())
        seen = _any(model, [inside[at][column] for at, letter in enumerate(word) if not letter.transparent])
        model.add_bool_and([seen, any_weak]).only_enforce_if(part)
        model.add_bool_or([part, seen.negated(), any_weak.negated()])
        terms, loose = [], []
        for at, letter in enumerate(word):
            if letter.size is None:
                loose.append(inside[at][column])
                continue
            if not letter.transparent:
                terms.append(round(letter.size or 0) * inside[at][column])
                continue
            both, torn = model.new_bool_var(""), model.new_bool_var("")
            model.add_multiplication_equality(both, [inside[at][column], whole[at]])
            model.add(torn == inside[at][column] - both)
            terms.append(round(letter.size or 0) * both)
            loose.append(torn)
        any_loose = _any(model, loose)
        model.add_bool_and([some, any_loose.negated()]).only_enforce_if(exact)
        model.add_bool_or([exact, some.negated(), any_loose])
        filled.append(some)
        opaque.append(solid)
        partial.append(part)
        fixed.append(exact)
        size.append(sum(terms))
        many.append(sum(loose))
    return Row(begun, ended, inside, whole, filled, opaque, partial, fixed, size, many)


def _any(model, literals):
    some = model.new_bool_var("")
    model.add_bool_or([*literals, some.negated()])
    for each in literals:
        model.add_implication(each, some)
    return some
