"""Names of the parameters and measures that acceptance rules and learning read of a tree."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.features.patterns.conditions import sites_of
from grammarlab.features.patterns.pattern import Draw, Feature
from grammarlab.trees.parameters import COLUMN


def check_names(features: Sequence[Feature], names: Sequence[str]) -> None:
    """Check that features read only some names.

    Raises:
        UsageError: If a feature has another name, or counts parts of a derivation.
    """
    for feature in features:
        sites = sites_of(feature)
        if not sites or (isinstance(feature, Draw) and feature.branch is not None):
            raise UsageError(
                f"{feature}: trees have no symbols to count; expected a parameter or a measure, such as $ratio."
            )
        for site in sites:
            if site not in names:
                near = get_close_matches(site, names, n=3, cutoff=0.5)
                hint = f"did you mean {' or '.join(f'${name}' for name in near)}?" if near else "see the table of them."
                raise UsageError(f"${site} is neither a parameter nor a measure of trees; {hint}")


def parameters(rows: Floats) -> dict[str, Floats]:
    """The columns [n] of parameters [n, P] by name."""
    return {name: rows[:, index] for name, index in COLUMN.items()}
