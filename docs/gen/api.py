"""The page of the Python names: one section per public name, from its signature and its docstrings.

Signatures are read from the source instead of from objects, so the text is the same for all versions of Python.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import grammarlab
from docs.gen.docstrings import cell, markdown, summary
from grammarlab.learning.targets.explanation import Words
from grammarlab.learning.targets.simplification import Predicted

LINE = 100
"""Number of characters of a signature on one line; a longer one has a line for each argument."""

_RECORDS = """## Records

These are values that the functions above return. Their fields are public; their constructors are not."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


def names() -> tuple[str, ...]:
    """The public names of the package, in the order in which it lists them."""
    return tuple(name for name in getattr(grammarlab, "__all__", ()) if not name.startswith("__"))


def sections() -> str:
    """A table of all names, and one section for each name and each record."""
    public = {f"gl.{name}": getattr(grammarlab, name) for name in names()}
    rows = [f"| [`{title}`](#{anchor(title)}) | {summary(_docstring(value))} |" for title, value in public.items()]
    table = "\n".join(["| name | what it is |", "|---|---|", *rows])
    shown = [_section(title, value, is_public=True) for title, value in public.items()]
    records = [_section(each.__name__, each, is_public=False) for each in returned()]
    return "\n\n".join([table, *shown, _RECORDS, *records])


def returned() -> tuple[type, ...]:
    """Records that public functions return and that have no public name, by name, and those inside them."""
    public = [getattr(grammarlab, name) for name in names()]
    functions = [each for each in public if inspect.isfunction(each)]
    # Some modules import public types for type checkers only.
    types = {name: getattr(grammarlab, name) for name in names()}
    found = {part for each in functions for part in _parts(get_type_hints(each, localns=types)["return"])}
    found |= {Predicted, Words}
    ours = [each for each in found if each.__module__.startswith("grammarlab.") and each not in public]
    return tuple(sorted(ours, key=lambda each: each.__name__))


def anchor(title: str) -> str:
    """The anchor of a heading, on the site and where Markdown is read on the web page of a repository."""
    return title.replace(".", "").lower()


def _parts(hint: Any) -> Iterator[type]:
    """Classes in a type, such as `Edited` in ``tuple[Edited, ...]``."""
    origin = get_origin(hint) or hint
    if inspect.isclass(origin):
        yield origin
    for argument in get_args(hint):
        yield from _parts(argument)


def _docstring(value: Any) -> str:
    return inspect.getdoc(value) or ""


def _section(title: str, value: Any, *, is_public: bool) -> str:
    source, tree = _source(value.__module__)
    nodes = [each for each in tree.body if getattr(each, "name", "") == value.__qualname__]
    if isinstance(nodes[0], ast.ClassDef):
        parts = _of_class(title, value, nodes[0], source, is_public=is_public)
    else:
        parts = [_code(_signatures(title, nodes, source)), markdown(_docstring(value))]
    return "\n\n".join([f"## `{title}`", *filter(None, parts)])


@cache
def _source(module: str) -> tuple[str, ast.Module]:
    text = Path(inspect.getfile(sys.modules[module])).read_text(encoding="utf-8")
    return text, ast.parse(text)


def _of_class(title: str, value: type, node: ast.ClassDef, source: str, *, is_public: bool) -> list[str]:
    methods = [each for each in node.body if isinstance(each, Function)]
    shown = [each for each in methods if not each.name.startswith("_") and _of_node(each)]
    known = list(_fields(node, source))
    known += [(each.name, _segment(source, each.returns), _of_node(each)) for each in shown if _is_property(each)]
    rows = [f"| `{name}` | {_type(kind)} | {summary(text)} |" for name, kind, text in known]
    table = ["\n".join(["| field | type | what it holds |", "|---|---|---|", *rows])] if rows else []
    constructor = [_code(_constructor(title, value, node, source))] if is_public else []
    calls = [
        _of_method(f"{value.__name__}.{each.name}", [other for other in methods if other.name == each.name], source)
        for each in shown
        if not _is_property(each)
    ]
    return [*constructor, markdown(_docstring(value)), *table, *calls]


