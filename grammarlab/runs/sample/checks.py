"""Checks of a file and its asset files for a run: unsupported features, missing meshes, changed files."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

from grammarlab.asset_roots import AssetRoot, library_of, place_of
from grammarlab.assets.mesh_files import find_asset
from grammarlab.derivation.expressions import VOCABULARY
from grammarlab.derivation.forest import MissingAsset, by_path
from grammarlab.derivation.functions import BUILTINS, SHAPE_ATTRIBUTES
from grammarlab.derivation.functions.asset_functions import matching_files, names_below
from grammarlab.derivation.functions.shape_attributes import KEY_ATTRIBUTES
from grammarlab.derivation.operations import BLOCKS, LEFT_OUT, OPERATIONS
from grammarlab.errors import AssetError, Finding, LanguageError, MissingAssetError, UnreadableAssetError, UsageError
from grammarlab.features.accepted_models import annotations_of
from grammarlab.files import file_hash
from grammarlab.language.checking.check import CheckedFile, SupportedFeatures, check, check_files
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.builtins import attributes
from grammarlab.language.syntax.syntax_tree import Attribute, Choice, Invoke, Name, RuleFile, String, walk
from grammarlab.runs.sample.domains import DEFAULT, CheckedText, domain_of, opened_models, suffix_of
from grammarlab.runs.sample.shipped import RuleSource

if TYPE_CHECKING:
    from grammarlab.runs.sample.request import SampleRequest

_KEYWORDS = {
    **{name: operation.keywords for name, operation in OPERATIONS.items()},
    **{name: block.keywords | block.selectors for name, block in BLOCKS.items()},
    **{name: function.keywords for name, function in BUILTINS.items()},
}
_IMMEDIATE = frozenset({"inline", "intersect", "subtract", "union"})
_MATERIAL = frozenset(name for name in SHAPE_ATTRIBUTES if name.startswith("material."))
SUPPORTED = SupportedFeatures(
    operations=(frozenset(OPERATIONS) - LEFT_OUT) | frozenset(BLOCKS) | _IMMEDIATE | {"NIL"},
    functions=frozenset(BUILTINS) | {"sel"},
    attributes=frozenset(SHAPE_ATTRIBUTES),
    keywords=frozenset(f"{name}:{word}" for name, words in _KEYWORDS.items() for word in words),
    constructs=frozenset({"array", "comp-function", "connected", "element-wise", "import", "variables"}),
    harmless=LEFT_OUT
    | frozenset(name for name in attributes() if name.startswith("material.") and name not in _MATERIAL),
)
"""Features that derivations support."""


def hash_assets(request: SampleRequest) -> dict[str, str]:
    """SHA-256 of the asset files named in a request, by path relative to its asset folder.

    These are the files whose names, or patterns with ``*`` and ``?``, are strings in the rules, items of lists with
    semicolons, or values of attributes; the buffers of glTF files among them; and all files that a name may mean
    which rules build from parts. Names in tables that rules read are not included.

    Raises:
        LanguageError: If the rules have errors.
    """
    files = named_files(_texts(request), request.assets)
    return {name: file_hash(files[name]) for name in sorted(files)}


def named_files(texts: Iterable[str], assets: AssetRoot) -> dict[str, Path]:
    """Files of an asset folder named in texts, by path relative to it.

    Args:
        texts: names, patterns with ``*`` and ``?``, or lists of both with semicolons; other texts are ignored.
        assets: the folder.
    """
    names = {name: None for text in texts for name in text.split(";")}
    list_names = cache(names_below)  # for all patterns: a folder may have 20,000 files
    return {place_of(file, assets).name: file for name in names for file in _files(name, assets, list_names)}


def first_difference(before: Mapping[str, str], now: Mapping[str, str]) -> str:
    """Description of a difference between the asset files of two runs; empty if there is none."""
    for name in sorted({*before, *now}):
        if before.get(name) != now.get(name):
            what = "is missing" if name not in now else "is new" if name not in before else "has changed"
            return f"the asset {name!r} {what}"
    return ""


def check_source(source: RuleSource) -> Sequence[CheckedText]:
    """Findings about a file that describes models, then about each further file that it needs.

    Raises:
        LanguageError: If the file cannot be read, or is too large.
    """
    if source.choices.library is not None and suffix_of(source.path) == DEFAULT:
        return check_rules(source.path, source.assets, source.choices.library)
    return domain_of(suffix_of(source.path)).check(source.path, source.assets)


def check_rules(path: Path, assets: AssetRoot, library: Path | str | None = None) -> tuple[CheckedFile, ...]:
    """Findings about a rule file and its imports, including unsupported features and missing meshes.

    Args:
        path: the rule file.
        assets: folder of its assets.
        library: a folder of further projects that it imports from.

    Raises:
        LanguageError: If the file cannot be read, or is too large.
    """
    checked = check_files(path, str(path), SUPPORTED, library=library)
    return tuple(replace(file, findings=_with_assets(file, assets)) for file in checked)


def warnings_of(missing: Iterable[MissingAsset], assets: AssetRoot) -> tuple[Finding, ...]:
    """One finding for each mesh that is missing or cannot be read.

    Args:
        missing: the meshes.
        assets: the searched folder.
    """
    return tuple(_warning_of(asset, assets) for asset in missing)


def _warning_of(asset: MissingAsset, assets: AssetRoot) -> Finding:
    if asset.reason:
        message, hint = f"{asset.reason}; a box stands in its place", "put another file there"
        return Finding("warning", "bad-asset", message, asset.location, hint)
    message = f'there is no asset "{asset.path}" in the asset folder {assets}; a box stands in its place'
    hint = "say where the meshes are with `assets=DIR`"
    if asset.path.startswith("/") and library_of(assets) is None:
        hint += ", and the projects of others with `library=DIR`"
    return Finding("warning", "missing-asset", message, asset.location, hint)


def grammar_to_run(text: str, file: str) -> Grammar:
    """Grammar of a rule file without errors.

    Unsupported features are allowed: many rule files have some that no model reaches, and a derivation that reaches
    one raises an error.

    Raises:
        LanguageError: If there are errors; it lists all of them.
    """
    grammar = Grammar.parse(text, file)
    findings = (*check(grammar, SUPPORTED), *_acceptance(grammar.tree))
    errors = tuple(finding for finding in findings if finding.severity == "error")
    if errors:
        raise LanguageError(errors, text)
    return grammar


def draws_nothing(text: str) -> bool:
    """Whether a rule file has no word that draws at random, so that all its models on a lot are equal.

    Words in comments count as well: then a file may be said to draw although it does not.

    >>> draws_nothing("Lot --> extrude(3)"), draws_nothing("Lot --> extrude(rand(3, 9))")
    (True, False)
    """
    drawing = "|".join(VOCABULARY.draws | KEY_ATTRIBUTES | {"scatter"})
    return re.search(rf"%|\b(?:{drawing})\b", text) is None


def unsupported_features(grammar: Grammar) -> tuple[Finding, ...]:
    """Features of a grammar that a derivation ignores or does not support, and operations that it does not know."""
    findings = (
        finding
        for finding in check(grammar, SUPPORTED)
        if finding.severity == "unsupported" or finding.code in ("left-out", "unknown-symbol")
    )
    return (*unread_imports(grammar), *findings)


def unread_imports(grammar: Grammar) -> tuple[Finding, ...]:
    """The imports that are left in the text from `AbstractDomain.read`, since they cannot be read."""
    return tuple(
        Finding("unsupported", "bad-import", f'the import "{statement.path}", which cannot be read', statement.location)
        for statement in grammar.imports.values()
    )


def _files(name: str, assets: AssetRoot, list_names: Callable[[Path, str], list[str]]) -> Iterator[Path]:
    """Files of the asset folder that match a name or pattern, with the buffers of glTF files."""
    for path in matching_files(assets, name, list_names) if "*" in name or "?" in name else [name]:
        file = _asset(path, assets)
        if file is None:
            continue
        yield file
        if file.suffix.lower() == ".gltf":
            folder = Path(place_of(file, assets).name).parent
            yield from filter(None, (_asset(str(folder / uri), assets) for uri in _buffers(file)))


def _asset(name: str, assets: AssetRoot) -> Path | None:
    try:
        return find_asset(name, assets)
    except AssetError:
        return None


def _buffers(file: Path) -> list[str]:
    """Names of the buffers in a glTF file; none for a broken file, which no model can use."""
    try:
        return [unquote(buffer["uri"]) for buffer in json.loads(file.read_bytes())["buffers"]]
    except (ValueError, LookupError, TypeError, RecursionError):
        return []


def _texts(request: SampleRequest) -> Iterator[str]:
    """Every string that may name an asset file."""
    yield from opened_models(request.suffix, request.text, request.name, request.assets).asset_names()
    for values in (request.attributes, *(footprint.properties for footprint in request.footprints)):
        yield from (value for value in values.values() if isinstance(value, str))


def _with_assets(file: CheckedFile, assets: AssetRoot) -> tuple[Finding, ...]:
    findings = (*file.findings, *_findings_about(file.tree, assets), *_acceptance(file.tree))
    return tuple(sorted(findings, key=lambda finding: finding.location))


def _findings_about(tree: RuleFile, assets: AssetRoot) -> tuple[Finding, ...]:
    """One finding for each mesh named by ``i`` in a rule file that is missing or cannot be inserted.

    Names are literals at the operation, or the values of its attributes and constants. Names that rules build from
    parts are known only during the derivation.

    Args:
        tree: the rule file.
        assets: the searched folder.
    """
    texts = {d.name: d.value for d in tree.definitions if isinstance(d, Attribute)}
    named = by_path(
        MissingAsset(path, node.location)
        for node in walk(tree)
        if isinstance(node, Invoke) and len(node.arguments) > _PATH_OF.get(node.name, len(node.arguments))
        for path in _path(node.arguments[_PATH_OF[node.name]], texts)
    )
    return tuple(finding for asset in named for finding in _findings(asset, assets))


_PATH_OF = {"i": 0, "insertAlongUV": 1}
"""Which argument of an operation is the path of a mesh."""


def _path(argument: Choice, texts: dict[str, Choice]) -> Iterator[str]:
    value = texts.get(argument.identifier) if isinstance(argument, Name) else argument
    if isinstance(value, String) and not value.value.startswith("builtin:"):
        yield value.value


def _findings(asset: MissingAsset, assets: AssetRoot) -> tuple[Finding, ...]:
    try:
        find_asset(asset.path, assets)
    except MissingAssetError:
        return warnings_of([asset], assets)
    except UnreadableAssetError as error:
        return warnings_of([replace(asset, reason=str(error))], assets)
    except AssetError as error:
        hint = "models that insert it fail: correct the path, or put another file there"
        return (Finding("warning", "bad-asset", str(error), asset.location, hint),)
    return ()


def _acceptance(tree: RuleFile) -> tuple[Finding, ...]:
    """Findings about an acceptance rule."""
    if not annotations_of(tree):
        return ()
    from grammarlab.features.acceptance import Acceptance  # noqa: PLC0415  # few grammars have a rule

    try:
        Acceptance.of(tree)
    except UsageError as error:
        return (Finding("error", "bad-acceptance", str(error), annotations_of(tree)[0].location),)
    return ()
