"""Words for tests of alignment, and all matrices of a few letters."""

import random
from itertools import product

from grammarlab.layers.design import Letter

FLAGS = ("opaque", "attached", "unoccludable", "transparent")


def word(text, sizes, *, partial="", attached="", unoccludable="", transparent=""):
    """A word of symbols of one character."""
    return tuple(
        Letter(
            each,
            sizes.get(each),
            opaque=each not in partial + transparent,
            attached=each in attached,
            unoccludable=each in unoccludable,
            transparent=each in transparent,
        )
        for each in text
    )


def random_case(seed, most=8, rows=(1, 2, 2, 3, 3)):
    """Words, canvas, tolerance in whole metres, and weight of merged letters; seeds cover all sets of flags."""
    rng = random.Random(seed)
    has = {flag: bool(seed >> bit & 1) for bit, flag in enumerate(FLAGS)}
    letters = []
    for name in "ABCDEF":
        transparent = has["transparent"] and rng.random() < 0.4
        letters.append(
            Letter(
                name,
                None if rng.random() < (0.7 if transparent else 0.04) else float(rng.randint(1, 6)),
                opaque=not transparent and not (has["opaque"] and rng.random() < 0.4),
                attached=has["attached"] and rng.random() < 0.25,
                unoccludable=has["unoccludable"] and rng.random() < 0.3,
                transparent=transparent,
            )
        )
    lengths = [length for length in (1, 2, 2, 3, 3, 4, 4, 5, 6, 8) if length <= most]
    words = [tuple(rng.choice(letters) for _ in range(rng.choice(lengths))) for _ in range(rng.choice(rows))]
    walls = [letter for letter in letters if letter.opaque and letter.size is not None]
    if walls and rng.random() < 0.8:
        words[-1] = tuple(rng.choice(walls) for _ in range(rng.choice(lengths)))
    if len(words) == 3 and rng.random() < 0.2:
        words[1] = words[0]
    longest = max(sum(letter.size or 0.0 for letter in each if not letter.transparent) for each in words)
    canvas = max(1.0, longest + rng.choice([-1.0, 0.0, 0.0, 1.0]))
    return words, canvas, rng.choice([1.0, 2.0, 3.0, 5.0]), rng.choice([0.02, 0.05, 0.3, 1.0, 3.0])


def all_matrices(words):
    """Every division of words into columns none of which is all empty; equal words have equal divisions."""
    distinct = list(dict.fromkeys(words))
    for cells in _continued(distinct, [(0, -1)] * len(distinct)):
        yield tuple(tuple(column[distinct.index(each)] for column in cells) for each in words)


def _continued(words, places):
    """Columns from given positions: number of letters read, and the last part of a letter that can continue, or -1."""
    if all(read == len(each) for each, (read, _) in zip(words, places, strict=True)):
        yield []
    for column in product(*(_elements(each, *place) for each, place in zip(words, places, strict=True))):
        # Only parts of letters would never end: an opaque letter has to begin.
        begun = [element for element, (read, _) in zip(column, places, strict=True) if element and element[-1][1] == 0]
        if not begun or all(element[-1][1] for element in begun):
            continue
        after = [_after(element, place) for element, place in zip(column, places, strict=True)]
        if after != places:
            yield from ([column, *rest] for rest in _continued(words, after))


def _elements(letters, read, part):
    yield ()
    if part >= 0 and letters[read - 1].transparent:
        for until in range(read, len(letters) + 1):
            yield ((read - 1, part + 1), *((at, 0) for at in range(read, until)))
    for until in range(read + 1, len(letters) + 1):
        yield tuple((at, 0) for at in range(read, until))


def _after(element, place):
    if not element:
        return (place[0], -1) if place[1] >= 0 else place
    at, part = element[-1]
    return (at + 1, part)
