"""The table of platforms: it covers the project, and markers of requirements agree with it."""

from __future__ import annotations

import re
import tomllib

import pytest

from docs.gen import platforms
from docs.gen.platforms import CORE, EXTRAS, MACHINES, PAGE, ROOT, requirements

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def rows() -> dict[str, dict[str, str]]:
    made, _, _ = PAGE.read_text(encoding="utf-8").partition(platforms.END)
    lines = re.findall(r"^\| (.*) \|$", made, re.MULTILINE)
    heading, _, *cells = [line.split(" | ") for line in lines]
    return {row[0]: dict(zip(heading, row, strict=True)) for row in cells}


def test_the_table_has_all_machines_and_extras():
    extras = set(PROJECT["optional-dependencies"]) - {"dev", "docs"}
    assert set(EXTRAS) == extras
    assert list(rows()) == [machine.name for machine in MACHINES]
    for row in rows().values():
        assert list(row) == ["machine", CORE, *(f"`{extra}`" for extra in EXTRAS)]
        assert all(re.fullmatch(r"yes|no [\w(), .-]+", cell) for name, cell in row.items() if name != "machine")


def test_the_core_can_be_installed_on_arm_and_embree_only_where_it_has_wheels():
    assert rows()["Linux, ARM"][CORE] == "yes"
    (embree,) = [requirement for requirement in requirements(CORE) if requirement.name == "embreex"]
    assert embree.marker
    needed = {machine.name for machine in MACHINES if embree.marker.evaluate(dict(machine.markers))}
    assert {"Linux, x86-64", "macOS, Apple silicon", "macOS, Intel", "Windows, x86-64"} <= needed
    assert not needed & {"Linux, ARM", "Windows, ARM"}


def test_a_missing_wheel_is_named_with_the_versions_of_python(monkeypatch: pytest.MonkeyPatch):
    def has_wheel(requirement: object, tags: tuple[str, ...], python: str) -> bool:
        name = getattr(requirement, "name", "")
        return name not in {"jaxlib", "numpy"} or (name == "numpy" and tags != ("none",) and python != "3.13")

    monkeypatch.setattr(platforms, "_has_wheel", has_wheel)
    for row in platforms.table().splitlines()[2:]:
        cells = dict(zip((CORE, *EXTRAS), row.strip("| ").split(" | ")[1:], strict=True))
        assert cells[CORE] == "no numpy (Python 3.13)"
        assert cells["learn"] == cells["notebook"] == "no jaxlib"
        assert cells["gl"] == "yes"


def test_a_new_table_replaces_the_old_one():
    text = PAGE.read_text(encoding="utf-8")
    once = platforms.with_table(text, "| one |")
    assert platforms.with_table(once, "| two |") == once.replace("| one |", "| two |")
    assert once.count("| one |") == 1
