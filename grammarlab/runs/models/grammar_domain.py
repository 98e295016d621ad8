"""Rule files, as a kind of file that describes designs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from grammarlab.errors import LanguageError
from grammarlab.language.grammar import read_text
from grammarlab.language.importing import load
from grammarlab.language.linking import linked
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.runs.models.grammar_models import GrammarModels
from grammarlab.runs.requests.checks import grammar_to_run
from grammarlab.runs.requests.domains import AbstractDomain
from grammarlab.runs.requests.examples import SUFFIX

if TYPE_CHECKING:
    from grammarlab.learning.targets.grammar_target import GrammarWriter


class GrammarDomain(AbstractDomain[GrammarSpace, GrammarModels]):
    """Domain of rule files."""

    def read(self, path: Path) -> str:
        """Text of the file merged with its imports; the file's own text if it has syntax errors."""
        text = read_text(path)
        if re.search(r"\bimport\b", text) is None:
            return text
        try:
            return linked(load(path))
        except LanguageError as error:
            if any(finding.code == "bad-import" for finding in error.findings):
                raise
            return text

    def open(self, text: str, name: str, assets: Path) -> GrammarSpace:
        space = GrammarSpace(grammar_to_run(text, f"{name}{SUFFIX}"), assets)
        _ = space.program  # a grammar that cannot be compiled is an error of the text
        return space

    def models(self, space: GrammarSpace) -> GrammarModels:
        return GrammarModels(space)

    def writer(self, space: GrammarSpace) -> GrammarWriter:
        # It loads JAX, which drawing does not need.
        from grammarlab.learning.targets.grammar_target import GrammarWriter  # noqa: PLC0415

        return GrammarWriter(space)
