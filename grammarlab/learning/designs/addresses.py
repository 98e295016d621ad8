"""What names a design: where it is drawn from, so that it can be made again."""

from __future__ import annotations

import re
from hashlib import sha256
from typing import NamedTuple

from grammarlab.errors import UsageError
from grammarlab.preference.labels.table import Label, Place

_TEXT = re.compile(r"([gf])(0|[1-9][0-9]{0,19})-(0|[1-9][0-9]{0,18})")


class Address(NamedTuple):
    """A design of a space."""

    flat: bool
    """Whether it is a sample of the space's proposal, such as a grammar with equal percentages
    (`grammarlab.learning.designs.flattening`), instead of the space itself."""
    seed: int
    """0 <= seed < 2**64."""
    model: int
    """Index under the seed, 0 <= model < 2**63."""
    start_rule: str = ""
    """The last three as in `Label`: empty, {} and empty for the designs of a pool."""
    attributes: str = "{}"
    footprint: str = ""

    def __str__(self) -> str:
        return f"{'f' if self.flat else 'g'}{self.seed}-{self.model}"

    @classmethod
    def parse(cls, text: object) -> Address:
        """The address that a text states.

        Raises:
            UsageError: when it states none.

        >>> Address.parse("g5-17")[:3]
        (False, 5, 17)
        """
        match = _TEXT.fullmatch(text) if isinstance(text, str) and len(text) <= 48 else None
        if match is None or int(match[2]) >= 1 << 64 or int(match[3]) >= 1 << 63:
            raise UsageError(f"expected a model such as 'g5-17', found {shown(text)}.")
        return cls(match[1] == "f", int(match[2]), int(match[3]))

    @classmethod
    def of(cls, label: Label, hashes: tuple[str, str]) -> Address:
        """The design that a label is about.

        Args:
            label: one score.
            hashes: of the space and of its proposal; the label names one of them.
        """
        return cls._at(label.address, hashes)

    @classmethod
    def of_other(cls, label: Label, hashes: tuple[str, str]) -> Address | None:
        """The design that a comparison is with; None for labels of other kinds."""
        place = label.other_address
        return None if place is None else cls._at(place, hashes)

    @classmethod
    def _at(cls, place: Place, hashes: tuple[str, str]) -> Address:
        grammar, start_rule, attributes, footprint, seed, model = place
        return cls(grammar == hashes[1], seed, model, start_rule, attributes, footprint)

    def label(self, factor: str, score: float, hashes: tuple[str, str]) -> Label:
        """A score of the design, as label files hold it."""
        return Label(
            seed=self.seed,
            model=self.model,
            factor=factor,
            score=score,
            grammar=hashes[self.flat],
            start_rule=self.start_rule,
            attributes=self.attributes,
            footprint=self.footprint,
        )


def hashes_of(text_hash: str) -> tuple[str, str]:
    """What label files call a space that a file describes, and its proposal.

    Args:
        text_hash: SHA-256 of the text of the file, in hexadecimal.
    """
    return text_hash, sha256(f"flattened {text_hash}".encode()).hexdigest()


def shown(value: object) -> str:
    """A foreign value in a message, cut short."""
    if isinstance(value, dict | list):
        return f"a list or object of {len(value)}"
    text = repr(value) if not isinstance(value, str) or len(value) < 100 else repr(value[:60])
    return text if len(text) <= 60 else f"{text[:57]}..."
