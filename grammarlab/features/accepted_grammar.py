"""A grammar, compiled, with its acceptance rule and its assets: what is needed to derive models and to accept them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.program import Program
from grammarlab.features.accepted_models import Accepted, annotations_of
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import (
    Attribute,
    Binary,
    Choice,
    Name,
    Node,
    RuleFile,
    String,
    children,
    walk,
)

if TYPE_CHECKING:
    from grammarlab.features.acceptance import Acceptance


_FILE_PATTERN = re.compile(r"[^*?]/|\.[A-Za-z0-9]{2,5}$")
"""What a pattern of file names has: a folder, or a suffix at its end; texts built for people have neither."""


@dataclass(frozen=True)
class AcceptedGrammar:
    """A grammar whose models are derived and accepted."""

    grammar: Grammar
    assets: AssetRoot | None = None
    """Folder of meshes and images."""

    @cached_property
    def program(self) -> Program:
        """The compiled grammar."""
        return compile_grammar(self.grammar)

    @cached_property
    def acceptance(self) -> Acceptance | None:
        """The acceptance rule of the file; None if it keeps all models.

        Raises:
            UsageError: If the annotation is not a valid rule.
        """
        if not annotations_of(self.grammar.tree):
            return None
        from grammarlab.features.acceptance import Acceptance  # noqa: PLC0415  # few grammars have a rule

        return Acceptance.of(self.grammar.tree)

    @cached_property
    def folder(self) -> AssetFolder | None:
        """The assets; each is read once for all derivations."""
        return None if self.assets is None else AssetFolder(self.assets)

    def derive(self, lots: Lots, program: Program | None = None, *, leaves: bool = True) -> Accepted:
        """Accepted models of lots.

        Args:
            lots: the lots.
            program: another program of the same grammar, such as that of its proposal.
            leaves: whether to record leaves, see `grammarlab.derivation.derive.derive`.
        """
        if self.acceptance is None:
            return Accepted.all_of(derive(program or self.program, lots, assets=self.folder, leaves=leaves))
        from grammarlab.features.acceptance import derive_accepted  # noqa: PLC0415  # few grammars have a rule

        return derive_accepted(program or self.program, self.acceptance, lots, self.folder, leaves=leaves)

    def asset_names(self) -> Iterable[str]:
        """All texts of the grammar, which may name files of the asset folder, and patterns of names that it builds."""
        yield from (node.value for node in walk(self.grammar.tree) if isinstance(node, String))
        yield from dict.fromkeys(_built_names(self.grammar.tree))


def _built_names(tree: RuleFile) -> Iterator[str]:
    """Patterns of the names that sums of texts may give: ``"a" + n + ".obj"`` gives ``a*.obj``.

    Constants have their value, and what only a derivation knows is ``*``. So a pattern finds every file that may be
    used, and perhaps others.
    """
    constants = {d.name: d.value for d in tree.definitions if isinstance(d, Attribute) and d.constant}
    sums = [node for node in walk(tree) if _is_sum(node)]
    inner = {id(child) for node in sums for child in children(node)}
    for node in sums:
        if id(node) in inner:
            continue
        parts = [_text_of(part, constants) for part in _summands(node)]
        pattern = re.sub(r"\*+", "*", "".join(parts))
        if "*" in pattern and _FILE_PATTERN.search(pattern):
            yield pattern


def _is_sum(node: Node) -> bool:
    return isinstance(node, Binary) and node.operator == "+"


def _summands(node: Node) -> Iterator[Node]:
    """What a sum adds up, from the first on."""
    stack = [node]
    while stack:
        current = stack.pop()
        if _is_sum(current):
            stack += reversed(children(current))
        else:
            yield current


def _text_of(node: Node, constants: dict[str, Choice]) -> str:
    value = constants.get(node.identifier, node) if isinstance(node, Name) else node
    return value.value.replace("[", "[[]") if isinstance(value, String) else "*"
