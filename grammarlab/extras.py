"""Packages that not everybody installs, and what to say where one is missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from grammarlab.errors import UsageError

EXTRAS = {
    "jax": "learn",
    "jaxlib": "learn",
    "sklearn": "learn",
    "matplotlib": "learn",
    "lightgbm": "rivals",
    "ortools": "solvers",
    "laspy": "scans",
    "optax": "scans",
    "tornado": "score",
    "tomlkit": "score",
    "anywidget": "notebook",
    "traitlets": "notebook",
}
"""The extra of grammarlab that installs a package."""


@contextmanager
def named_extras() -> Iterator[None]:
    """Says which extra to install, where what is imported within finds a package of `EXTRAS` missing.

    Raises:
        UsageError: in the place of the ModuleNotFoundError; that of any other package stays as it is.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in EXTRAS:
            raise
        raise UsageError(
            f"this needs the package {package}, which is not installed: pip install 'grammarlab[{EXTRAS[package]}]'."
        ) from error


def require(package: str) -> None:
    """Makes sure, without importing it, that a package of `EXTRAS` is there before work begins that needs it later.

    Raises:
        UsageError: when it is not.
    """
    with named_extras():
        if find_spec(package) is None:
            raise ModuleNotFoundError(name=package)