def _of_method(title: str, nodes: Sequence[Function], source: str) -> str:
    code = _code(_signatures(nodes[-1].name, nodes, source))
    return f"### `{title}`\n\n{code}\n\n{markdown(_of_node(nodes[-1]))}"


def _fields(node: ast.ClassDef, source: str) -> Iterator[tuple[str, str, str]]:
    """Name, type and docstring of each public field: the text after it."""
    for each, after in zip(node.body, [*node.body[1:], None], strict=True):
        if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name) and each.target.id[0] != "_":
            text = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
            yield each.target.id, _segment(source, each.annotation), inspect.cleandoc(str(text))


def _constructor(title: str, value: type, node: ast.ClassDef, source: str) -> str:
    """The call that makes a record; empty for classes that are made by other functions or not at all."""
    explicit = [each for each in node.body if isinstance(each, Function) and each.name == "__init__"]
    if explicit:
        return _signature(title, explicit[0], source).removesuffix(" -> None")
    if not is_dataclass(value):
        return ""
    assigned = [each for each in node.body if isinstance(each, ast.AnnAssign)]
    sources = {each.target.id: each for each in assigned if isinstance(each.target, ast.Name)}
    arguments = [each for each in fields(value) if each.init and each.name in sources]
    texts = [f"{each.name}{_default(sources[each.name].value, source)}" for each in arguments]
    keywords = next((number for number, each in enumerate(arguments) if each.kw_only), None)
    if keywords is not None:
        texts.insert(keywords, "*")
    return _call(title, texts, "")


def _default(value: ast.expr | None, source: str) -> str:
    """Default of a field: `=...` if a function makes it."""
    if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "field":
        given = {each.arg: each.value for each in value.keywords}
        value = given.get("default")
        if "default_factory" in given:
            return "=..."
    return "" if value is None else f"={_segment(source, value)}"


def _signatures(title: str, nodes: Sequence[Any], source: str) -> str:
    """The ways to call a function: its overloads, or itself if it has none."""
    overloads = [each for each in nodes if "overload" in map(_decorator, each.decorator_list)]
    return "\n".join(_signature(title, each, source) for each in overloads or nodes)


def _signature(title: str, node: Function, source: str) -> str:
    arguments = node.args
    positional = [*arguments.posonlyargs, *arguments.args]
    defaults = [*[None] * (len(positional) - len(arguments.defaults)), *arguments.defaults]
    texts = [_argument(each, default, source) for each, default in zip(positional, defaults, strict=True)]
    if texts and positional[0].arg in {"self", "cls"}:
        texts = texts[1:]
    if arguments.vararg:
        texts.append(f"*{_argument(arguments.vararg, None, source)}")
    elif arguments.kwonlyargs:
        texts.append("*")
    pairs = zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    texts += [_argument(each, default, source) for each, default in pairs]
    if arguments.kwarg:
        texts.append(f"**{_argument(arguments.kwarg, None, source)}")
    return _call(title, texts, f" -> {_segment(source, node.returns)}" if node.returns else "")


def _argument(argument: ast.arg, default: ast.expr | None, source: str) -> str:
    text = f"{argument.arg}: {_segment(source, argument.annotation)}" if argument.annotation else argument.arg
    return text if default is None else f"{text} = {_segment(source, default)}"


def _call(title: str, arguments: Sequence[str], result: str) -> str:
    line = f"{title}({', '.join(arguments)}){result}"
    if len(line) <= LINE:
        return line
    return "\n".join([f"{title}(", *(f"    {each}," for each in arguments), f"){result}"])


def _segment(source: str, node: ast.AST | None) -> str:
    """Source of an expression on one line."""
    text = "" if node is None else ast.get_source_segment(source, node)
    return " ".join((text or "").split())


def _type(text: str) -> str:
    return f"`{cell(text)}`" if text else ""


def _code(text: str) -> str:
    return f"```python\n{text}\n```" if text else ""


def _of_node(node: Function) -> str:
    return ast.get_docstring(node) or ""


def _is_property(node: Function) -> bool:
    words = {_decorator(each) for each in node.decorator_list}
    return bool(words & {"property", "cached_property"})


def _decorator(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""
