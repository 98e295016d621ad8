"""A grammar, compiled, with its acceptance rule and its assets: what is needed to derive models and to accept them."""

from __future__ import annotations

from collections.abc import Iterable
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
from grammarlab.language.syntax.syntax_tree import String, walk

if TYPE_CHECKING:
    from grammarlab.features.acceptance import Acceptance


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
        """All texts of the grammar, which may name files of the asset folder."""
        return (node.value for node in walk(self.grammar.tree) if isinstance(node, String))
