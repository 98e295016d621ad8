"""Documents of the repository as pages of the site, with links that work there."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]

_LINK = re.compile(r"(?P<mark>!?)\[(?P<text>(?:[^\[\]]|\[[^\]]*\])*)\]\((?P<target>[^()\s#:]+)(?P<anchor>#[^()\s]*)?\)")
_CODE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
"""Links in code blocks are left alone. Code within a line may be the text of a link."""


def pages() -> dict[str, str]:
    """Path in the site of every document outside `docs/`, by its path in the repository."""
    found = {"README.md": "index.md"}
    for name in ("ARCHITECTURE", "CHANGELOG", "CONTRIBUTING"):
        found[f"{name}.md"] = f"project/{name}.md"
    inside = sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("grammarlab/**/README.md"))
    inside += sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("scenarios/**/README.md"))
    for path in [*inside, "benchmarks/README.md"]:
        if "node_modules" not in path:
            found[path] = f"project/{posixpath.dirname(path).replace('/', '-')}.md"
    return found


def linked(text: str, source: str, target: str, documents: Mapping[str, str]) -> str:
    """The text of a document with its links as they are on the site.

    A link to a file of the repository that is not on the site becomes the path of the file. A broken link is kept;
    the strict build reports it.

    Args:
        text: Markdown.
        source: path of the document in the repository.
        target: path of its page in the site.
        documents: the result of `pages`.
    """

    def link(match: re.Match[str]) -> str:
        file = posixpath.normpath(posixpath.join(posixpath.dirname(source), match["target"]))
        page = documents.get(file) or documents.get(f"{file}/README.md")
        if page is None and file.startswith("docs/"):
            page = file.removeprefix("docs/")
        if page is not None:
            there = posixpath.relpath(page, posixpath.dirname(target) or ".")
            return f"{match['mark']}[{match['text']}]({there}{match['anchor'] or ''})"
        if (ROOT / file).exists():
            name = match["text"].strip("`").rstrip("/")
            return f"`{file}`" if name in {file, match["target"].rstrip("/")} else f"{match['text']} (`{file}`)"
        return match[0]

    parts, end = [], 0
    for code in _CODE.finditer(text):
        parts += [_LINK.sub(link, text[end : code.start()]), code[0]]
        end = code.end()
    return "".join([*parts, _LINK.sub(link, text[end:])])
