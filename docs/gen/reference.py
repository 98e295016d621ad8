"""Generated parts of the documentation, which are kept in the repository: `python -m docs.gen.reference` writes them.

A part stands between two comments, `<!-- generated: NAME -->` or `<!-- generated: NAME ARGUMENT -->`, and
`<!-- end of generated -->`. The text comes from one of `GENERATORS`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

from docs.gen import api, cga, cga_reference, commands, formats, tree_parameters

DOCS = Path(__file__).parents[1]

GENERATORS: Mapping[str, Callable[..., str]] = {
    "api": api.sections,
    "cga": cga.tables,
    "commands": commands.overview,
    "formats": formats.table,
    "functions": cga_reference.functions,
    "measures": tree_parameters.measures,
    "operations": cga_reference.operations,
    "options": commands.options,
    "trees": tree_parameters.sections,
}
END = "<!-- end of generated -->"
_PART = re.compile(
    rf"^(?P<start><!-- generated: (?P<name>\w+)(?: (?P<argument>[^>]+))? -->)$.*?^{END}$", re.MULTILINE | re.DOTALL
)


def filled(text: str) -> str:
    """The text of a page with its generated parts made again."""

    def part(match: re.Match[str]) -> str:
        made = GENERATORS[match["name"]](*filter(None, [match["argument"]]))
        return f"{match['start']}\n\n{made}\n\n{END}"

    return _PART.sub(part, text)


def pages() -> dict[Path, str]:
    """Pages with generated parts and their text, and a page for each command that has none."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(DOCS.rglob("*.md"))}
    for name, command in commands.commands().items():
        start = f"# grammarlab {name}\n\n{command.help}\n\n<!-- generated: options {name} -->\n{END}\n"
        texts.setdefault(DOCS / "commands" / commands.page_of(name), start)
    return {path: filled(text) for path, text in texts.items() if _PART.search(text)}


if __name__ == "__main__":
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8", newline="\n")
