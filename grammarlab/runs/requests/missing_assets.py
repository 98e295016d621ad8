"""Warnings about meshes that an asset folder lacks."""

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


def missing_in(tree: RuleFile, assets: Path) -> tuple[MissingAsset, ...]:
    """Meshes named by ``i`` in a rule file that an asset folder lacks, by path.

    Names are literals at the operation, or the values of its attributes and constants. Names that rules build from
    parts are known only during the derivation.
    """
    texts = {d.name: d.value for d in tree.definitions if isinstance(d, Attribute)}
    named = [
        MissingAsset(path, node.location)
        for node in walk(tree)
        if isinstance(node, Invoke) and node.name == "i" and node.arguments
        for path in _path(node.arguments[0], texts)
    ]
    lacking = {path for path in {asset.path for asset in named} if _lacks(assets, path)}
    return by_path(asset for asset in named if asset.path in lacking)


def _path(argument: Choice, texts: dict[str, Choice]) -> Iterator[str]:
    value = texts.get(argument.identifier) if isinstance(argument, Name) else argument
    if isinstance(value, String) and not value.value.startswith("builtin:"):
        yield value.value


def _lacks(assets: Path, path: str) -> bool:
    try:
        find_asset(path, assets)
    except MissingAssetError:
        return True
    except AssetError:
        return False
    return False
