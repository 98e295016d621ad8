"""Upper bound on the depth of a syntax tree from its tokens, so that a hostile file ends in a finding."""

from __future__ import annotations

from dataclasses import dataclass, field

from grammarlab.errors import Finding, Location

MAX_DEPTH = 240
"""Largest depth of a tree. It keeps passes over the tree below Python's recursion limit of 1,000 frames: a level of
brackets takes up to four frames, an operator in a chain one."""

BRACKET_DEPTH = 4
CHOICE_DEPTH = 2


@dataclass(slots=True)
class _OpenBracket:
    """Open choices and operators between two brackets."""

    operators: int = 0
    """Operators since the last separator of expressions: a chain of n operators is a tree of depth n."""
    choices: list[bool] = field(default_factory=list)
    """Choices around the last branch; True if their ``else`` was read and they are complete."""

    @property
    def depth(self) -> int:
        return self.operators + CHOICE_DEPTH * len(self.choices)


class Nesting:
    """Nesting of the tokens of a definition. Its depth is an upper bound, exact up to a small factor."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Reset at the beginning of a definition."""
        self._levels = [_OpenBracket()]
        self._outer = 0
        """Depth of all levels except the innermost."""

    @property
    def depth(self) -> int:
        return self._outer + self._levels[-1].depth

    def follow(self, kind: str, brackets: int) -> None:
        """Add a token.

        Args:
            kind: its type.
            brackets: number of open brackets after it.
        """
        while len(self._levels) <= brackets:
            self._outer += BRACKET_DEPTH + self._levels[-1].depth
            self._levels.append(_OpenBracket())
        while len(self._levels) > brackets + 1:
            self._levels.pop()
            self._outer -= BRACKET_DEPTH + self._levels[-1].depth
        level = self._levels[-1]
        if kind in ("OPERATOR", "SIGN", "PREFIX"):
            level.operators += 1
        elif kind in ("_COMMA", "_BAR", "_SEMICOLON"):
            level.operators = 0
            level.choices.clear()
        elif kind in ("_COLON", "_EQUALS", "_ARROW"):
            level.operators = 0

    def branch(self, nested: bool) -> None:
        """Add a ``case`` or ``N%``; `nested` if it is the first of its choice."""
        level = self._levels[-1]
        level.operators = 0
        if nested:
            level.choices.append(False)
        else:
            self._drop_complete(level)

    def otherwise(self) -> None:
        """Add an ``else``: the last branch of the innermost choice without one."""
        level = self._levels[-1]
        level.operators = 0
        self._drop_complete(level)
        if level.choices:
            level.choices[-1] = True

    @staticmethod
    def _drop_complete(level: _OpenBracket) -> None:
        while level.choices and level.choices[-1]:
            level.choices.pop()


def too_deep(location: Location) -> Finding:
    """Finding for a definition that exceeds `MAX_DEPTH`."""
    return Finding(
        "error",
        "too-deep",
        f"nested too deeply: expected at most {MAX_DEPTH // BRACKET_DEPTH} brackets or {MAX_DEPTH} operators deep",
        location,
        "move inner parts into separate rules or functions; the file was not read further",
    )
