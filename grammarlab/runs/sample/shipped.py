"""Shipped rule files, and the files of GRAMMAR arguments."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from grammarlab.about import PACKAGE
from grammarlab.errors import UsageError
from grammarlab.language.grammar import read_text
from grammarlab.language.importing import RULES, rules_folder
from grammarlab.runs.sample.domains import domain_of, suffix_of

SUFFIX = ".cga"


@dataclass(frozen=True, slots=True)
class RuleSource:
    """A rule file with its assets."""

    name: str
    """Name for output files, such as ``building``."""
    path: Path
    assets: Path
    """Folder of the assets named in the rules."""
    shipped: bool
    """Whether it is a shipped grammar."""

    def text(self) -> str:
        """Text of the file merged with its imports.

        Raises:
            LanguageError: If it cannot be read or is too large.
        """
        return domain_of(self.suffix).read(self.path)

    @property
    def suffix(self) -> str:
        """Suffix of its domain (`grammarlab.runs.sample.domains`)."""
        return suffix_of(self.path)

    @property
    def file(self) -> str:
        """``building.cga``."""
        return f"{self.name}{self.suffix}"

    def description(self) -> str:
        """The first sentence of the comment at the top of the file; empty if there is none."""
        match = re.match(
            r"(?:\s|version\s*\"[^\"]*\")*(?:/\*+\s*(.*?)\*/|((?:[ \t]*(?:#|//)[^\n]*\n)+))",
            read_text(self.path),
            re.DOTALL,
        )
        if match is None:
            return ""
        comment = re.sub(r"^[ \t]*(?:\*|#|//)+[ \t]?", "", match[1] or match[2], flags=re.MULTILINE)
        return " ".join(re.split(r"(?<=\.)\s|\n\s*\n", comment.strip(), maxsplit=1)[0].split())


def examples_folder() -> Path:
    """Folder of the shipped rule files: inside an installed package, or beside it in a checkout.

    >>> import grammarlab as gl
    >>> gl.load(gl.examples_folder() / "toy.cga").start_rules[0].name
    'Start'
    """
    inside = PACKAGE / "grammars"
    return inside if inside.is_dir() else PACKAGE.parent / "grammars"


def shipped_examples() -> tuple[RuleSource, ...]:
    """All shipped rule files by name."""
    folder = examples_folder()
    return tuple(
        RuleSource(path.stem, path, folder / "assets", shipped=True) for path in sorted(folder.glob(f"*{SUFFIX}"))
    )


def assets_folder(rules: Path) -> Path:
    """Folder of the assets named in a rule file.

    It is the first of these that is not empty: ``assets`` beside the rule file; in a CityEngine project,
    ``assets`` beside the folder ``rules`` that the rule file is in, at whatever depth; the rule file's own folder.
    The project's is looked for nowhere else above the rule file, and not where a link leads out of the project.

    Args:
        rules: the rule file, which may not exist yet.
    """
    sibling = rules.parent / "assets"
    if _holds_anything(sibling):
        return sibling
    top = rules_folder(rules.resolve().parent)
    shared = top.parent / "assets"
    if top.name.lower() == RULES and _holds_anything(shared) and shared.resolve().is_relative_to(top.parent):
        return shared
    return rules.parent


def _holds_anything(folder: Path) -> bool:
    try:
        return next(folder.iterdir(), None) is not None
    except OSError:  # no such folder, or not readable
        return False


def find_rules(argument: str, assets: Path | None = None) -> RuleSource:
    """Rule file of a GRAMMAR argument: a path, or the name of a shipped grammar.

    Args:
        argument: text of the argument.
        assets: the folder of assets; by default that of `assets_folder`.

    Raises:
        UsageError: If there is no such file or grammar; it names the nearest.
    """
    if assets is not None and not assets.is_dir():
        raise UsageError(f"assets folder {str(assets)!r} is not a folder.")
    path = Path(argument)
    if path.is_file():
        return RuleSource(path.stem, path, assets or assets_folder(path), shipped=False)
    examples = {source.name: source for source in shipped_examples()}
    if argument in examples:
        example = examples[argument]
        return RuleSource(example.name, example.path, assets or example.assets, shipped=True)
    if path.is_dir():
        raise UsageError(f"{argument!r} is a folder; expected a {SUFFIX} file or one of: {', '.join(examples)}.")
    near = get_close_matches(argument.removesuffix(SUFFIX).lower(), examples, n=1, cutoff=0.5)
    neighbours = [p.name for p in path.parent.glob(f"*{SUFFIX}")] if path.parent.is_dir() else []
    near += [name for name in get_close_matches(path.name, neighbours, n=1, cutoff=0.6) if name != path.name]
    hint = f" Did you mean {' or '.join(repr(name) for name in near)}?" if near else ""
    raise UsageError(
        f"no rule file {argument!r}, and no shipped grammar of that name.{hint} Shipped: {', '.join(examples)}."
    )
