"""State of a desk for windows."""

from __future__ import annotations

from grammarlab.facade.locks import kind_of
from grammarlab.facade.sizes.wishes import Aspect, in_words
from grammarlab.runs.facade.editor.columns import boxes, colors, drawing
from grammarlab.runs.facade.editor.desk import EditorDesk
from grammarlab.runs.facade.editor.exporting import FORMATS
from grammarlab.runs.serving.windows import Message

PROTOCOL = 1


def state_of(desk: EditorDesk) -> tuple[Message, tuple[bytes, bytes]]:
    """The whole state of the page, except pictures.

    The buffers are the columns of `columns.drawing`, and left, bottom, width and height of all nodes [N, 4].
    """
    document, facade = desk.document, desk.document.facade
    values, columns = drawing(facade)
    past, future = desk.history.past, desk.history.future
    state = {
        "protocol": PROTOCOL,
        "revision": desk.revision,
        "title": desk.title,
        "file": str(desk.target),
        "saved": desk.is_saved,
        "lost": desk.is_lost,
        "undo": past[-1][0] if past else "",
        "redo": future[-1][0] if future else "",
        "labels": list(facade.labels),
        "colors": colors(facade),
        "leaves": facade.leaves.tolist(),
        "parent": facade.parent.tolist(),
        "names": facade.label.tolist(),
        "pictures": len(facade.pictures),
        "grids": [
            {
                "name": grid.name,
                "rows": grid.num_rows,
                "columns": grid.num_columns,
                "nodes": grid.node.tolist(),
            }
            for grid in facade.grids
        ],
        "active": desk.active,
        "locks": [
            {
                "node": lock.node,
                "what": kind_of(lock),
                "words": in_words(lock, facade),
                "range": [lock.least, lock.most] if isinstance(lock, Aspect) else [],
            }
            for lock in document.locks
        ],
        "formats": FORMATS,
        "drawing": values,
    }
    return {"event": "state", "state": state}, (columns, boxes(facade).astype("<f8").tobytes())
