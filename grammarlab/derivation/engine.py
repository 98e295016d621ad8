"""The columnar engine: all shapes that wait for one rule are rewritten at once."""

from __future__ import annotations

import numpy as np

from grammarlab.derivation.choices import route
from grammarlab.derivation.program import CompiledRule
from grammarlab.derivation.shapes import Shapes, concatenate
from grammarlab.derivation.workspace import Workspace
from grammarlab.errors import BudgetError


def run(workspace: Workspace) -> None:
    """Derive every model from its initial shape.

    Args:
        workspace: with the initial shapes as `roots`, their nodes already recorded.

    Raises:
        BudgetError: when a model has too many shapes, or a group of rules goes on for too long.
        DerivationError: when an operation cannot be carried out.
    """
    program = workspace.program
    pending, roots = workspace.pending, workspace.roots
    starts = np.unique(workspace.starts).tolist()
    for start in starts:
        pending[start].append(roots if len(starts) == 1 else roots.take(np.flatnonzero(workspace.starts == start)))
    for group in program.order:
        waves = 0
        while any(pending[rule] for rule in group):
            if waves > workspace.budget.depth:
                raise _too_deep(workspace, group)
            waves += 1
            for rule in group:
                chunks, pending[rule] = pending[rule], []
                if chunks:
                    rewrite(program.rules[rule], concatenate(chunks, workspace.strings), workspace)
                    _check_size(workspace, program.rules[rule])


def rewrite(rule: CompiledRule, shapes: Shapes, workspace: Workspace) -> None:
    """Apply one rule to all its pending shapes."""
    for operations, _, taken in route(rule.body, shapes, workspace):
        workspace.recorder.set_rule(taken.node, operations.rule)
        operations.run(taken, workspace)


def _check_size(workspace: Workspace, rule: CompiledRule) -> None:
    """Refuse models that have outgrown their budget.

    Counting waits until so many nodes have come that one model could have.
    """
    recorder, budget = workspace.recorder, workspace.budget.shapes
    if recorder.num_nodes <= workspace.count_again_at:
        return
    model, count = recorder.largest_model()
    workspace.count_again_at = recorder.num_nodes + budget - count
    if count > budget:
        symbol = workspace.program.symbols[rule.symbol]
        raise BudgetError(
            f"{workspace.lots.name(model)} has more than {budget} shapes after the rule {symbol}",
            None,
            "look for a rule that leads back to itself, or raise the shape budget",
        )


def _too_deep(workspace: Workspace, group: tuple[int, ...]) -> BudgetError:
    names = " -> ".join(workspace.program.symbols[workspace.program.rules[rule].symbol] for rule in group)
    waiting = next(rule for rule in group if workspace.pending[rule])
    models = np.concatenate([chunk.model for chunk in workspace.pending[waiting]])
    depth, model = workspace.budget.depth, workspace.lots.name(models.min())
    return BudgetError(
        f"the rules {names} lead back to themselves more than {depth} times in {model}",
        None,
        "a recursive rule needs a case that ends it, or an expected number of successors below one",
    )
