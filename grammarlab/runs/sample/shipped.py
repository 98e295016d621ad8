"""Shipped rule files and species, and the files of GRAMMAR arguments."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

from grammarlab.about import PACKAGE
from grammarlab.asset_roots import AssetRoot, asset_root
from grammarlab.errors import AssetError, TomlError, UsageError, check_type
from grammarlab.files import read_bounded
from grammarlab.language.grammar import Grammar, read_text
from grammarlab.language.importing import RULES, rules_folder
from grammarlab.language.presets import NO_CHOICES, RuleChoices
from grammarlab.runs.sample.domains import CONVERTED, DEFAULT, DOMAINS, SPECIES, domain_of, suffix_of
from grammarlab.toml_text import toml_table, toml_text

SUFFIX = DEFAULT
PACKAGE_SUFFIX = ".rpk"
_SPECIES_FOLDER, _FACADE_FOLDER = "species", "facades"
_MAX_SPECIES_BYTES = 1 << 20
"""Largest size in bytes of a species that is described."""


@dataclass(frozen=True, slots=True)
class RuleSource:
    """A rule file, a species or another file that describes models, with its assets."""

    name: str
    """Name for output files, such as ``building``."""
    path: Path
    assets: AssetRoot
    """Folder of the assets that it names, with the library that the user chose."""
    shipped: bool
    """Whether it is a shipped example."""
    choices: RuleChoices = NO_CHOICES
    """Choices of the user for a rule file."""

    def text(self) -> str:
        """Text of the file merged with its imports, or converted (`domains.CONVERTED`).

        Raises:
            LanguageError: If it cannot be read or is too large, or has no such style.
            UsageError: If it has no such start rule or attribute, or a value has another type than its attribute.
        """
        text = domain_of(suffix_of(self.path)).read(self.path, self.choices.library)
        if not self.choices.changes_text:
            return text
        if suffix_of(self.path) != SUFFIX:
            raise UsageError(f"{self.path}: only {SUFFIX} files have styles, start rules and attributes to choose.")
        return self.choices.apply(Grammar.parse(text, self.file)).text

    @property
    def suffix(self) -> str:
        """Suffix of the domain of its text (`grammarlab.runs.sample.domains`)."""
        suffix = suffix_of(self.path)
        return CONVERTED.get(suffix, suffix)

    @property
    def file(self) -> str:
        """``building.cga``."""
        return f"{self.name}{suffix_of(self.path)}"

    def description(self) -> str:
        """The first sentence of the comment at the top of the file, or about a species; empty if there is none."""
        if self.suffix == SPECIES:
            return _first_sentence(_about(self.path))
        match = re.match(
            r"(?:\s|version\s*\"[^\"]*\")*(?:/\*+\s*(.*?)\*/|((?:[ \t]*(?:#|//)[^\n]*\n)+))",
            read_text(self.path),
            re.DOTALL,
        )
        if match is None:
            return ""
        comment = re.sub(r"^[ \t]*(?:\*|#|//)+[ \t]?", "", match[1] or match[2], flags=re.MULTILINE)
        return _first_sentence(comment)


def _about(path: Path) -> str:
    try:
        about = toml_table(toml_text(read_bounded(path, _MAX_SPECIES_BYTES))).get("about", "")
    except (TomlError, AssetError):
        return ""
    return about if isinstance(about, str) else ""


def _first_sentence(text: str) -> str:
    return " ".join(re.split(r"(?<=\.)\s|\n\s*\n", text.strip(), maxsplit=1)[0].split())


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


def shipped_facades() -> tuple[RuleSource, ...]:
    """All shipped rule files of facades by name; their assets are beside them."""
    folder = examples_folder() / _FACADE_FOLDER
    return tuple(RuleSource(path.stem, path, folder, shipped=True) for path in sorted(folder.glob(f"*{SUFFIX}")))


def shipped_species() -> tuple[RuleSource, ...]:
    """All shipped species by name."""
    folder = examples_folder() / _SPECIES_FOLDER
    return tuple(
        RuleSource(path.stem, path, folder / "assets", shipped=True) for path in sorted(folder.glob(f"*{SPECIES}"))
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


def find_rules(argument: str, assets: Path | None = None, choices: RuleChoices = NO_CHOICES) -> RuleSource:
    """File of a GRAMMAR argument: a path, or the name of a shipped grammar or species.

    Args:
        argument: text of the argument; a rule package is unpacked first.
        assets: the folder of assets; by default that of `assets_folder`.
        choices: choices of the user for a rule file.

    Raises:
        UsageError: If there is no such file or example; it names the nearest. If a rule package has no sources, or
            an argument has another type.
    """
    check_type("grammar", argument, (str, Path), "'house.cga'")
    check_type("choices", choices, RuleChoices, 'gl.RuleChoices(start_rule="Lot")')
    library = None if choices.library is None else Path(choices.library)
    for subject, folder in (("assets", assets), ("library", library)):
        if folder is not None and not folder.is_dir():
            raise UsageError(f"{subject} folder {str(folder)!r} is not a folder.")
    path = Path(argument)
    if path.suffix.lower() == PACKAGE_SUFFIX and path.is_file():
        from grammarlab.runs.sample.rule_packages import open_package  # noqa: PLC0415  # few runs open a package

        package = open_package(path)
        root = asset_root(assets or assets_folder(package.rules), library)
        choices = replace(choices, library=library or package.library)
        return RuleSource(path.stem, package.rules, root, shipped=False, choices=choices)
    if path.is_file():
        root = asset_root(assets or assets_folder(path), library)
        return RuleSource(path.stem, path, root, shipped=False, choices=choices)
    examples = {source.name: source for source in (*shipped_examples(), *shipped_facades(), *shipped_species())}
    if argument in examples:
        example = examples[argument]
        root = example.assets if assets is None else asset_root(assets, library)
        return RuleSource(example.name, example.path, root, shipped=True, choices=choices)
    if path.is_dir():
        raise UsageError(
            f"{argument!r} is a folder; expected a {SUFFIX} or {SPECIES} file, or one of: {', '.join(examples)}."
        )
    stem = argument.removesuffix(path.suffix) if path.suffix in DOMAINS else argument
    near = get_close_matches(stem.lower(), examples, n=1, cutoff=0.5)
    neighbours = [p.name for p in _files_beside(path)]
    near += [name for name in get_close_matches(path.name, neighbours, n=1, cutoff=0.6) if name != path.name]
    hint = f" Did you mean {' or '.join(repr(name) for name in near)}?" if near else ""
    raise UsageError(
        f"no rule file or species {argument!r}, and no shipped example of that name.{hint} "
        f"Shipped: {', '.join(examples)}."
    )


def _files_beside(path: Path) -> list[Path]:
    """Files in the folder of a path that describe models."""
    return [p for suffix in DOMAINS for p in path.parent.glob(f"*{suffix}")] if path.parent.is_dir() else []
