"""Addresses of designs, from which they can be made again."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from typing import NamedTuple

from grammarlab.errors import UsageError, shown
from grammarlab.language.grammar import hash_of, normal
from grammarlab.preference.labels import Label, Labels, Place

_TEXT = re.compile(r"([gf])(0|[1-9][0-9]{0,19})-(0|[1-9][0-9]{0,19})")


class Address(NamedTuple):
    """A design of a space."""

    flat: bool
    """Whether it is a sample of the space's proposal, such as a grammar with equal percentages
    (`grammarlab.learning.designs.flattening`), instead of the space itself."""
    seed: int
    """0 <= seed < 2**64."""
    model: int
    """Index under the seed, 0 <= model < 2**64."""
    start_rule: str = ""
    """Start rule, attributes and footprint are those of a `Label`; empty, {} and empty for the designs of a pool."""
    attributes: str = "{}"
    footprint: str = ""

    def __str__(self) -> str:
        return f"{'f' if self.flat else 'g'}{self.seed}-{self.model}"

    @classmethod
    def parse(cls, text: object) -> Address:
        """Address from a text.

        Raises:
            UsageError: If the text is not an address.

        >>> Address.parse("g5-17")[:3]
        (False, 5, 17)
        """
        match = _TEXT.fullmatch(text) if isinstance(text, str) and len(text) <= 48 else None
        if match is None or max(int(match[2]), int(match[3])) >= 1 << 64:
            raise UsageError(f"expected a model such as 'g5-17', found {shown(text)}.")
        return cls(match[1] == "f", int(match[2]), int(match[3]))

    @classmethod
    def of(cls, label: Label, hashes: tuple[str, str]) -> Address:
        """Address of the design of a label.

        Args:
            label: one score.
            hashes: hashes of the space and of its proposal; the label has one of them.
        """
        return cls._of_parts(label.address, hashes)

    @classmethod
    def of_other(cls, label: Label, hashes: tuple[str, str]) -> Address | None:
        """Address of the other design of a comparison; None for labels of other kinds."""
        parts = label.other_address
        return None if parts is None else cls._of_parts(parts, hashes)

    @classmethod
    def _of_parts(cls, parts: Place, hashes: tuple[str, str]) -> Address:
        grammar, start_rule, attributes, footprint, seed, model = parts
        return cls(grammar == hashes[1], seed, model, start_rule, attributes, footprint)

    def label(self, factor: str, score: float, hashes: tuple[str, str]) -> Label:
        """A label of the design with a score."""
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
    """Hashes in label files of a space that a file describes, and of its proposal.

    Args:
        text_hash: SHA-256 of the text of the file, in hexadecimal.
    """
    return text_hash, sha256(f"flattened {text_hash}".encode()).hexdigest()


def renamed(labels: Labels, text: str) -> Labels:
    """Labels with the hash of a text that is independent of line ends.

    Earlier versions hashed a file with Windows line ends as it was, so that its labels have another hash.

    Args:
        labels: labels of any grammars.
        text: text of the file that describes the designs.
    """
    windows = sha256(normal(text).replace("\n", "\r\n").encode("utf-8", "surrogatepass")).hexdigest()
    names = dict(zip(hashes_of(windows), hashes_of(hash_of(text)), strict=True))
    if not any(label.grammar in names for label in labels):
        return labels
    return Labels(tuple(_renamed(label, names) for label in labels), labels.notes)


def _renamed(label: Label, names: Mapping[str, str]) -> Label:
    other = label.other
    if other:
        record = json.loads(other)
        if record.get("grammar") in names:
            other = json.dumps(record | {"grammar": names[record["grammar"]]}, separators=(",", ":"))
    return replace(label, grammar=names.get(label.grammar, label.grammar), other=other)
