"""Optional packages, and the error for a missing one."""

from __future__ import annotations

import platform
import sys
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
    "pyogrio": "city",
    "pyproj": "city",
    "rasterio": "city",
    "distributed": "cluster",
    "dask": "cluster",
    "fsspec": "cluster",
    "pxr": "usd",
    "anywidget": "notebook",
    "traitlets": "notebook",
}
"""Extra of grammarlab that installs each package."""


_WITHOUT_JAX = {("darwin", "x86_64"): "Intel Macs", ("win32", "ARM64"): "Windows on ARM"}
"""Machines for which there is no jaxlib of a version that the extra `learn` needs; see `docs/platforms.md`."""


def _advice(package: str) -> str:
    machine = _WITHOUT_JAX.get((sys.platform, platform.machine()))
    if machine and package in {"jax", "jaxlib"}:
        return (
            f"this needs the package {package}, and for {machine} there is no version that grammarlab can use. "
            "Learn on another machine; the learned rules can be sampled on this one."
        )
    return f"this needs the package {package}, which is not installed: pip install 'grammarlab[{EXTRAS[package]}]'."


@contextmanager
def named_extras() -> Iterator[None]:
    """Context in which a missing package of `EXTRAS` raises an error that names the extra to install.

    Raises:
        UsageError: Instead of the ModuleNotFoundError of a package of `EXTRAS`.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in EXTRAS:
            raise
        raise UsageError(_advice(package)) from error


def require(package: str) -> None:
    """Check that a package of `EXTRAS` is installed, without importing it.

    Raises:
        UsageError: If it is not installed.
    """
    with named_extras():
        if find_spec(package) is None:
            raise ModuleNotFoundError(name=package)
