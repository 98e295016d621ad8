"""From the file of a facade to that of a grammar."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grammarlab.facade.grammar.exact_grammar import write_exact
from grammarlab.facade.grammar.family import STRETCH, Range, write_family
from grammarlab.facade.grammar.leaf_looks import OutlinedLeaf, store_as_assets, store_shapes
from grammarlab.facade.tree import Facade
from grammarlab.files import write_text

MIN_FACTOR, MAX_FACTOR = 0.7, 1.6
"""Default range of a size, as multiples of the facade's own size."""


@dataclass(frozen=True, slots=True)
class GrammarResult:
    """A grammar of a facade or of its family."""

    text: str
    """Text of the grammar in CGA."""
    rules: int
    exact: float | None
    """Largest difference of the sides of leaves in the derivation, metres; for a family, `WrittenFamily.error`."""
    choices: dict[str, Any] = field(default_factory=dict)
    """Ranges of a family; empty for one facade."""
    outlined: tuple[OutlinedLeaf, ...] = ()
    """Leaves whose meshes it refers to."""


def grammar_of(
    facade: Facade, widths: Range | None = None, heights: Range | None = None, stretch: float = STRETCH
) -> GrammarResult:
    """The grammar of a facade, or of its family if a range of sizes is given.

    Args:
        facade: the facade.
        widths: metres; a range around its own width if only heights are given.
        heights: metres; a range around its own height if only widths are given.
        stretch: largest relative difference of equal elements.

    Raises:
        FacadeError: If there is no such grammar.

    >>> import grammarlab as gl
    >>> arcade = gl.load_facade(gl.examples_folder() / "facades" / "arcade.json")
    >>> gl.Grammar.parse(gl.facade_grammar(arcade).text).start_rules[0].name
    'Lot'
    """
    if widths is None and heights is None:
        written = write_exact(facade)
        return GrammarResult(written.text, written.rules, written.error, outlined=written.outlined)
    family = write_family(
        facade,
        widths or (MIN_FACTOR * facade.width, MAX_FACTOR * facade.width),
        heights or (MIN_FACTOR * facade.height, MAX_FACTOR * facade.height),
        stretch,
    )
    narrowest, widest = (pick(size for sizes in family.columns.values() for size in sizes) for pick in (min, max))
    choices = {
        "columns": [min(family.columns), max(family.columns)],
        "widths": [narrowest, widest],
        "rows": {name: list(often) for name, often in family.rows.items()},
        "facades": family.facades,
    }
    return GrammarResult(family.text, family.rules, family.error, choices, family.outlined)


def save_grammar(result: GrammarResult, facade: Facade, path: Path) -> None:
    """Write a grammar, and the pictures and meshes that it refers to into the folder of its assets.

    Raises:
        FacadeError: If a file with the name of a picture has other content.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    if facade.pictures or result.outlined:
        assets = path.parent / "assets"
        assets.mkdir(exist_ok=True)
        store_as_assets(facade, assets)
        store_shapes(result.outlined, assets)
    write_text(path, result.text)
