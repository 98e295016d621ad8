"""Comment at the top of a learned file: where it comes from, and what was learned, in sentences."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from textwrap import wrap

from grammarlab.about import __version__
from grammarlab.learning.targets.simplification import Predicted, SimplifiedFactor
from grammarlab.learning.targets.unknown_part import CHANCE, MIN_LABELS

_WIDTH = 112
"""Largest number of characters of a line, without comment marks; longer words are not broken."""
_MAX_CHARACTERS = 600
"""Largest number of characters of one kind of designs; names of symbols can have any length."""
_ADDS = re.compile(r"\([+-]\d+\)$")
"""Points at the end of a kind: ``Door (+20)``."""
_INDENT = "  "
_FIRST = "Learned by grammarlab "
"""First words of a head."""


def origin_line(file: str, text_hash: str) -> str:
    """Line of a learned file that names its original, read by `grammarlab compare`."""
    return f"{_FIRST}{__version__} from {file} (SHA-256 {text_hash[:16]})"


def head(lines: Sequence[str], predicted: Predicted, seed: int) -> list[str]:
    """Comment lines at the top of a learned file, without comment marks and control characters.

    Args:
        lines: the origin of the file.
        predicted: what was learned.
        seed: seed of the designs that the scores were learned on.
    """
    return [plain(line) for line in (*lines, "", *_taste(predicted), *_certainty(predicted), f"Seed {seed}.", "")]


def plain(line: str) -> str:
    """A comment line without line ends and other control characters."""
    return "".join(character if character.isprintable() else " " for character in line)


def _taste(predicted: Predicted) -> Iterator[str]:
    """What the scores do not agree on, then liked and disliked kinds of designs, one below the other."""
    words = predicted.words
    is_relative = all(factor.num_comparisons == factor.num_labels for factor in predicted.factors)
    for sentence in words.voices:
        yield from wrap(plain(sentence), _WIDTH, break_long_words=False)
    if any(CHANCE in sentence for sentence in words.knowledge):
        yield CHANCE
    for title, kinds in (("Likes", words.likes), ("Does not like", words.dislikes)):
        if kinds:
            adds = all(map(_ADDS.search, kinds))
            mean = "with the mean value, 100 for the best" if is_relative else "with the mean score, 0 to 100"
            yield f"{title} ({'points that each part adds' if adds else mean}):"
        for kind in kinds:
            short = kind if len(kind) <= _MAX_CHARACTERS else f"{kind[:_MAX_CHARACTERS]} …"
            yield from wrap(
                plain(short),
                _WIDTH,
                initial_indent=f"{_INDENT}- ",
                subsequent_indent=2 * _INDENT,
                break_long_words=False,
                break_on_hyphens=False,
            )


def _certainty(predicted: Predicted) -> Iterator[str]:
    """How many scores there are, how much of them is explained, and how much of the original is kept."""
    several = len(predicted.factors) > 1
    for factor in predicted.factors:
        yield from wrap((f"{factor.name}: " if several else "") + _sentences(factor), _WIDTH, break_long_words=False)


def _sentences(factor: SimplifiedFactor) -> str:
    num_scores = factor.num_labels - factor.num_comparisons
    numbers = ((num_scores, "score"), (factor.num_comparisons, "comparison"))
    labels = " and ".join(f"{num:,} {word}{'s' if num != 1 else ''}" for num, word in numbers if num)
    if factor.unexplained == 1.0:
        return f"No pattern yet in {labels}: the original is kept."
    if factor.are_equal:
        same = f"All {labels} are equal" if num_scores > 1 else f"There is only {labels}"
        return f"{same}: the original is kept."
    explained = f" This explains {factor.explained:.0%} of held-out scores." if _is_share_given(factor) else ""
    kept = f" {factor.unexplained:.0%} of the original is mixed in, since there are not enough yet."
    return f"Learned from {labels}.{explained}{kept if factor.unexplained else ''}"


def _is_share_given(factor: SimplifiedFactor) -> bool:
    """Whether the share of explained scores is said."""
    return factor.explained is not None and factor.num_labels - factor.num_comparisons >= MIN_LABELS


def without_earlier_head(text: str) -> str:
    """A learned file without the head of the learned file that it was made from.

    Args:
        text: a rule file that begins with a head; only a second one directly below it is removed.
    """
    own, gap, rest = text.partition("\n\n")
    earlier, _, below = rest.partition("\n\n")
    lines = earlier.split("\n")
    is_head = lines[0].startswith(f"// {_FIRST}") and lines[-1].startswith("// Method ")
    return own + gap + below if is_head and all(line.startswith("//") for line in lines) else text
