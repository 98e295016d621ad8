"""Opening of a session: the file of its models, the session file, and a check that they match."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import LanguageError, UsageError
from grammarlab.extras import require
from grammarlab.language.grammar import Grammar
from grammarlab.language.presets import NO_CHOICES, RuleChoices, preset_differences
from grammarlab.learning.settings import POOL_SIZE
from grammarlab.pages.record.store import SUFFIX, About, Store
from grammarlab.runs.sample.domains import DEFAULT, domain_of
from grammarlab.runs.sample.shipped import find_rules

_MAX_DIFFERENCES = 4
"""Differences between two rule files that a message names."""


@dataclass(frozen=True, slots=True)
class Opening:
    """Inputs of a session."""

    path: Path
    about: About
    store: Store | None
    """None for a new session, whose file is made after the grammar has been checked."""
    assets: AssetRoot
    """Folder of the assets named in the file."""
    has_usual_size: bool = False
    """Whether a new session gets the usual pool of its designs, whose size is known once the file has been opened."""


def open_session(
    grammar: str,
    path: Path,
    *,
    seed: int = 0,
    size: int | None = None,
    assets: Path | None = None,
    choices: RuleChoices = NO_CHOICES,
    stored_grammar: bool = False,
) -> Opening:
    """Open a session file, or prepare a new one.

    Args:
        grammar: a rule file, a species of trees, or the name of a shipped one.
        path: the session file; created if missing.
        seed: seed of the models of a new session.
        size: size of the pool of a new session; by default the usual one of its designs.
        assets: folder of meshes and images, if it is not the one beside the file.
        choices: choices of the user for a rule file; with a stored grammar only the library, for its assets.
        stored_grammar: use the grammar stored in the session, even if the file has changed.

    Raises:
        UsageError: If the session was created with another grammar, or an argument is out of range.
        LanguageError: If the file cannot be read.
        AssetError: If the file is not a session.
    """
    _check(path, seed, size)
    if stored_grammar and choices.changes_text:
        raise UsageError(
            f"{path}: a stored grammar has the start rule, style and attributes that the session was begun with; leave "
            "out either these choices or `stored_grammar=True`."
        )
    source = find_rules(grammar, assets, choices)
    text = source.text().removeprefix("\ufeff")
    title = re.sub(r"[^\w ().-]", "_", source.name)[:200]
    about = About(title, text, seed, POOL_SIZE if size is None else size, source.suffix)
    if not path.exists():
        if stored_grammar:
            raise UsageError(f"{path}: no such session, so it has no stored grammar; leave `stored_grammar=True` out.")
        return Opening(path, about, None, source.assets, size is None)
    store = Store.open(path, about)
    try:
        domain_of(store.about.suffix)
    except UsageError as error:
        store.close()
        raise UsageError(f"{path}: the session is about models of another kind. {error}") from error
    if (store.about.hash, store.about.suffix) != (about.hash, about.suffix) and not stored_grammar:
        old_hash, differences = store.about.hash, _differences(store.about, about)
        store.close()
        raise UsageError(
            f"{path}: this session is about another grammar than {source.path}: expected the text with SHA-256 "
            f"{old_hash[:16]}…, found {about.hash[:16]}….{differences} Its scores belong to the models of the "
            "grammar that it was begun with. To go on with that one, give --stored-grammar (in Python, "
            "stored_grammar=True), which reads the text that the session keeps; to score models of the new one, begin "
            "a session with another file name. The old scores stay in the file and can be exported from its page."
        )
    return Opening(path, store.about, store, source.assets)


def _differences(before: About, now: About) -> str:
    """Sentence about start rules and values of attributes that differ; empty for other differences, and for trees."""
    if {before.suffix, now.suffix} != {DEFAULT}:
        return ""
    try:
        differences = preset_differences(*(Grammar.parse(about.grammar) for about in (before, now)))
    except LanguageError:  # an earlier version may have read what this one does not
        return ""
    rest = f" and {len(differences) - _MAX_DIFFERENCES} more" if len(differences) > _MAX_DIFFERENCES else ""
    if not differences:
        return ""
    return f" They differ in: {'; '.join(differences[:_MAX_DIFFERENCES])}{rest}. The same choices open it again."


def _check(path: Path, seed: int, size: int | None) -> None:
    require("jax")
    if path.suffix.lower() != SUFFIX:
        raise UsageError(f"{path}: expected the name of a session file that ends in {SUFFIX}.")
    if not path.parent.is_dir():
        raise UsageError(f"{path}: there is no folder {str(path.parent)!r}; make it first.")
    if not 0 <= seed < 1 << 64:
        raise UsageError(f"seed is {seed}; expected 0 <= seed < 2**64.")
    if size is not None and not 1 <= size <= 100_000:
        raise UsageError(f"size is {size}; expected 1 to 100,000 models.")
