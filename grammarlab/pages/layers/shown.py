"""State of a desk for windows."""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.errors import Finding
from grammarlab.layers.design import Design, Layer, Symbol
from grammarlab.pages.desktop import Message
from grammarlab.pages.editor.desk import colors, drawing
from grammarlab.pages.editor.exporting import FORMATS
from grammarlab.pages.layers.desk import DesignDesk
from grammarlab.pages.layers.text_edits import FLAGS
from grammarlab.runs.facade.layer_files import SolvedLayout

PROTOCOL = 1


def state_of(desk: DesignDesk) -> tuple[Message, tuple[bytes, ...]]:
    """The whole state of the page.

    The buffers are the columns of `columns.drawing`, one for each layout.
    """
    design, past, future = desk.design, desk.history.past, desk.history.future
    found = desk.shown.found if desk.shown else ()
    layouts, buffers = layouts_of(found)
    state = {
        "protocol": PROTOCOL,
        "revision": desk.revision,
        "title": design.title or desk.title,
        "file": str(desk.target),
        "saved": desk.is_saved,
        "lost": desk.is_lost,
        "undo": past[-1][0] if past else "",
        "redo": future[-1][0] if future else "",
        "text": desk.text if desk.draft is None else desk.draft,
        "mistakes": [_mistake(each, desk.draft or "") for each in desk.mistakes],
        "width": design.width,
        "height": design.height,
        "solving": desk.is_solving,
        "conflict": desk.conflict,
        "layers": [_layer(design, each) for each in design.layers],
        "symbols": [_symbol(each) for each in design.symbols.values()],
        "formats": FORMATS,
        "chosen": desk.chosen_of(found),
        "layouts": layouts,
    }
    return {"event": "state", "state": state}, buffers


def layouts_of(found: Sequence[SolvedLayout]) -> tuple[list[Message], tuple[bytes, ...]]:
    """Layouts, and the columns of each."""
    drawings = [drawing(each.facade) for each in found]
    values = [
        {
            "counters": dict(each.layout.candidate.counters),
            "sizes": {name: round(size, 6) for name, size in each.layout.sizing.sizes.items()},
            "energy": each.layout.energy,
            "proven": each.layout.proven,
            "colors": colors(each.facade),
            "labels": list(each.facade.labels),
            **drawn,
        }
        for each, (drawn, _) in zip(found, drawings, strict=True)
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
    place = finding.location
    return {
        "message": finding.message,
        "hint": finding.hint,
        "line": place.line,
        "column": place.column,
        "length": place.length,
        "shown": "\n".join(finding.render(text.splitlines()).splitlines()[1:]),
    }
