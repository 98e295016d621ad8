"""Templates by name: shipped ones, or those of a file."""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache
from pathlib import Path

from grammarlab.about import PACKAGE
from grammarlab.errors import UsageError
from grammarlab.facade.templates.template import Template
from grammarlab.facade.templates.text.parsing import MOST_CHARACTERS, parse_templates
from grammarlab.facade.templates.text.rules import templates_of_rules
from grammarlab.files import existing

BASIC = ("rectangle", "arch", "segment_arch", "gable", "pointed_arch", "circle", "trapezium", "cross_window")
SUFFIX = ".template"


@cache
def shipped() -> tuple[Template, ...]:
    """The templates that come with the package."""
    inside = PACKAGE / "grammars"
    folder = inside if inside.is_dir() else PACKAGE.parent / "grammars"
    path = folder / "templates" / f"library{SUFFIX}"
    return parse_templates(path.read_text(encoding="utf-8"), path.name)


def named(names: str) -> tuple[Template, ...]:
    """Templates from comma-separated names or files; `basic` and `all` are shipped lists.

    Raises:
        UsageError: If a name is unknown; with the nearest ones. If a file is too long or not text.
        LanguageError: If a file does not have the format.
        FacadeError: If rules make no template.
    """
    known: dict[str, list[Template]] = {}
    for template in shipped():
        known.setdefault(template.base, []).append(template)
    found: dict[str, Template] = {}
    for name in [each.strip() for each in (names or "basic").split(",") if each.strip()]:
        if name == "all":
            chosen = list(shipped())
        elif name == "basic":
            chosen = [template for each in BASIC for template in known[each]]
        elif name in known:
            chosen = known[name]
        elif (file := existing(name)) is not None and file.is_file():
            reader = templates_of_rules if file.suffix.lower() == ".cga" else parse_templates
            chosen = list(reader(_text(file), file.name))
        else:
            near = get_close_matches(name, [*known, "all", "basic"], 3)
            hint = f"; did you mean {' or '.join(near)}?" if near else ""
            raise UsageError(f"--templates: no file or shipped template has the name {name!r}{hint}")
        found |= {template.name: template for template in chosen}
    if not found:
        raise UsageError("--templates: expected comma-separated names or files, found none.")
    return tuple(found.values())


def _text(path: Path) -> str:
    with path.open("rb") as file:
        content = file.read(4 * MOST_CHARACTERS + 1)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UsageError(f"{path.name}: expected text in UTF-8.") from error
