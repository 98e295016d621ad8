"""What names a model in a session: short text that says how to derive it again."""

from __future__ import annotations

import re
from typing import NamedTuple

from grammarlab.errors import UsageError

_TEXT = re.compile(r"([gf])(0|[1-9][0-9]{0,19})-(0|[1-9][0-9]{0,18})")


class Address(NamedTuple):
    """A model of the session's grammar."""

    flat: bool
    """Whether it is a sample of the grammar with equal percentages (`grammarlab.evaluation.flattening`)."""
    seed: int
    """0 <= seed < 2**64."""
    model: int
    """Index under the seed, 0 <= model < 2**63."""

    def __str__(self) -> str:
        return f"{'f' if self.flat else 'g'}{self.seed}-{self.model}"

    @classmethod
    def parse(cls, text: object) -> Address:
        """The address that a text states.

        Raises:
            UsageError: when it states none.

        >>> Address.parse("g5-17")
        Address(flat=False, seed=5, model=17)
        """
        match = _TEXT.fullmatch(text) if isinstance(text, str) and len(text) <= 48 else None
        if match is None or int(match[2]) >= 1 << 64 or int(match[3]) >= 1 << 63:
            raise UsageError(f"expected a model such as 'g5-17', found {shown(text)}.")
        return cls(match[1] == "f", int(match[2]), int(match[3]))


def shown(value: object) -> str:
    """A foreign value in a message, cut short."""
    if isinstance(value, dict | list):
        return f"a list or object of {len(value)}"
    text = repr(value) if not isinstance(value, str) or len(value) < 100 else repr(value[:60])
    return text if len(text) <= 60 else f"{text[:57]}..."
