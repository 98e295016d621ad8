"""The protocol of the page of a design; see `grammarlab.pages.requests` for the form of requests."""

from __future__ import annotations

from grammarlab.errors import UsageError, shown
from grammarlab.layers.file import MAX_SIZE_M, MIN_SIZE_M, MOST_BYTES
from grammarlab.pages.desk import DESK_COMMANDS, Command
from grammarlab.pages.layers.desk import Canvas, DesignDesk
from grammarlab.pages.layers.shown import layouts_of
from grammarlab.pages.layers.text_edits import FLAGS, with_flag, with_mask, with_switch
from grammarlab.pages.requests import Request
from grammarlab.pages.windows import Message

_AXES = ("x", "y")


def _drag(desk: DesignDesk, request: Request) -> None:
    """Layouts during a drag of a side: nothing is stored; if the canvas has none, the reason."""
    canvas = _canvas(request)
    solved, error = desk.drag(canvas)
    layouts, buffers = layouts_of(solved)
    result = {"width": canvas[0], "height": canvas[1], "chosen": desk.chosen_of(solved), "conflict": error}
    request.answer({**result, "layouts": layouts}, buffers)


def _resize(desk: DesignDesk, request: Request) -> None:
    def answer(error: str) -> None:
        if error:
            request.refuse(error)
        else:
            request.answer(desk.done(), ())

    desk.resize(_canvas(request), answer)


def _switch(desk: DesignDesk, request: Request) -> Message:
    layer, on = _layer(desk, request), _truth(request, "on")
    desk.do(f"switch {desk.design.layers[layer].name}", with_switch(desk.document, layer, on=on))
    return desk.done()


def _mask(desk: DesignDesk, request: Request) -> Message:
    number, axis = _layer(desk, request), _AXES.index(request.one_of("axis", _AXES))
    layer = desk.design.layers[number]
    symbols = desk.design.patterns[layer.patterns[axis]].symbols()
    symbol, mask = request.one_of("symbol", symbols), layer.masks[axis]
    shows = _truth(request, "seen")
    visible = [name for name in symbols if (shows if name == symbol else mask is None or name in mask)]
    new_mask = None if len(visible) == len(symbols) else visible
    desk.do(f"{'show' if shows else 'hide'} {symbol} of {layer.name}", with_mask(desk.document, number, axis, new_mask))
    return desk.done()


def _flag(desk: DesignDesk, request: Request) -> Message:
    symbol, flag = request.one_of("symbol", tuple(desk.design.symbols)), request.one_of("flag", FLAGS)
    value = _truth(request, "value")
    desk.do(f"{symbol}: {flag if value else f'not {flag}'}", with_flag(desk.document, symbol, flag, value=value))
    return desk.done()


def _edit(desk: DesignDesk, request: Request) -> Message:
    text = request.values.get("text")
    if not isinstance(text, str) or len(text) > MOST_BYTES:
        raise UsageError(f"text: expected a text of at most {MOST_BYTES:,} characters, found {shown(text)}.")
    desk.edit(text.replace("\r\n", "\n"))
    return desk.done()


def _choose(desk: DesignDesk, request: Request) -> Message:
    desk.choose(request.integer("number", 0, 1_000, -1))
    return desk.done()


def _canvas(request: Request) -> Canvas:
    width, height = (request.number(name) for name in ("width", "height"))
    for name, metres in (("width", width), ("height", height)):
        if not MIN_SIZE_M <= metres <= MAX_SIZE_M:
            raise UsageError(
                f"{name}: expected metres above 0, at least {MIN_SIZE_M:g} and at most {MAX_SIZE_M:,.0f}, "
                f"found {metres:g}."
            )
    return width, height


def _layer(desk: DesignDesk, request: Request) -> int:
    return request.integer("layer", 0, len(desk.design.layers) - 1, -1)


def _truth(request: Request, name: str) -> bool:
    value = request.values.get(name)
    if not isinstance(value, bool):
        raise UsageError(f"{name}: expected true or false, found {shown(value)}.")
    return value


COMMANDS: dict[str, Command[DesignDesk]] = {
    **DESK_COMMANDS,
    "drag": _drag,
    "resize": _resize,
    "switch": _switch,
    "mask": _mask,
    "flag": _flag,
    "edit": _edit,
    "choose": _choose,
}
"""Functions of commands."""
