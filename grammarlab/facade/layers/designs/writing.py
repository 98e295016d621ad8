"""Designs as text that `parse_design` reads."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import fields

from grammarlab.facade.layers.designs.design import Counter, Design, Layer, Shapes, Symbol
from grammarlab.facade.layers.weights import Weights

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def design_text(design: Design) -> str:
    r"""A design as TOML; default values are left out.

    >>> from grammarlab.facade.layers.designs.file import parse_design
    >>> text = 'canvas = { width = 3.0, height = 2.0 }\n[symbols]\nA = {}\n[[layers]]\nx = "A"\ny = "A"\n'
    >>> parse_design(design_text(parse_design(text))) == parse_design(text)
    True
    """
    lines = [f"title = {_text(design.title)}"] if design.title else []
    lines.append(f"canvas = {{ width = {design.width!r}, height = {design.height!r} }}")
    tables = {
        "symbols": {name: _symbol(symbol) for name, symbol in design.symbols.items()},
        "counters": {name: text for name, counter in design.counters.items() if (text := _counter(counter))},
        "patterns": {name: _text(pattern.text) for name, pattern in design.patterns.items()},
        "solver": _solver(design),
    }
    for name, table in tables.items():
        if table:
            lines += ["", f"[{name}]", *(f"{_key(key)} = {value}" for key, value in table.items())]
    if design.shapes:
        lines += ["", "[shapes]", *_shapes(design.shapes)]
    lines += ["", "# Layers from the top down."]
    for number, layer in enumerate(design.layers):
        lines += ([""] if number else []) + _layer(layer)
    return "\n".join(lines) + "\n"


def _layer(layer: Layer) -> list[str]:
    lines = ["[[layers]]", f"name = {_text(layer.name)}"]
    lines += [f"{axis} = {_text(name)}" for axis, name in zip("xy", layer.patterns, strict=True)]
    groups = [f"{axis} = {_text(name)}" for axis, name in zip("xy", layer.groups, strict=True) if name]
    masks = [
        f"{axis} = [{', '.join(map(_text, sorted(mask)))}]"
        for axis, mask in zip("xy", layer.masks, strict=True)
        if mask is not None
    ]
    lines += [f"{key} = {{ {', '.join(each)} }}" for key, each in (("group", groups), ("mask", masks)) if each]
    lines += [] if layer.on else ["on = false"]
    lines += [f"depth = {layer.depth!r}"] if layer.depth else []
    return lines + ([f"shapes = {{ {', '.join(_shapes(layer.shapes))} }}"] if layer.shapes else [])


def _shapes(shapes: Shapes) -> list[str]:
    found = []
    for (across, up), shape in shapes.items():
        label = _text(shape.label)
        value = f"{{ label = {label}, depth = {shape.depth!r} }}" if shape.depth else label
        found.append(f"{_key(across)}.{_key(up)} = {value}")
    return found


def _symbol(symbol: Symbol) -> str:
    flags = {"opaque": True, "attached": False, "unoccludable": False, "transparent": False}
    parts = {} if symbol.size is None else {"size": repr(symbol.size)}
    parts |= {name: str(not usual).lower() for name, usual in flags.items() if bool(getattr(symbol, name)) is not usual}
    return parts["size"] if set(parts) == {"size"} else _inline(parts)


def _counter(counter: Counter) -> str:
    """The entry of a counter; empty if it has default values only."""
    parts = {name: str(value) for name in ("least", "most") if (value := getattr(counter, name)) is not None}
    parts |= {} if counter.reflection == "inner" else {"reflection": _text(counter.reflection)}
    return _inline(parts) if parts else ""


def _solver(design: Design) -> dict[str, str]:
    usual = Weights()
    changed = {
        field.name: repr(getattr(design.weights, field.name))
        for field in fields(Weights)
        if getattr(design.weights, field.name) != getattr(usual, field.name)
    }
    return changed | ({"overhang": "true"} if design.overhang else {})


def _inline(parts: Mapping[str, str]) -> str:
    return f"{{ {', '.join(f'{key} = {value}' for key, value in parts.items())} }}" if parts else "{}"


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    """A basic string; JSON's escapes are those of TOML, except for one character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
