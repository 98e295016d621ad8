"""Warnings about meshes that an asset folder lacks, or that cannot be looked up in it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from grammarlab.assets.meshes import find_asset
from grammarlab.derivation.forest import MissingAsset, by_path
from grammarlab.errors import AssetError, Finding, MissingAssetError
from grammarlab.language.syntax.tree import Attribute, Choice, Invoke, Name, RuleFile, String
from grammarlab.language.syntax.walking import walk


def warnings_of(missing: Iterable[MissingAsset], assets: Path) -> tuple[Finding, ...]:
    """One finding for each missing mesh.

    Args:
        missing: the meshes.
        assets: the searched folder.
    """
    return tuple(
        Finding(
            "warning",
            "missing-asset",
            f'there is no asset "{asset.path}" in the asset folder {assets}; a box stands in its place',
            asset.location,
            "say where the meshes are with --assets DIR",
        )
        for asset in missing
    )


def findings_about(tree: RuleFile, assets: Path) -> tuple[Finding, ...]:
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
        if isinstance(node, Invoke) and node.name == "i" and node.arguments
        for path in _path(node.arguments[0], texts)
    )
    return tuple(finding for asset in named for finding in _findings(asset, assets))


def _path(argument: Choice, texts: dict[str, Choice]) -> Iterator[str]:
    value = texts.get(argument.identifier) if isinstance(argument, Name) else argument
    if isinstance(value, String) and not value.value.startswith("builtin:"):
        yield value.value


def _findings(asset: MissingAsset, assets: Path) -> tuple[Finding, ...]:
    try:
        find_asset(asset.path, assets)
    except MissingAssetError:
        return warnings_of([asset], assets)
    except AssetError as error:
        hint = "models that insert it fail: correct the path, or put another file there"
        return (Finding("warning", "bad-asset", str(error), asset.location, hint),)
    return ()
