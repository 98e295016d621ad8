"""The scores of a session as labels, and label files as scores of a session."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.learning.addresses import Address, hashes_of
from grammarlab.learning.pool import Pool
from grammarlab.preference.label_files import read_labels
from grammarlab.preference.labels import Labels
from grammarlab.runs.scoring.events import MAX_MODELS
from grammarlab.runs.scoring.store import SUFFIX, Store
from grammarlab.runs.scoring.tasks import Factors


def read_labels_or_session(path: Path) -> tuple[Labels, Pool | None]:
    """The labels of a label file, or of a session file (.db) with the pool that its models are from.

    Raises:
        UsageError: when it ends in something else.
        AssetError: when it is missing, too large or broken.
    """
    if path.suffix.lower() != SUFFIX:
        return read_labels(path), None
    with closing(Store.open(path)) as store:
        about = store.about
        return labels_of(store.record.factors, about.hash), Pool(about.seed, about.size, store.record.wide)


def labels_of(factors: Factors, grammar: str) -> Labels:
    """All scores, in the order of factors and models.

    Args:
        factors: of a session.
        grammar: SHA-256 of its grammar.
    """
    hashes = hashes_of(grammar)
    rows = []
    for factor, scores in factors.items():
        for text, score in scores.items():
            rows.append(Address.parse(text).label(factor, score, hashes))
    return Labels(tuple(rows))


def scores_of(labels: Labels, grammar: str) -> Factors:
    """Labels as scores by factor and address; of two scores of one model for one factor the later one counts.

    Args:
        labels: any.
        grammar: SHA-256 of the grammar that they should be about.

    Raises:
        UsageError: when they are about another grammar, about other footprints or attributes, or too many.
    """
    hashes = hashes_of(grammar)
    if not len(labels):
        raise UsageError("there are no labels in the file.")
    if len(labels) > MAX_MODELS:
        raise UsageError(f"{len(labels):,} labels; {MAX_MODELS:,} can be imported at once. Split the file.")
    found: Factors = {}
    for label in labels:
        if label.kind != "score":
            raise UsageError(
                f"labels of the kind {label.kind} cannot be imported: a session holds scores from 0 to 100. Learn from "
                "the file itself, with grammarlab learn --labels."
            )
        if label.grammar not in hashes:
            raise UsageError(
                f"labels about another grammar: expected {grammar[:16]}…, found {label.grammar[:16]}…. Import labels "
                "of models of this session's grammar."
            )
        if label.start_rule or label.attributes != "{}" or label.footprint:
            raise UsageError(
                "labels of models with a start rule, attributes or a footprint of their own cannot be imported: a "
                "session is about models of the rule file as it is."
            )
        found.setdefault(label.factor, {})[str(Address.of(label, hashes))] = float(label.score)
    return found
