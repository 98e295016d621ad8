"""Functions of lists: strings with a semicolon after each item, as in CGA."""

from __future__ import annotations

from grammarlab.derivation.calls.calls import Builtin
from grammarlab.derivation.functions.text import text_function, whole
from grammarlab.derivation.state.operators import check_length


def items(text: str) -> list[str]:
    """The items of a list; the last one may lack its semicolon."""
    parts = text.split(";")
    return parts[:-1] if parts[-1] == "" else parts


def joined(parts: list[str]) -> str:
    """A list of these items."""
    text = "".join(f"{part};" for part in parts)
    check_length(len(text))
    return text


def fits(item: str, sought: str) -> bool:
    """Whether an item matches a pattern; a ``*`` at the start or the end matches any text.

    >>> fits("floor_2", "*_2"), fits("your", "*u*"), fits("your", "u*")
    (True, True, False)
    """
    core = sought.removeprefix("*")
    at_start = core == sought
    core, at_end = core.removesuffix("*"), not core.endswith("*")
    if at_start and at_end:
        return item == core
    return item.startswith(core) if at_start else item.endswith(core) if at_end else core in item


def _item(text: str, index: float) -> str:
    parts = items(text)
    return parts[whole(index)] if 0 <= index < len(parts) else ""


def _index(text: str, sought: str) -> float:
    return float(next((i for i, item in enumerate(items(text)) if fits(item, sought)), -1))


def _remove(text: str, sought: str) -> str:
    parts, place = items(text), whole(_index(text, sought))
    return joined(parts[:place] + parts[place + 1 :]) if place >= 0 else joined(parts)


def _kept(text: str, sought: str, fitting: bool) -> str:
    return joined([item for item in items(text) if fits(item, sought) == fitting])


def _part(text: str, first: float, last: float) -> str:
    return joined(items(text)[max(0, whole(first)) : max(0, whole(last))])


BUILTINS: dict[str, Builtin] = {
    "listAdd": text_function(lambda text, item: joined([*items(text), item.removesuffix(";")]), (2, 2)),
    "listClean": text_function(lambda text: joined([item for item in items(text) if item])),
    "listCount": text_function(lambda text, sought: float(sum(fits(item, sought) for item in items(text))), (2, 2)),
    "listFirst": text_function(lambda text: _item(text, 0.0)),
    "listIndex": text_function(_index, (2, 2)),
    "listItem": text_function(_item, (2, 2)),
    "listLast": text_function(lambda text: items(text)[-1] if items(text) else ""),
    "listRange": text_function(_part, (3, 3)),
    "listRemove": text_function(_remove, (2, 2)),
    "listRemoveAll": text_function(lambda text, sought: _kept(text, sought, False), (2, 2)),
    "listRetainAll": text_function(lambda text, sought: _kept(text, sought, True), (2, 2)),
    "listSize": text_function(lambda text: float(len(items(text)))),
    "listTerminate": text_function(lambda text: joined(items(text))),
}
