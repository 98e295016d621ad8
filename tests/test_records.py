"""Records with many fields are made with keywords, so that a call can be read without the record."""

from __future__ import annotations

import ast
from dataclasses import fields, is_dataclass
from importlib import import_module
from inspect import getmembers, isclass
from pathlib import Path

import grammarlab

PACKAGE = Path(grammarlab.__file__).parent
MOST = 6
"""Fields of a record that may be made without keywords."""


def num_fields(each: type) -> int:
    """Number of fields of a dataclass or of a named tuple; 0 for other classes."""
    return len(fields(each)) if is_dataclass(each) else len(getattr(each, "_fields", ()))


def nameless(file: Path) -> list[str]:
    """Calls that make a large record of arguments without names."""
    called = [
        node
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.args
    ]
    if not called:
        return []
    module = import_module(".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"))
    large = {name for name, each in getmembers(module, isclass) if num_fields(each) > MOST}
    return [
        f"{file}:{node.lineno}: {node.func.id}"
        for node in called
        if isinstance(node.func, ast.Name) and node.func.id in large
    ]


def test_large_records_are_made_with_keywords():
    files = [file for file in sorted(PACKAGE.rglob("*.py")) if file.name != "__main__.py"]
    assert [call for file in files for call in nameless(file)] == []
