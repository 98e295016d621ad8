"""The models of a grammar as designs: addresses name them, and the proposal shows what is rare."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.derivation.selection import select_models
from grammarlab.errors import UsageError
from grammarlab.language.dimensions import UNKNOWN
from grammarlab.language.grammar import Grammar
from grammarlab.learning.answers import Answers
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.flattening import flattened
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import MAX_WIDE, WIDE_FACTOR, Pool, PoolDesigns
from grammarlab.learning.questions import ask
from grammarlab.learning.round import Study, init, step
from grammarlab.learning.settings import LEAST_POOL, POOL_SIZE, FeatureOptions, Settings

RULES = """
attr h = rand(1, 9)
attr w = rand(1, 9)
Lot --> s(w, 0, w) extrude(h) split(y) { ~1 : Block | ~1 : Block }
Block --> 90% : Box else : Round
Box --> 50% : Red. else : Blue.
Round --> 50% : Red. else : Blue.
"""
SPACE = GrammarSpace(Grammar.parse(RULES), Path())


def test_units_of_draws_are_known_unknown_or_none():
    text = (
        "attr h = rand(1, 9) attr share = rand(0, 1) attr tone = rand(0, 1) Lot --> extrude('share) t(0, h, 0) A(tone)"
    )
    space = GrammarSpace(Grammar.parse(text), Path())
    assert [space.unit_of(site.name) for site in space.program.sites] == ["m", "", UNKNOWN]


def test_a_usual_pool_is_smaller_where_models_are_made_of_many_meshes():
    # A split of a wedge cuts it, at places that no other model has.
    text = "Lot --> extrude(rand(9, 20)) roofGable(30) split(x) { 8 / N : Slice }*\nSlice --> split(y) { 1 : A. }*"
    few, many = (GrammarSpace(Grammar.parse(text.replace("N", number)), Path()) for number in ("1", "40"))
    assert GrammarSpace(Grammar.parse(RULES), Path()).pool_size == POOL_SIZE
    assert LEAST_POOL <= many.pool_size < few.pool_size
    assert len(Pool.usual(many, 7)) == many.pool_size
    wrong = GrammarSpace(Grammar.parse("Lot --> Lot"), Path())
    assert wrong.pool_size == POOL_SIZE


def test_meshes_that_all_models_share_make_no_pool_smaller():
    # 600 frames of different widths, the same ones in each model.
    text = """
    Lot --> s(30, 0, 60) split(z) { 3 : Row(split.index) }*
    Row(row) --> split(x) { 1 : Bay(30 * row + split.index) }*
    Bay(number) --> offset(-0.05 - 0.0005 * number) comp(f) { inside : A. | border : End }
    End --> 50% : B. else : C.
    """
    assert GrammarSpace(Grammar.parse(text), Path()).pool_size == POOL_SIZE


def round_blocks(forest):
    """[models] how many, counted one by one."""
    counts = np.zeros(forest.num_models)
    for model, symbol in zip(forest.nodes.model, forest.nodes.symbol, strict=True):
        counts[model] += forest.symbols[symbol] == "Round"
    return counts


@pytest.mark.parametrize("size", [1, 4, 5, 250, 5_000, 25_000, 25_005, 100_000, 1_000_000])
def test_a_wider_pool_begins_with_the_other_one_and_is_bounded(size):
    narrow, wide = Pool(0, size).sizes, Pool(0, size, wide=True).sizes
    assert sum(narrow) == len(Pool(0, size)) == size
    assert wide[0] == narrow[0]
    assert narrow[1] <= wide[1] <= max(narrow[1], MAX_WIDE)
    assert wide[1] >= min(WIDE_FACTOR * narrow[1], MAX_WIDE)


def test_addresses_of_a_pool_name_its_designs():
    pool = Pool(3, 100)
    made = PoolDesigns.of(SPACE, pool)
    drawn = [value for batch in made.batches for value in batch.log_probability().tolist()]
    again = SPACE.make(sorted(pool))
    assert again.num_models == 100
    assert drawn == again.log_probability().tolist()
    assert list(pool) == sorted(pool)
    assert [address.flat for address in pool] == [False] * pool.sizes[0] + [True] * pool.sizes[1]


def test_weighted_designs_of_both_parts_stand_for_the_grammar():
    made = PoolDesigns.of(SPACE, Pool(0, 2000))
    liked = np.concatenate([round_blocks(forest) for forest in made.batches]) == 2
    own = np.arange(len(made.pool)) < made.pool.sizes[0]
    assert liked[own].mean() == pytest.approx(0.01, abs=0.01)
    assert liked[~own].mean() == pytest.approx(0.25, abs=0.05)
    assert made.weights.mean() == pytest.approx(1.0, abs=0.05)
    assert (made.weights * liked).mean() == pytest.approx(0.01, abs=0.002)
    assert made.weights.max() <= 1.25
    assert made.weights[liked].max() < made.weights[~liked].max()


def test_designs_are_picked_through_all_batches():
    made = PoolDesigns.of(SPACE, Pool(0, 400))
    picked = made.select(SPACE, np.array([0, 7, 319, 320, 399]))
    addresses = [list(made.pool)[place] for place in (0, 7, 319, 320, 399)]
    values = [value for forest in picked for value in forest.log_probability().tolist()]
    assert values == SPACE.make(addresses).log_probability().tolist()


def test_progress_counts_all_designs():
    told = []
    narrow = PoolDesigns.of(SPACE, Pool(0, 60))
    wide = PoolDesigns.of(SPACE, Pool(0, 60, wide=True), narrow, lambda done, total: told.append((done, total)))
    assert told[-1] == (len(wide.pool), len(wide.pool))
    assert sorted(told) == told
    assert told[0][0] > 60


def test_the_hashes_are_those_of_the_grammar_and_of_no_other():
    other = GrammarSpace(Grammar.parse(RULES.replace("90", "80")), Path())
    assert SPACE.hashes[0] == SPACE.grammar.hash
    assert len({*SPACE.hashes, *other.hashes}) == 4


def test_designs_are_realized_in_order():
    addresses = [Address(False, 5, 0), Address(False, 5, 3), Address(True, 5, 1)]
    scene = SPACE.realize(addresses).scene
    assert scene.num_models == 3
    program = flattened(SPACE.grammar).program
    singles = [derive(SPACE.program, 1, 5), derive(SPACE.program, 1, 5, first_model=3)]
    singles.append(derive(program, 1, 5, first_model=1))
    tops = [(single.leaves.position + single.leaves.size)[:, 1].max() for single in singles]
    found = [(scene.position + scene.size)[scene.model == model, 1].max() for model in range(3)]
    assert found == tops


def test_choices_of_many_branches_are_compared_like_random_numbers():
    steps = "".join(f"2% : {number} " for number in range(49)) + "else : 49"
    two = "50% : 1 else : 2"
    text = f"attr a = {steps}\nattr b = {steps}\nattr c = {two}\nattr d = {two}\nattr e = rand(9)\n"
    space = GrammarSpace(Grammar.parse(text + "Lot --> s(a + c, b + d, e) Box"))
    formulas = {str(formula) for formula in space.candidates([derive(space.program, 200, 1)]).formulas}
    assert {"$a - $b", "$a - $e", "$b - $e"} <= formulas
    assert not {"$a - $c", "$c - $d", "$c - $e"} & formulas


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start_rule": "Nothing"}, "unknown start rule Nothing"),
        ({"attributes": '{"depth":3}'}, "depth, which is not an attribute"),
        ({"footprint": "/etc/hosts"}, "is a file"),
        ({"footprint": "round"}, "expected WIDTHxDEPTH"),
    ],
)
def test_addresses_that_cannot_be_followed_are_refused(change, message):
    with pytest.raises(UsageError, match=message):
        SPACE.make([Address(False, 1, 0, **change)])


def test_addresses_with_a_footprint_and_attributes_are_followed():
    address = Address(False, 1, 0, attributes='{"h":7}', footprint="4x2")
    top = SPACE.realize([address]).scene
    assert (top.position + top.size)[:, 1].max() == pytest.approx(7.0)


def test_a_footprint_may_have_hundreds_of_corners():
    around = np.linspace(0.0, 2.0 * np.pi, 400)[:-1]
    corners = [f"{5 * x:.3f} {5 * y:.3f}" for x, y in zip(np.cos(around), np.sin(around), strict=True)]
    address = Address(False, 1, 0, footprint=f"POLYGON (({', '.join([*corners, corners[0]])}))")
    assert len(SPACE.make([address]).lots.footprints.points) == 399


def test_designs_of_any_addresses_are_made_as_each_of_them_is_alone():
    ways = [
        (False, 3, 5, {}),
        (False, 3, 17, {}),
        (False, 3, 17, {"footprint": "9x4"}),
        (False, 2**64 - 1, 2, {"start_rule": "Block"}),
        (True, 3, 5, {"attributes": '{"h":2}'}),
    ]
    addresses = sorted(Address(flat, seed, model, **how) for flat, seed, model, how in ways)
    forest = SPACE.make(addresses)
    assert forest.num_models == len(ways)
    for row, address in enumerate(addresses):
        options: dict[str, Any] = {
            "start_rule": address.start_rule or None,
            "attributes": json.loads(address.attributes),
        }
        options |= {"footprint": (9.0, 4.0)} if address.footprint else {}
        program = SPACE.proposal.program if address.flat else SPACE.program
        alone = derive(program, 1, address.seed, first_model=address.model, **options)
        mine = select_models(forest, np.array([row]))
        assert str(mine.lots) == f"model {address.model} of seed {address.seed}"
        assert mine.log_probability() == alone.log_probability()
        for name in ("symbol", "rule", "child", "repeat", "parent"):
            np.testing.assert_array_equal(getattr(mine.nodes, name), getattr(alone.nodes, name))
    assert SPACE.make([]).num_models == 0


def test_scored_designs_from_elsewhere_keep_their_rows_in_whatever_order_they_were_scored():
    study = Study(SPACE, Pool(0, 60), Settings(FeatureOptions(1, ("paths",))))
    elsewhere = [Address(model % 2 == 0, 9, model) for model in range(20)]
    designs = (*study.pool, *elsewhere)
    scores = dict(zip(sorted(designs), (50.0 * round_blocks(SPACE.make(sorted(designs)))).tolist(), strict=True))
    exact = Answers("overall", designs, np.array([scores[design] for design in designs]))
    state = step(study, init(study), [exact])
    mistakes = [design for design in elsewhere if scores[design] != 50.0]
    assert len(mistakes) > 5
    for wrong in mistakes:
        said = [100.0 - scores[design] if design == wrong else scores[design] for design in designs]
        told = replace(state, answers={"overall": replace(exact, scores=np.array(said))})
        assert ask(study, told, 1, 0, factor="overall", way="already ranked") == (wrong,)
