"""Modules and folders can be found by their names, and identifiers say what a value is."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

import grammarlab

PACKAGE = Path(grammarlab.__file__).parent
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path.name != "__init__.py")
ROLES = {"commands", "desk", "file", "learn", "report", "request", "run", "scene"}
"""Names that modules of sister packages share since they play the same role there."""
MAX_LINES = 700
MAX_MODULES, MAX_FOLDERS = 864, 68
"""Of these, 530 modules and 60 folders are those of grammars, facades and learning; the others came with trees,
cities, tastes and clusters."""
VAGUE = frozenset(
    [
        "found",
        "said",
        "told",
        "made",
        "wanted",
        "needed",
        "left",
        "kept",
        "beside",
        "own",
        "each",
        "at",
        "place",
        "places",
        "seen",
        "of",
        "given",
        "taken",
        "known",
        "tried",
        "missed",
        "asked",
        "held",
        "stands",
        "shown",
        "meant",
        "did",
        "does",
        "having",
    ]
)
"""Participles and prepositions that do not say what a value is."""
MAX_SHARE = 0.02


def rooms() -> Counter[Path]:
    """Numbers of modules of folders, without the package itself."""
    return Counter(path.parent for path in MODULES if path.parent != PACKAGE)


def test_the_package_can_be_surveyed():
    folders = {parent for path in MODULES for parent in path.relative_to(PACKAGE).parents if parent.parts}
    assert len(MODULES) <= MAX_MODULES
    assert len(folders) <= MAX_FOLDERS
    assert max(len(folder.parts) for folder in folders) <= 2


def test_a_folder_inside_a_package_has_at_least_five_modules():
    small = {str(folder) for folder, number in rooms().items() if folder.parent != PACKAGE and number < 5}
    assert small == set()


def test_no_two_modules_have_one_name_unless_they_play_the_same_role():
    names = Counter(path.stem for path in MODULES)
    assert {name for name, number in names.items() if number > 1} <= ROLES


def test_long_modules_say_why():
    """The head of a module above the limit has a sentence about its length."""
    long = [path for path in MODULES if path.read_text(encoding="utf-8").count("\n") > MAX_LINES]
    for path in long:
        assert "long" in (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""), path


def bound_names(tree: ast.AST) -> Iterator[str]:
    """Every name that a module binds: variables, arguments, functions, classes, renamed imports and captures."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name, ctx=ast.Store()) | ast.arg(arg=name):
                yield name
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                yield name
            case ast.alias(asname=str(name)) | ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)):
                yield name
            case _:
                pass


@pytest.mark.parametrize("package", sorted({path.relative_to(PACKAGE).parts[0] for path in MODULES}))
def test_identifiers_are_nouns_of_the_field(package: str):
    files = [path for path in MODULES if path.relative_to(PACKAGE).parts[0] == package]
    names = [name for path in files for name in bound_names(ast.parse(path.read_text(encoding="utf-8")))]
    vague = Counter(name for name in names if name.strip("_") in VAGUE)
    assert vague.total() <= MAX_SHARE * len(names), vague.most_common()
