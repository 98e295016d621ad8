"""Conversion between the labels of a session and label files."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import hashes_of
from grammarlab.learning.designs.pool import Pool
from grammarlab.pages.record.judgements import Scores, as_label, of_label
from grammarlab.pages.record.model_grids import MAX_MODELS
from grammarlab.pages.record.store import SUFFIX, Store
from grammarlab.preference.label_files import read_labels
from grammarlab.preference.labels import Labels


def read_labels_or_session(path: Path) -> tuple[Labels, Pool | None]:
    """Labels of a label file, or of a session file (.db) with its pool.

    Raises:
        UsageError: If it has another suffix.
        AssetError: If it is missing, too large or broken.
    """
    if path.suffix.lower() != SUFFIX:
        return read_labels(path), None
    with closing(Store.open(path)) as store:
        about = store.about
        return labels_of(store.record.factors, about.hash), Pool(about.seed, about.size, store.record.wide)


def labels_of(factors: dict[str, Scores], grammar: str) -> Labels:
    """All scores and comparisons, in the order of factors and models.

    Args:
        factors: labels of a session.
        grammar: SHA-256 of its grammar.
    """
    hashes = hashes_of(grammar)
    return Labels(
        tuple(
            as_label(subject, judgement, factor, hashes)
            for factor, scores in factors.items()
            for subject, judgement in scores.items()
        )
    )


def replaced_notes(num_labels: int, factors: dict[str, Scores]) -> tuple[str, ...]:
    """A note if a file has several labels of one model, or one pair, and factor, of which the last one counts.

    >>> from grammarlab.pages.record.judgements import Judgement
    >>> replaced_notes(3, {"overall": {"g0-1": Judgement(80.0)}})
    ('2 labels are left out: each model and pair has one label per factor in a session, the last one of the file',)
    """
    number = num_labels - sum(map(len, factors.values()))
    left_out = "1 label is" if number == 1 else f"{number:,} labels are"
    last = "each model and pair has one label per factor in a session, the last one of the file"
    return (f"{left_out} left out: {last}",) if number else ()


def scores_of(labels: Labels, grammar: str) -> dict[str, Scores]:
    """Labels by factor and subject; of two for the same factor and subject the later one counts.

    Args:
        labels: labels of any grammar.
        grammar: SHA-256 of the grammar that they should be about.

    Raises:
        UsageError: If they are of another grammar, of other footprints or attributes, or too many.
    """
    hashes = hashes_of(grammar)
    if not len(labels):
        raise UsageError("there are no labels in the file.")
    if len(labels) > MAX_MODELS:
        raise UsageError(f"{len(labels):,} labels; {MAX_MODELS:,} can be imported at once. Split the file.")
    found: dict[str, Scores] = {}
    for label in labels:
        addresses = [address for address in (label.address, label.other_address) if address is not None]
        foreign = [address[0] for address in addresses if address[0] not in hashes]
        if foreign:
            raise UsageError(
                f"labels about another grammar: expected {grammar[:16]}…, found {foreign[0][:16]}…. Import labels "
                "of this session's models."
            )
        if any(address[1:4] != ("", "{}", "") for address in addresses):
            raise UsageError(
                "labels of models with a start rule, attributes or a footprint of their own cannot be imported: a "
                "session is about models of the file as it is."
            )
        subject, judgement = of_label(label, hashes)
        found.setdefault(label.factor, {})[subject] = judgement
    return found
