"""The facade itself as a member of its family: its own columns and rows, whether or not they are among the choices."""

from __future__ import annotations

from itertools import pairwise

from grammarlab.facade.writing.structure.kinds import KindPattern, KindSequence
from grammarlab.facade.writing.structure.storeys import Storeys
from grammarlab.facade.writing.structure.walks import Walks, WalkState, WalkStep


def own_member(pattern: KindPattern, storeys: Storeys, walks: Walks) -> tuple[Storeys, Walks]:
    """The choices of a family restricted to those of the original facade."""
    times = tuple(run.turns for run in storeys.runs)
    height = sum(pattern.rows.size[kind] for kind in pattern.rows.kind)
    return Storeys(storeys.runs, (times,), (height,)), _own_walk(pattern.columns, walks)


def _own_walk(columns: KindSequence, walks: Walks) -> Walks:
    states, gaps, gap, doors = [], [], -1, 0
    for kind in columns.kind:
        if not columns.stands[kind]:
            gap = kind
            continue
        doors += columns.doors[kind]
        states.append(WalkState(kind, doors, len(states) + 1))
        gaps.append(gap)
        gap = -1
    steps = {
        state: (WalkStep(1.0, between, to),) for (state, to), between in zip(pairwise(states), gaps[1:], strict=True)
    }
    size = sum(columns.size[kind] for kind in columns.kind)
    end = states[-1]
    return Walks(
        before=walks.before,
        after=walks.after,
        start=states[0],
        steps=steps | {end: ()},
        end={end: 1.0},
        sizes={end.columns: (size, size)},
        total=1.0,
    )
