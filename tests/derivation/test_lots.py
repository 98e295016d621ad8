"""Lots of any mixture are what each of them is alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grammarlab.derivation import Lots, compile_grammar, derive, derive_chunks
from grammarlab.derivation.derive import initial_shapes
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.lots import Footprints
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.derivation.state.mesh_table import MeshTable
from grammarlab.errors import DerivationError, UsageError
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.derivation.engine.test_addressing import fingerprint
from tests.oracle.comparison import assert_same_trees, tree_of_model, trees_of_forest
from tests.oracle.interpreter import interpret
from tests.oracle.shape import initial_shape
from tests.oracle.strategies import FOOTPRINTS, rule_files

GRAMMAR = Grammar.parse(
    """
attr height = rand(3, 9)
attr power = pow(height, 1.7) + sin(height)
attr style = 60% : "old" else : "new"
attr shops = p(0.5)
attr plain = 2.5
Lot --> case style == "old" : extrude(height) Mass else : extrude(power / 9) Mass
Mass --> comp(f) { side : Side | top : Top | all : X. }
Top --> case shops && plain > 1 : roofHip(30) Roof. else : 40% : setback(1) { all : A. | remainder : B. } else : C.
Side --> report("start", initialShape.startRule) set(plain, plain + 1) split(x) { ~plain : Window }*
Window --> 70% : color("#ff0000") s('0.9, '0.9, 0.1) Window2 else : r(0, rand(10, 20), 0) Pane.
Window2 --> case plain < 4 : set(plain, plain * 1.3) Window else : Pane.
Yard --> split(x) { ~height : Side }*
"""
)
PROGRAM = compile_grammar(GRAMMAR)


def of_all_edges(options: dict) -> dict:
    """The options with a street width for each edge of their footprint, the given ones repeated."""
    if options.get("street_width") is None:
        return options
    count = len(Footprints.of([options.get("footprint", (1.0, 1.0))]).points)
    return {**options, "street_width": np.resize(options["street_width"], count)}


OPTIONS = st.fixed_dictionaries(
    {},
    optional={
        "footprint": st.sampled_from([*FOOTPRINTS, np.array([[5.0, 0, 5], [1, 0, 1], [5, 0, 1]])]),
        "start_rule": st.sampled_from(["Lot", "Mass", "Side", "Window", "Yard"]),
        "street_width": st.sampled_from([None, None, (8.0, 0, 6.5), (0, 0, 0)]),
        "attributes": st.fixed_dictionaries(
            {},
            optional={
                "height": st.sampled_from([3.1, 4.7, 0.0, -0.0, 7]),
                "style": st.sampled_from(["old", "new", "newest"]),
                "shops": st.booleans(),
                "power": st.floats(20, 40),
                "plain": st.sampled_from([1.5, 2.5]),
            },
        ),
    },
)
WORDS = st.sampled_from([0, 1, 17, 2**63, 2**64 - 1])
MIXTURES = st.lists(st.tuples(WORDS, WORDS, OPTIONS.map(of_all_edges)), min_size=1, max_size=4)


TWO = Footprints.of([(1.0, 1.0), (2.0, 2.0)]).points, Footprints.of([(1.0, 1.0), (2.0, 2.0)]).offsets


def lot(seed: int, model: int, options: dict) -> Lots:
    return Lots.of(1, seed, first_model=model, **options)


def prints(forest) -> list[tuple]:
    return [fingerprint(forest, model) for model in range(forest.num_models)]


@given(MIXTURES, st.randoms())
@bulk(25)
def test_any_mixture_in_any_order_is_each_lot_alone(mixture, random):
    alone = [derive(PROGRAM, 1, seed, first_model=model, **options) for seed, model, options in mixture]
    lots = Lots.concatenate([lot(*row) for row in mixture])
    order = np.array(random.sample(range(len(mixture)), len(mixture)))
    expected = [prints(alone[row])[0] for row in order]
    together = derive(PROGRAM, lots.take(order))
    assert prints(together) == expected
    assert prints(join_forests([alone[row] for row in order])) == expected
    kept = np.sort(order[::2])
    assert prints(select_models(together, kept)) == [expected[row] for row in kept]
    assert [str(f.lots) for f in alone] == [f"model {model} of seed {seed}" for seed, model, _ in mixture]


@given(MIXTURES)
@bulk(8)
def test_chunks_are_the_whole(mixture):
    lots = Lots.concatenate([lot(*row) for row in mixture] * 12)
    whole = derive(PROGRAM, lots)
    chunks = list(derive_chunks(PROGRAM, lots, nodes_per_chunk=60))
    assert [each for chunk in chunks for each in prints(chunk)] == prints(whole)
    assert rows_of(Lots.concatenate([chunk.lots for chunk in chunks])) == rows_of(lots)


@given(rule_files(), st.data())
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_mixtures_of_random_grammars_derive_as_the_oracle_says(text, data):
    grammar = Grammar.parse(text)
    footprints = st.sampled_from([(8.0, 6.0), (7.0, 5.0)])
    starts = st.sampled_from(["Lot", "A", "C"])
    rows = data.draw(st.lists(st.tuples(WORDS, st.integers(0, 9), footprints, starts), min_size=1, max_size=4))
    lots = [Lots.of(1, s, first_model=m, footprint=f, start_rule=r) for s, m, f, r in rows]
    forest = derive(grammar, Lots.concatenate(lots))
    for tree, (seed, model, footprint, start) in zip(trees_of_forest(forest), rows, strict=True):
        expected = interpret(grammar, seed, model, footprint=footprint, start_rule=start)
        assert_same_trees(tree, tree_of_model(expected, grammar), exact_draws=False)


@given(MIXTURES, MIXTURES, MIXTURES)
@bulk(40)
def test_joining_and_taking_lots_undo_each_other(first, second, third):
    parts = [Lots.concatenate([lot(*row) for row in rows]) for rows in (first, second, third)]
    whole = Lots.concatenate(parts)
    assert len(set(map(content_of(whole.footprints), range(len(whole.footprints))))) == len(whole.footprints)
    bounds = np.cumsum([0, *map(len, parts)])
    for part, low, high in zip(parts, bounds[:-1], bounds[1:], strict=True):
        assert rows_of(whole.take(np.arange(low, high))) == rows_of(part)
    assert rows_of(Lots.concatenate([Lots.concatenate(parts[:2]), parts[2]])) == rows_of(whole)


def content_of(footprints: Footprints) -> Callable[[int], tuple]:
    """Corners and street widths of a footprint of a table, by its index."""

    def content(index: int) -> tuple:
        widths = footprints.widths(index)
        return footprints.polygon(index).tobytes(), None if widths is None else widths.tobytes()

    return content


def rows_of(lots: Lots) -> list[tuple]:
    """Everything about each lot, whatever the tables are."""
    return [
        (
            lots.name(row),
            content_of(lots.footprints)(lots.footprint[row]),
            lots.start_rules[lots.start_rule[row]],
            {name: repr(c.values[row].item()) for name, c in sorted(lots.attributes.items()) if c.is_given[row]},
        )
        for row in range(len(lots))
    ]


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_initial_shapes_stand_where_the_oracle_says(footprint):
    frames, meshes = FrameTable(), MeshTable()
    others = Footprints.of([(3.0, 4.0), footprint])
    shapes = initial_shapes(Lots.of(1, 1).on(others, np.array([1])), frames, meshes)
    expected = initial_shape(footprint, np.zeros(1, np.uint64))
    np.testing.assert_allclose(shapes.position[0], expected.position, atol=1e-12)
    np.testing.assert_allclose(shapes.size[0], expected.size, atol=1e-12)
    np.testing.assert_allclose(frames.rotations(shapes.frame)[0], expected.rotation, atol=1e-12)
    mesh = meshes.take(shapes.mesh)
    corners = mesh.points[mesh.corner_points()] * shapes.size[0]
    np.testing.assert_allclose(corners, expected.mesh.polygon(0), atol=1e-12)


def test_the_rule_that_a_model_starts_with_is_its_own():
    lots = Lots.concatenate([Lots.of(2, 1, start_rule="Side"), Lots.of(1, 1, start_rule="Yard")])
    told = Grammar.parse('Side --> case initialShape.startRule == "Side" : A. else : B.\nYard --> Side')
    forest = derive(told, lots)
    leaves = [forest.symbols[forest.nodes.symbol[node]] for node in forest.leaves.node]
    assert sorted(leaves) == ["A.", "A.", "B."]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Lots.of(-1, 1), "expected 0 models or more, found -1"),
        (lambda: Lots.of(1, -1), "seed: expected a whole number from 0 to 18446744073709551615, found -1"),
        (lambda: Lots.of(1, 2**64), "seed: expected a whole number"),
        (lambda: Lots.of(2, 1, first_model=2**64 - 1), "index of the last model"),
        (lambda: Lots.at(1, [0, -5]), "index of a model: expected a whole number.*found -5"),
        (lambda: Lots.at(1, np.array([0, -5])), "index of a model: expected a whole number.*found -5"),
        (lambda: Lots.of(1, 1, footprint=(0.0, 3.0)), "expected width and depth in metres"),
        (lambda: Lots.of(1, 1, footprint=np.zeros((2, 3))), r"expected corners \[n, 3\]"),
        (lambda: Lots.of(1, 1, footprint=np.full((3, 3), np.nan)), "expected finite coordinates"),
        (lambda: Lots.of(1, 1, footprint=np.zeros((3, 3))), "the first two corners are the same"),
        (lambda: Lots.of(1, 1, street_width=[8.0, 0]), "street widths: expected one for each of 4 edges"),
        (lambda: Lots.of(1, 1, street_width=[8.0, 0, 0, -1]), "found a negative or no number"),
        (lambda: Lots.of(1, 1, street_width=[8.0, 0, 0, np.nan]), "found a negative or no number"),
        (lambda: Lots.of(1, 1, street_width="wide"), "street widths: expected metres for each edge"),  # type: ignore[arg-type, ty:invalid-argument-type]  # a mistake on purpose
        (lambda: Footprints.of([(1.0, 1.0)], []), "street widths: expected those of 1 footprints, found 0"),
        (lambda: Footprints(*TWO, np.zeros(7)), "a column of float64 for 8 corners, found float64 of shape"),
        (lambda: Footprints(*TWO, np.zeros(8, dtype=int)), "a column of float64"),
        (lambda: Footprints(*TWO, np.full(8, -1.0)), "found a negative or infinite number"),
        (lambda: Footprints(*TWO, np.array([np.nan] * 3 + [0.0] * 5)), "found NaN at some"),
        (lambda: Lots.of(1, 1, attributes={"height": None}), "attribute height: expected a number"),  # type: ignore[dict-item, ty:invalid-argument-type]  # a mistake on purpose
        (lambda: Lots.concatenate([]), "at least one"),
        (lambda: Lots.of(2, 1).on(Footprints.of([(1.0, 1.0)]), np.array([0, 1])), "found 0 to 1"),
        (lambda: Lots.of(2, 1).on(Footprints.of([(1.0, 1.0)]), np.array([0])), "a footprint for each of 2 models"),
        (
            lambda: Lots.concatenate([Lots.of(1, 1, attributes={"a": 1.0}), Lots.of(1, 1, attributes={"a": "b"})]),
            "attribute a: expected values of one type",
        ),
        (lambda: derive(PROGRAM, Lots.of(1, 1, attributes={"width": 3})), "unknown attribute width; expected one of"),
        (
            lambda: derive(PROGRAM, Lots.of(1, 1, start_rule="House")),
            "start rule House; expected a rule without parameters: Lot, Mass",
        ),
        (lambda: derive(PROGRAM, Lots.of(1, 1), seed=3), "lots already define.*leave out seed"),  # type: ignore[call-overload, ty:invalid-argument-type]  # a mistake on purpose
        (lambda: derive(PROGRAM, 3), "needs a seed"),  # type: ignore[call-overload, ty:invalid-argument-type]  # a mistake on purpose
    ],
)
def test_lots_that_make_no_sense_are_refused(make, message):
    with pytest.raises(UsageError, match=message):
        make()


def test_values_of_another_type_than_other_models_have_name_the_attribute():
    lots = Lots.concatenate([Lots.of(1, 1, attributes={"height": "tall"}), Lots.of(1, 2)])
    with pytest.raises(DerivationError, match=r"<text>:2:6: the value of height differs between models.*float and str"):
        derive(PROGRAM, lots)


def test_messages_name_a_model_by_its_address():
    lots = Lots.concatenate([Lots.of(2, 3, attributes={"n": 0}), Lots.of(1, 5, first_model=17, attributes={"n": 1})])
    with pytest.raises(DerivationError, match="more than 1000 times in model 17 of seed 5"):
        derive(Grammar.parse("attr n = 0\nLot --> case n > 0 : Lot else : A."), lots)
