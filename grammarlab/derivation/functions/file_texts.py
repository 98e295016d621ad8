"""Texts and tables from files of the asset folder, and strings divided into arrays."""

from __future__ import annotations

import re
from collections.abc import Callable

from grammarlab.assets.mesh_files import find_asset
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.calls.table_columns import for_each
from grammarlab.derivation.functions.asset_functions import matching_files, root_of
from grammarlab.derivation.functions.text_functions import to_number
from grammarlab.derivation.state.array_table import MAX_CELLS, Cell, Table, table_of
from grammarlab.derivation.state.operators import MAX_TEXT
from grammarlab.derivation.state.shapes import Value
from grammarlab.errors import AssetError, DerivationError, Location, MissingAssetError
from grammarlab.files import read_bounded
from grammarlab.tables import TableError, decoded, read_table

_MOST_BYTES = 4 * MAX_TEXT
"""Largest file that is read, bytes."""
_MOST_STEPS = 1e8
"""Largest number of steps that a search for a pattern may take, from its length and its number of repetitions."""
_REPETITION = re.compile(r"(?<!\\)[*+?{]")


def _content(path: str, call: FunctionCall) -> bytes | None:
    """Content of a file of the asset folder; None, and a record of it, if the folder has no such file.

    Raises:
        DerivationError: If it lies outside the folder, or is too large.
    """
    root = root_of(call)
    if root is None:
        hint = "give the folder of the files: --assets DIR, or in Python assets='DIR'"
        raise DerivationError(f'the file "{path}" needs an asset folder', call.location, hint)
    try:
        return read_bounded(find_asset(path, root), _MOST_BYTES)
    except MissingAssetError:
        call.workspace.recorder.add_missing_asset(path, call.location)
        return None
    except (AssetError, OSError) as error:
        raise DerivationError(f'cannot read "{path}": {error}', call.location) from error


def _string_table(path: str, call: FunctionCall) -> Table:
    """The cells of a table in a CSV file; an empty array if there is no such file."""
    content = _content(path, call)
    if content is None:
        return Table("string", 1, 0, ())
    try:
        rows = read_table(content, MAX_CELLS).rows
    except TableError as error:
        raise DerivationError(f'"{path}" is not a table: {error}', call.location) from error
    width = max((len(row.cells) for row in rows), default=0)
    if len(rows) * width > MAX_CELLS:
        return table_of("string", len(rows), width, (), call.location)  # raises, before the cells are copied
    cells = [cell for row in rows for cell in (*row.cells, *[""] * (width - len(row.cells)))]
    return table_of("string", len(rows), width, [_printable(cell) for cell in cells], call.location)


def _float_table(path: str, call: FunctionCall) -> Table:
    table = _string_table(path, call)
    return table._replace(kind="float", cells=tuple(to_number(str(cell).strip()) for cell in table.cells))


def _text(path: str, call: FunctionCall) -> str:
    """``readTextFile(path)``: a text; empty if there is no such file."""
    content = _content(path, call)
    if content is None:
        return ""
    try:
        text = decoded(content).replace("\r\n", "\n").replace("\r", "\n")
    except TableError as error:
        raise DerivationError(f'"{path}" is not a text: {error}', call.location) from error
    if len(text) > MAX_TEXT:
        raise DerivationError(f'"{path}" has {len(text):,} characters, more than {MAX_TEXT:,}', call.location)
    return _printable(text)


def _printable(text: str) -> str:
    """A text with ``?`` for each control character, except for tabs and line ends."""
    return "".join(c if c.isprintable() or c in "\n\t" else "?" for c in text)


def split_text(text: str, delimiter: str, location: Location) -> list[str]:
    r"""Parts of a text between delimiters; one that begins with ``$`` is a regular expression.

    Raises:
        DerivationError: If the expression is not valid, or its search may take too long.

    >>> split_text(".b.", ".", Location()), split_text("a  b", "$\\s+", Location()), split_text("ab", "", Location())
    (['', 'b', ''], ['a', 'b'], ['', 'a', 'b', ''])
    """
    if not delimiter:
        return ["", *text, ""]
    if not delimiter.startswith("$") or delimiter == "$":
        return text.split(delimiter)
    pattern = delimiter[1:]
    # Expressions with groups may need exponential time; others are polynomial in the length of the text.
    steps = float(max(len(text), 1)) ** (1 + len(_REPETITION.findall(pattern)))
    if "(" in pattern.replace("\\(", "") or steps > _MOST_STEPS:
        message = f'the regular expression "{pattern}" could take too long on {len(text):,} characters'
        raise DerivationError(message, location, "use a plain delimiter, without $")
    try:
        return re.split(pattern, text)
    except re.error as error:
        raise DerivationError(f'"{pattern}" is not a regular expression: {error}', location) from error


def _split_string(call: FunctionCall) -> Value:
    def parts(text: Cell | Table, delimiter: Cell | Table) -> Table:
        if not isinstance(text, str) or not isinstance(delimiter, str):
            raise DerivationError("splitString expects two strings", call.location)
        cells = split_text(text, delimiter, call.location)
        return table_of("string", 1, len(cells), cells, call.location)

    return for_each(call.arguments, call.shapes.num, call.workspace, parts, call.location)


def _of_path(read: Callable[[str, FunctionCall], Cell | Table]) -> Builtin:
    """A function of a path, called once for each different one."""

    def evaluate(call: FunctionCall) -> Value:
        def on(path: Cell | Table) -> Cell | Table:
            if not isinstance(path, str):
                raise DerivationError(f"{call.name} expects the path of a file", call.location)
            return read(path, call)

        return for_each(call.arguments, call.shapes.num, call.workspace, on, call.location)

    return Builtin(evaluate, (1, 1))


def _matches(pattern: str, call: FunctionCall) -> Table:
    """``filesSearch(pattern)``: the matching paths as an array."""
    paths = matching_files(root_of(call), pattern)
    return table_of("string", 1, len(paths), paths, call.location)


BUILTINS: dict[str, Builtin] = {
    "filesSearch": _of_path(_matches),
    "readFloatTable": _of_path(_float_table),
    "readStringTable": _of_path(_string_table),
    "readTextFile": _of_path(_text),
    "splitString": Builtin(_split_string, (2, 2)),
}
