"""The protocol of the page of a design; see `grammarlab.pages.requests` for the form of requests."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grammarlab.errors import UsageError
from grammarlab.layers.file import MAX_SIZE_M, MIN_SIZE_M, MOST_BYTES
from grammarlab.learning.designs.addresses import shown
from grammarlab.pages.desktop import Message, Send
from grammarlab.pages.layers.desk import Canvas, DesignDesk
from grammarlab.pages.layers.shown import layouts_of
from grammarlab.pages.layers.text_edits import FLAGS, with_flag, with_mask, with_switch
from grammarlab.pages.requests import Request, answered

_AXES = ("x", "y")


def run(desk: DesignDesk, message: object, buffers: Sequence[bytes], window: Send) -> None:
    """Executes the request of a window, and answers it; `message` may be any value."""
    answered(COMMANDS, desk, message, buffers, window)


def _drag(desk: DesignDesk, request: Request) -> None:
    """Layouts during a drag of a side: nothing is stored; if the canvas has none, the reason."""
    canvas = _canvas(request)
    found, error = desk.drag(canvas)
    layouts, buffers = layouts_of(found)
    result = {"width": canvas[0], "height": canvas[1], "chosen": desk.chosen_of(found), "conflict": error}
    request.answer({**result, "layouts": layouts}, buffers)


def _skip(_desk: DesignDesk, _request: Request) -> Message:
    """The answer to a drag that a later one has replaced."""
    return {"skipped": True}


def _resize(desk: DesignDesk, request: Request) -> None:
    def answer(error: str) -> None:
        if error:
            request.refuse(error)
        else:
            request.answer(_done(desk), ())

    desk.resize(_canvas(request), answer)


def _switch(desk: DesignDesk, request: Request) -> Message:
    layer, on = _layer(desk, request), _truth(request, "on")
    desk.do(f"switch {desk.design.layers[layer].name}", with_switch(desk.text, layer, on=on))
    return _done(desk)


def _mask(desk: DesignDesk, request: Request) -> Message:
    number, axis = _layer(desk, request), _AXES.index(_one_of(request, "axis", _AXES))
    layer = desk.design.layers[number]
    there = desk.design.patterns[layer.patterns[axis]].symbols()
    symbol, mask = _one_of(request, "symbol", there), layer.masks[axis]
    shows = _truth(request, "seen")
    seen = [each for each in there if (shows if each == symbol else mask is None or each in mask)]
    whole = None if len(seen) == len(there) else seen
    desk.do(f"{'show' if shows else 'hide'} {symbol} of {layer.name}", with_mask(desk.text, number, axis, whole))
    return _done(desk)


def _flag(desk: DesignDesk, request: Request) -> Message:
    symbol, flag = _one_of(request, "symbol", tuple(desk.design.symbols)), _one_of(request, "flag", FLAGS)
    value = _truth(request, "value")
    desk.do(f"{symbol}: {flag if value else f'not {flag}'}", with_flag(desk.text, symbol, flag, value=value))
    return _done(desk)


def _edit(desk: DesignDesk, request: Request) -> Message:
    text = request.values.get("text")
    if not isinstance(text, str) or len(text) > MOST_BYTES:
        raise UsageError(f"text: expected a text of at most {MOST_BYTES:,} characters, found {shown(text)}.")
    desk.edit(text.replace("\r\n", "\n"))
    return _done(desk)


def _choose(desk: DesignDesk, request: Request) -> Message:
    desk.choose(request.whole("number", 0, 1_000, -1))
    return _done(desk)


def _undo(desk: DesignDesk, _request: Request) -> Message:
    return {"words": desk.step(desk.history.undo), **_done(desk)}


def _redo(desk: DesignDesk, _request: Request) -> Message:
    return {"words": desk.step(desk.history.redo), **_done(desk)}


def _save(desk: DesignDesk, _request: Request) -> Message:
    desk.save()
    return {"file": str(desk.target), **_done(desk)}


def _export(desk: DesignDesk, request: Request) -> Message:
    return {"file": str(desk.export(request.text("format")))}


def _done(desk: DesignDesk) -> Message:
    return {"revision": desk.revision}


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
    return request.whole("layer", 0, len(desk.design.layers) - 1, -1)


def _truth(request: Request, name: str) -> bool:
    value = request.values.get(name)
    if not isinstance(value, bool):
        raise UsageError(f"{name}: expected true or false, found {shown(value)}.")
    return value


def _one_of(request: Request, name: str, values: Sequence[str]) -> str:
    text = request.text(name)
    if text not in values:
        raise UsageError(f"{name}: expected one of {', '.join(values)}, found {text!r}.")
    return text


COMMANDS: dict[str, Callable[[DesignDesk, Request], Message | None]] = {
    "drag": _drag,
    "skip": _skip,
    "resize": _resize,
    "switch": _switch,
    "mask": _mask,
    "flag": _flag,
    "edit": _edit,
    "choose": _choose,
    "undo": _undo,
    "redo": _redo,
    "save": _save,
    "export": _export,
}
"""Functions of commands; those without a result send the answer themselves."""
