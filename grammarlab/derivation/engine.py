"""The columnar engine: all shapes that wait for one rule are rewritten at once."""

from __future__ import annotations

import numpy as np

from grammarlab.derivation.calls.choices import route
from grammarlab.derivation.program import CompiledRule, Program
from grammarlab.derivation.state.shapes import Ids, Shapes, concatenate
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.errors import BudgetError


def run(program: Program, workspace: Workspace, starts: Ids) -> None:
    """Derive every model from its initial shape.

    Args:
        program: the grammar.
        workspace: with the initial shapes as `roots`, their nodes already recorded.
        starts: [N] number of the start rule of each model.

    Raises:
        BudgetError: If a model has too many shapes, or a recursive group of rules is too deep.
        DerivationError: If an operation cannot be applied.
    """
    pending, roots = workspace.pending, workspace.roots
    different = np.unique(starts).tolist()
    for start in different:
        pending[start].append(roots if len(different) == 1 else roots.take(np.flatnonzero(starts == start)))
    for group in program.order:
        waves = 0
        while any(pending[rule] for rule in group):
            if waves > workspace.budget.depth:
                raise _too_deep(program, workspace, group)
            waves += 1
            for rule in group:
                chunks, pending[rule] = pending[rule], []
                if chunks:
                    rewrite(program.rules[rule], concatenate(chunks, workspace.strings), workspace)
                    _check_size(workspace, program.symbols[program.rules[rule].symbol])


def rewrite(rule: CompiledRule, shapes: Shapes, workspace: Workspace) -> None:
    """Apply one rule to all its pending shapes."""
    for operations, _, taken in route(rule.body, shapes, workspace):
        workspace.recorder.set_rule(taken.node, operations.rule)
        operations.run(taken, workspace)


def _check_size(workspace: Workspace, symbol: str) -> None:
    """Refuse models that exceed their budget.

    Nodes per model are counted only when one model could have exceeded it.
    """
    recorder, budget = workspace.recorder, workspace.budget.shapes
    if recorder.num_nodes <= workspace.count_again_at:
        return
    model, count = recorder.largest_model()
    workspace.count_again_at = recorder.num_nodes + budget - count
    if count > budget:
        raise BudgetError(
            f"{workspace.lots.name(model)} has more than {budget} shapes after the rule {symbol}",
            None,
            "look for a rule that calls itself, directly or not, or raise the shape budget",
        )


def _too_deep(program: Program, workspace: Workspace, group: tuple[int, ...]) -> BudgetError:
    names = " -> ".join(program.symbols[program.rules[rule].symbol] for rule in group)
    waiting = next(rule for rule in group if workspace.pending[rule])
    models = np.concatenate([chunk.model for chunk in workspace.pending[waiting]])
    depth, model = workspace.budget.depth, workspace.lots.name(models.min())
    return BudgetError(
        f"the rules {names} call themselves more than {depth} times in {model}",
        None,
        "a recursive rule needs a case that ends it, or an expected number of successors below one",
    )
