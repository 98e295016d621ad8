"""Some of the models of a forest, and several forests as one, against deriving them together."""

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse(
    """
attr height = rand(3, 9)
Lot --> setupProjection(0, scope.xz, height, 2) projectUV(0) extrude(height) split(x) { ~1 : Part | ~2 : Part }
Part --> 50% : color("#ff0000") report("red", 1) Box. 30% : r(0, 30, 0) report("turned", height) Box.
         else : roofGable(30) deleteUV(0) comp(f) { all : Face }
"""
)


def leaves_by_model(forest: Forest) -> list[list[tuple]]:
    """What each model looks like, whatever the ids are."""
    found: list[list[tuple]] = [[] for _ in range(forest.num_models)]
    leaves = forest.leaves
    for row in range(len(leaves)):
        mesh = forest.meshes.take(leaves.mesh[row : row + 1])
        found[forest.nodes.model[leaves.node[row]]].append(
            (
                forest.symbols[forest.nodes.symbol[leaves.node[row]]],
                leaves.position[row].tolist(),
                leaves.size[row].tolist(),
                forest.frames[leaves.frame[row]].tolist(),
                mesh.points.tolist(),
                forest.materials.channels[leaves.material[row]].tolist(),
                forest.texture_maps[leaves.texture_map[row]].tolist() if leaves.texture_map[row] >= 0 else None,
            )
        )
    return found


def reports_by_model(forest: Forest) -> list[list[tuple[str, float]]]:
    found: list[list[tuple[str, float]]] = [[] for _ in range(forest.num_models)]
    reports = forest.reports
    for node, key, value in zip(reports.node, reports.key, reports.value, strict=True):
        found[forest.nodes.model[node]].append((reports.keys[key], float(value)))
    return found


def test_selected_models_are_what_they_were():
    forest = derive(GRAMMAR, 40, 5)
    kept = np.array([3, 4, 17, 39])
    some = select_models(forest, kept)
    assert some.num_models == 4
    assert some.lots.model.tolist() == kept.tolist()
    assert leaves_by_model(some) == [leaves_by_model(forest)[i] for i in kept]
    assert reports_by_model(some) == [reports_by_model(forest)[i] for i in kept]
    np.testing.assert_array_equal(some.log_probability(), forest.log_probability()[kept])
    np.testing.assert_array_equal(some.shapes_per_model(), forest.shapes_per_model()[kept])
    inner = some.nodes.parent >= 0
    assert (some.nodes.parent[inner] < np.flatnonzero(inner)).all()
    assert (some.nodes.model[some.nodes.parent[inner]] == some.nodes.model[inner]).all()


def test_joined_forests_are_the_forest_of_all():
    whole = derive(GRAMMAR, 30, 5)
    parts = [derive(GRAMMAR, number, 5, first_model=first) for first, number in ((0, 7), (7, 1), (8, 22))]
    joined = join_forests(parts)
    assert joined.num_models == 30
    assert leaves_by_model(joined) == leaves_by_model(whole)
    assert [sorted(r) for r in reports_by_model(joined)] == [sorted(r) for r in reports_by_model(whole)]
    np.testing.assert_array_equal(joined.log_probability(), whole.log_probability())


def test_selecting_all_or_none():
    forest = derive(GRAMMAR, 5, 1)
    assert leaves_by_model(select_models(forest, np.arange(5))) == leaves_by_model(forest)
    none = select_models(forest, np.zeros(0, dtype=np.int64))
    assert none.num_models == len(none.nodes) == len(none.leaves) == 0


def test_forests_of_different_grammars_are_not_joined():
    other = Grammar.parse("Lot --> extrude(2) Box.")
    with pytest.raises(UsageError, match="one grammar"):
        join_forests([derive(GRAMMAR, 2, 1), derive(other, 2, 1)])
    with pytest.raises(UsageError, match="at least one"):
        join_forests([])
