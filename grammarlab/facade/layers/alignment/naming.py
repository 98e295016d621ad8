"""Matrices of alignments as text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from grammarlab.facade.layers.letters import Word

Part = tuple[int, int]
"""Index of a letter in its word, and index of the part: 0, unless columns split the letter."""
Element = tuple[Part, ...]
"""Parts in one row and one column; empty for a gap."""
EMPTY_TEXT = "ε"


def named_columns(words: Sequence[Word], cells: Sequence[Sequence[Element]]) -> list[list[str]]:
    """[n][m] the elements as text, see `Alignment.columns`."""
    split = [{at for element in row for at, part in element if part} for row in cells]
    occurs = Counter(letter.symbol for word in dict.fromkeys(words) for letter in word)
    between = " " if any(len(symbol) > 1 for symbol in occurs) else ""
    numbers: dict[str, dict[tuple[tuple[str, ...], ...], int]] = {}
    columns = []
    for column in zip(*cells, strict=True):
        whole = tuple(
            tuple(word[at].symbol for at, _ in element if at not in parts)
            for word, element, parts in zip(words, column, split, strict=True)
        )
        names = []
        for word, element, parts in zip(words, column, split, strict=True):
            texts = []
            for at, _ in element:
                letter, number = word[at], ""
                if at in parts and (letter.size is not None or occurs[letter.symbol] > 1):
                    known = numbers.setdefault(letter.symbol, {})
                    number = str(known.setdefault(whole, len(known) + 1))
                texts.append(letter.symbol + number)
            names.append(between.join(texts) or EMPTY_TEXT)
        columns.append(names)
    return columns
