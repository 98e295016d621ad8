"""Table of `docs/platforms.md`: which machines have wheels of everything that grammarlab needs.

Asks the package index, through pip, for each requirement of `pyproject.toml`; nothing is downloaded or installed:

    .venv/bin/python -m docs.gen.platforms
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "platforms.md"
PYTHONS = ("3.11", "3.12", "3.13")
CORE = "core"
EXTRAS = ("learn", "score", "notebook", "scans", "solvers", "rivals", "city", "cluster", "usd", "gl")
CARRIED = {"jax": "jaxlib", "laspy": "lazrs"}
"""Compiled parts of packages that are not compiled themselves; the part of jax has the versions of jax."""
START, END = "<!-- the table: docs/gen/platforms.py -->", "<!-- end of the table -->"
THREADS = 4


@dataclass(frozen=True, slots=True)
class Machine:
    """A kind of machine."""

    name: str
    tags: tuple[str, ...]
    """Platforms of wheels that run on it."""
    markers: Mapping[str, str] = field(hash=False)
    """What markers of requirements see there."""


def _linux(processor: str) -> tuple[str, ...]:
    return (*(f"manylinux_2_{minor}_{processor}" for minor in range(28, 16, -1)), f"manylinux2014_{processor}")


MACHINES = (
    Machine("Linux, x86-64", _linux("x86_64"), {"sys_platform": "linux", "platform_machine": "x86_64"}),
    Machine("Linux, ARM", _linux("aarch64"), {"sys_platform": "linux", "platform_machine": "aarch64"}),
    Machine(
        "Alpine Linux, x86-64",
        ("musllinux_1_2_x86_64", "musllinux_1_1_x86_64"),
        {"sys_platform": "linux", "platform_machine": "x86_64"},
    ),
    Machine("macOS, Apple silicon", ("macosx_14_0_arm64",), {"sys_platform": "darwin", "platform_machine": "arm64"}),
    Machine("macOS, Intel", ("macosx_14_0_x86_64",), {"sys_platform": "darwin", "platform_machine": "x86_64"}),
    Machine("Windows, x86-64", ("win_amd64",), {"sys_platform": "win32", "platform_machine": "AMD64"}),
    Machine("Windows, ARM", ("win_arm64",), {"sys_platform": "win32", "platform_machine": "ARM64"}),
)


def requirements(part: str, project: Mapping[str, Any] | None = None) -> list[Requirement]:
    """Requirements of the core or of an extra with the extras that it includes, and the compiled parts they carry."""
    table = project or tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    texts = table["dependencies"] if part == CORE else table["optional-dependencies"][part]
    result: list[Requirement] = []
    for requirement in map(Requirement, texts):
        if requirement.name == "grammarlab":
            result += [inner for extra in sorted(requirement.extras) for inner in requirements(extra, table)]
            continue
        result.append(requirement)
        if requirement.name in CARRIED:
            specifier = requirement.specifier if requirement.name == "jax" else ""
            result.append(Requirement(f"{CARRIED[requirement.name]}{specifier}"))
    return result


def missing(requirement: Requirement, machine: Machine) -> tuple[str, ...]:
    """Versions of Python for which a machine needs a requirement and has no wheel of it.

    Versions between two with a wheel are not asked for.
    """

    def is_missing(python: str) -> bool:
        needed = requirement.marker is None or requirement.marker.evaluate(
            {**machine.markers, "python_version": python}
        )
        return needed and not _has_wheel(requirement, machine.tags, python)

    if _has_wheel(requirement, ("none",), PYTHONS[0]):  # not compiled: one wheel for all
        return ()
    if not is_missing(PYTHONS[0]) and not is_missing(PYTHONS[-1]):
        return ()
    return tuple(filter(is_missing, PYTHONS))


@cache
def _has_wheel(requirement: Requirement, tags: Sequence[str], python: str) -> bool:
    command = [sys.executable, "-m", "pip", "index", "versions", requirement.name, "--only-binary=:all:"]
    command += ["--python-version", python, *(f"--platform={tag}" for tag in tags)]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 - our own interpreter
    versions = re.search(r"^Available versions: (.*)$", answer.stdout, re.MULTILINE)
    if versions is None and "No matching distribution" not in answer.stderr:
        raise RuntimeError(f"pip gave no answer about {requirement.name}: {answer.stderr[-300:]}")
    return bool(versions and any(requirement.specifier.contains(each) for each in versions[1].split(", ")))


Gaps = Mapping[tuple[Requirement, Machine], tuple[str, ...]]
"""Versions of Python without a wheel."""


def cell(part: str, machine: Machine, gaps: Gaps) -> str:
    """``yes``, or the packages without a wheel, with the versions of Python if others have one."""
    texts = []
    for requirement in requirements(part):
        pythons = gaps[requirement, machine]
        if pythons:
            some = f" (Python {', '.join(pythons)})" if len(pythons) < len(PYTHONS) else ""
            texts.append(f"{requirement.name}{some}")
    return f"no {', '.join(texts)}" if texts else "yes"


def table() -> str:
    """The rows of the table."""
    parts = (CORE, *EXTRAS)
    asked = {(requirement, machine) for part in parts for requirement in requirements(part) for machine in MACHINES}
    with ThreadPoolExecutor(THREADS) as pool:
        futures = {pair: pool.submit(missing, *pair) for pair in asked}
        gaps = {pair: future.result() for pair, future in futures.items()}
    lines = [["machine", CORE, *(f"`{extra}`" for extra in EXTRAS)], ["---"] * (len(parts) + 1)]
    lines += [[machine.name, *(cell(part, machine, gaps) for part in parts)] for machine in MACHINES]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def with_table(text: str, rows: str) -> str:
    """The page with another table."""
    before, _, rest = text.partition(START)
    _, _, after = rest.partition(END)
    return f"{before}{START}\n\n{rows}\n\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), table()), encoding="utf-8")
