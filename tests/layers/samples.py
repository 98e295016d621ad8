"""Designs for tests, with small changes."""

from pathlib import Path

from grammarlab.layers.design import Design
from grammarlab.layers.file import parse_design

DESIGNS = Path(__file__).parents[2] / "grammars" / "facades"
RESIDENTIAL = (DESIGNS / "residential.toml").read_text(encoding="utf-8")


def residential(changes: dict[str, str] | None = None) -> Design:
    """The shipped house, with pieces of its text replaced."""
    text = RESIDENTIAL
    for old, new in (changes or {}).items():
        assert old in text
        text = text.replace(old, new)
    return parse_design(text)


def design(patterns: dict[str, str], symbols: str, width: float, height: float = 3.0, counters: str = "") -> Design:
    """One layer per pattern along x, from the top down, over one storey `Y`; named as the patterns are.

    Args:
        patterns: texts of patterns by name of the layer.
        symbols: lines of the table of symbols.
        width: width of the canvas.
        height: height of the canvas, and of the storey.
        counters: lines of the table of counters.
    """
    layers = "".join(f'[[layers]]\nname = "{name}"\nx = "{text}"\ny = "Y"\n' for name, text in patterns.items())
    return parse_design(
        f"canvas = {{ width = {width}, height = {height} }}\n[symbols]\nY = {height}\n{symbols}\n"
        f"[counters]\n{counters}\n{layers}"
    )
