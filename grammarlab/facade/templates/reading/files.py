"""Elements from a file of any kind, chosen by its ending."""

from __future__ import annotations

from pathlib import Path

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.templates.elements import Elements
from grammarlab.facade.templates.reading.document import load_arrays, loads
from grammarlab.facade.values import read_bounded

_MOST_BYTES = 1 << 30


def load_elements(path: Path) -> Elements:
    """The elements of a file.

    Raises:
        FacadeError: for content that cannot be used: what is wrong, and where.
        UsageError: for an ending that is not known.
    """
    ending = path.suffix.lower()
    try:
        if ending == ".json":
            return loads(read_bounded(path, _MOST_BYTES))
        if ending == ".npz":
            return load_arrays(read_bounded(path, _MOST_BYTES))
    except FacadeError as error:
        raise FacadeError(f"{path.name}: {error}") from error
    raise UsageError(f"{path.name!r}: expected a file that ends in .json or .npz.")
