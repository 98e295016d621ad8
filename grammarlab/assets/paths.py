"""Candidates in an asset folder for a path in a rule.

CityEngine resolves ``assets/trees/oak.obj`` from the root of a project, and ``/City/assets/trees/oak.obj`` from the
root of a workspace of projects. Here there is one asset folder, so the folders above it are removed from such a path.
"""

from __future__ import annotations

_PROJECT_FOLDERS = frozenset({"assets", "data", "images", "maps", "models"})
_MOST = 12


def meanings(path: str) -> list[str]:
    """Candidates, relative to the asset folder, for a path in a rule, most likely first.

    >>> meanings("trees/oak.obj"), meanings("assets/trees/oak.obj"), meanings("/City/assets/oak.obj")
    (['trees/oak.obj'], ['assets/trees/oak.obj', 'trees/oak.obj'], ['City/assets/oak.obj', 'assets/oak.obj', 'oak.obj'])
    """
    parts = path.lstrip("/").split("/")
    if ".." in parts:
        return ["/".join(parts)]
    above = len(parts) - 1 if path.startswith("/") else int(len(parts) > 1 and parts[0] in _PROJECT_FOLDERS)
    return ["/".join(parts[first:]) for first in range(min(above, _MOST) + 1)]
