"""Numbers on the command line: as a rule file or a table writes them, not as Python does."""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperCommand


class PlainNumbers(TyperCommand):
    """A command whose numbers are ASCII digits without underscores: Python reads ``1_000`` as 1000."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        rest = super().parse_args(ctx, list(args))
        if ctx.resilient_parsing:  # completion
            return rest
        texts, _, _ = self.make_parser(ctx).parse_args(args=list(args))
        for name, text in texts.items():
            if isinstance(ctx.params.get(name), int | float) and isinstance(text, str) and not _is_plain(text):
                option: Any = next((param for param in self.params if param.name == name), None)
                raise typer.BadParameter(f"expected a number such as 1000, found {text[:60]!r}.", ctx, option)
        return rest


def plain_number(text: str) -> float:
    """A number in ASCII digits without underscores.

    Raises:
        ValueError: If it is not one.
    """
    if not _is_plain(text):
        raise ValueError(text)
    return float(text)


def _is_plain(text: str) -> bool:
    return text.isascii() and "_" not in text
