"""State of a desk for windows."""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.errors import Finding
from grammarlab.layers.design import Design, Layer, Symbol
from grammarlab.pages.editor.desk import colors, drawing
from grammarlab.pages.layers.desk import DesignDesk
from grammarlab.pages.layers.text_edits import FLAGS
from grammarlab.pages.windows import PROTOCOL, Message
from grammarlab.runs.facade.layer_files import SolvedLayout


def state_of(desk: DesignDesk) -> tuple[Message, tuple[bytes, ...]]:
    """The whole state of the page.

    The buffers are the columns of `columns.drawing`, one for each layout.
    """
    design, solved = desk.design, desk.layouts.solved if desk.layouts else ()
    layouts, buffers = layouts_of(solved)
    state = {
        "protocol": PROTOCOL,
        **desk.summary(),
        "title": design.title or desk.title,
        "text": desk.content,
        "mistakes": [_mistake(finding, desk.content) for finding in desk.mistakes],
        "width": design.width,
        "height": design.height,
        "solving": desk.is_solving,
        "conflict": desk.conflict,
        "layers": [_layer(design, layer) for layer in design.layers],
        "symbols": [_symbol(symbol) for symbol in design.symbols.values()],
        "formats": desk.formats,
        "chosen": desk.chosen_of(solved),
        "layouts": layouts,
    }
    return {"event": "state", "state": state}, buffers


def layouts_of(solved: Sequence[SolvedLayout]) -> tuple[list[Message], tuple[bytes, ...]]:
    """Layouts, and the columns of each."""
    drawings = [drawing(candidate.facade) for candidate in solved]
    values = [
        {
            "counters": dict(candidate.layout.candidate.counters),
            "sizes": {name: round(size, 6) for name, size in candidate.layout.sizing.sizes.items()},
            "energy": candidate.layout.energy,
            "proven": candidate.layout.proven,
            "colors": colors(candidate.facade),
            "labels": list(candidate.facade.labels),
            **drawn,
        }
        for candidate, (drawn, _) in zip(solved, drawings, strict=True)
    ]
    return values, tuple(columns for _, columns in drawings)


def _layer(design: Design, layer: Layer) -> Message:
    return {
        "name": layer.name,
        "on": layer.on,
        "axes": [
            {
                "pattern": design.patterns[name].text,
                "symbols": list(design.patterns[name].symbols()),
                "seen": None if mask is None else sorted(mask),
            }
            for name, mask in zip(layer.patterns, layer.masks, strict=True)
        ],
    }


def _symbol(symbol: Symbol) -> Message:
    return {"name": symbol.name, "size": symbol.size, **{flag: getattr(symbol, flag) for flag in FLAGS}}


def _mistake(finding: Finding, text: str) -> Message:
    location = finding.location
    return {
        "message": finding.message,
        "hint": finding.hint,
        "line": location.line,
        "column": location.column,
        "length": location.length,
        "shown": "\n".join(finding.render(text.splitlines()).splitlines()[1:]),
    }
