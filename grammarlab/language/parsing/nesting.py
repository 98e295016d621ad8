"""How deep the syntax tree of the tokens read so far will be: a bound, so that a hostile file ends in a finding."""

from __future__ import annotations

from dataclasses import dataclass, field

from grammarlab.errors import Finding, Location

MAX_DEPTH = 240
"""Depth of the deepest tree that is read. Python's recursion limit of 1,000 frames is what it protects: a level of
brackets takes the passes over a tree up to four frames, an operator in a chain one."""

BRACKET_DEPTH = 4
CHOICE_DEPTH = 2


@dataclass(slots=True)
class _OpenBracket:
    """What is open between two brackets."""

    operators: int = 0
    """Operators since the last sign that separates expressions: a chain of them is a tree of that depth."""
    choices: list[bool] = field(default_factory=list)
    """The choices that the last branch stands in; True once their ``else`` was seen, and they are complete."""

    @property
    def depth(self) -> int:
        return self.operators + CHOICE_DEPTH * len(self.choices)


class Nesting:
    """Follows the tokens of a definition. Its depth is an upper bound, exact up to a small factor."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forgets everything: a definition begins."""
        self._levels = [_OpenBracket()]
        self._outer = 0
        """Depth of all levels but the innermost."""

    @property
    def depth(self) -> int:
        return self._outer + self._levels[-1].depth

    def follow(self, kind: str, brackets: int) -> None:
        """Takes in a token.

        Args:
            kind: its type.
            brackets: how many brackets are open after it.
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
        """A ``case`` or ``N%`` begins; `nested` when it is the first of its choice."""
        level = self._levels[-1]
        level.operators = 0
        if nested:
            level.choices.append(False)
        else:
            self._drop_complete(level)

    def otherwise(self) -> None:
        """An ``else`` begins: the last branch of the innermost choice that has none."""
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
    """The finding for a definition that passes `MAX_DEPTH`."""
    return Finding(
        "error",
        "too-deep",
        f"nested too deeply: expected at most {MAX_DEPTH // BRACKET_DEPTH} brackets or {MAX_DEPTH} operators deep",
        location,
        "move inner parts into rules or functions of their own; the file was not read further",
    )
