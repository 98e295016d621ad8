"""A model is a function of the grammar, the seed and its index, and of nothing else."""

from __future__ import annotations

import gc
import sys
import weakref
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import Forest, compile_grammar, derive, derive_chunks
from grammarlab.errors import DerivationError
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from tests.cases import bulk
from tests.oracle.strategies import rule_files
from tests.whole_grammars import WHOLE

GRAMMARS = WHOLE
ASSETS = AssetFolder(GRAMMARS[0].parent / "assets")


def fingerprint(forest: Forest, model: int) -> tuple:
    """Everything about one model, bit by bit, without the row numbers that depend on the batch."""
    nodes, leaves, draws = forest.nodes, forest.leaves, forest.draws
    rows = np.flatnonzero(nodes.model == model)
    local = np.full(len(nodes) + 1, -1)
    local[rows] = np.arange(len(rows))
    mine = np.flatnonzero(nodes.model[leaves.node] == model)
    drawn = np.flatnonzero(nodes.model[draws.node] == model)
    meshes = forest.meshes.take(leaves.mesh[mine])
    return tuple(
        column.tobytes()
        for column in (
            local[nodes.parent[rows]],
            nodes.symbol[rows],
            nodes.rule[rows],
            nodes.child[rows],
            nodes.repeat[rows],
            local[leaves.node[mine]],
            leaves.position[mine],
            leaves.size[mine],
            forest.frames[leaves.frame[mine]] + 0.0,
            meshes.points,
            meshes.corners,
            meshes.face_offsets,
            forest.materials.channels[leaves.material[mine]],
            local[draws.node[drawn]],
            draws.site[drawn],
            draws.value[drawn],
            draws.log_density[drawn],
        )
    )


def fingerprints(grammar: Grammar, num_models: int, first_model: int = 0, **options) -> list[tuple]:
    forest = derive(grammar, num_models, 5, first_model=first_model, **options)
    return [fingerprint(forest, model) for model in range(num_models)]


@pytest.mark.parametrize("path", GRAMMARS, ids=lambda path: path.stem)
def test_a_model_is_the_same_alone_and_in_any_batch(path):
    grammar = load(path)
    together = fingerprints(grammar, 12, assets=ASSETS)
    assert together[3:8] == fingerprints(grammar, 5, first_model=3, assets=ASSETS)
    assert [together[7]] == fingerprints(grammar, 1, first_model=7, assets=ASSETS)


@given(rule_files(), st.integers(0, 5))
@bulk(40)
def test_models_of_random_grammars_do_not_depend_on_the_batch(text, index):
    grammar = Grammar.parse(text)
    together = fingerprints(grammar, 6, footprint=(8.0, 6.0))
    assert [together[index]] == fingerprints(grammar, 1, first_model=index, footprint=(8.0, 6.0))


def test_a_shape_is_centred_alike_alone_and_beside_others():
    text = """
        attr w = 50% : 1.57 else : 0.93
        attr g = rand(1, 4)
        Lot --> primitiveCylinder(5) comp(f) { front : s(2.3, 1.9, 1.7) split(x) { { w : Part }* } }
        Part --> s(g, 3.1, 2.07) i("builtin:cube") s(0.53, 0.77, 0.51) center(x) A.
    """
    inline = text.replace("{ w : Part }", '{ w : s(g, 3.1, 2.07) i("builtin:cube") s(0.53, 0.77, 0.51) center(x) A. }')
    for grammar in map(Grammar.parse, (text, inline)):
        together = fingerprints(grammar, 6, footprint=(8.0, 6.0))
        alone = (fingerprints(grammar, 1, first_model=index, footprint=(8.0, 6.0)) for index in range(6))
        assert [model for (model,) in alone] == together


def test_chunks_are_the_models_of_one_batch():
    grammar = load(GRAMMARS[0].parent / "furniture.cga")
    whole = fingerprints(grammar, 90, assets=ASSETS)
    chunks = list(derive_chunks(grammar, 90, 5, nodes_per_chunk=300, assets=ASSETS))
    assert len(chunks) > 3
    assert [fingerprint(chunk, model) for chunk in chunks for model in range(chunk.num_models)] == whole
    assert np.concatenate([chunk.lots.model for chunk in chunks]).tolist() == list(range(90))


def test_chunks_of_models_of_many_meshes_are_smaller(monkeypatch):
    # A roof is cut at places that no other model has.
    text = "Lot --> extrude(rand(9, 20)) roofGable(30) split(x) { 1 : A. }*"
    monkeypatch.setattr(sys.modules[derive_chunks.__module__], "_MESHES_PER_CHUNK", 200)
    chunks = list(derive_chunks(Grammar.parse(text), 90, 5))
    assert chunks[0].num_models == 32
    assert len(chunks) > 2
    assert all(len(chunk.meshes) <= 300 for chunk in chunks[1:])
    plain = list(derive_chunks(Grammar.parse("Lot --> extrude(rand(9, 20)) split(x) { 1 : A. }*"), 90, 5))
    assert [chunk.num_models for chunk in plain] == [32, 58]


def _in_process(first: int) -> list[tuple]:
    return fingerprints(load(GRAMMARS[0].parent / "furniture.cga"), 4, first_model=first, assets=ASSETS)


def test_another_process_makes_the_same_models():
    whole = fingerprints(load(GRAMMARS[0].parent / "furniture.cga"), 8, assets=ASSETS)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        halves = list(pool.map(_in_process, [0, 4]))
    assert halves[0] + halves[1] == whole


def test_reformatting_a_grammar_keeps_its_models():
    first = Grammar.parse("attr h = rand(1, 5)\nLot --> 30%: extrude(h) A\n else: extrude(2 * h) B")
    second = Grammar.parse("attr   h=rand( 1,5 ) // metres\nLot-->30% : extrude(h)   A else : extrude(2*h) B")
    assert fingerprints(first, 20) == fingerprints(second, 20)


def test_other_seeds_make_other_models():
    program = compile_grammar(Grammar.parse("attr h = rand(1, 5)\nLot --> extrude(h) A"))
    heights = {derive(program, 1, seed).leaves.size[0, 1] for seed in (0, 1, 2**63, 2**64 - 1)}
    assert len(heights) == 4


def test_the_program_of_a_grammar_goes_with_it():
    """Of many grammars at once, each has its own program until it goes."""
    grammars = [Grammar.parse(f"attr h = rand(1, {n})\nLot --> extrude(h) A") for n in range(2, 22)]
    programs = [compile_grammar(grammar) for grammar in grammars]
    assert all(compile_grammar(grammar) is program for grammar, program in zip(grammars, programs, strict=True))
    codes = [weakref.ref(program.attributes["h"].code) for program in programs]
    del programs
    gc.collect()
    assert all(code() for code in codes)
    del grammars
    gc.collect()
    assert not any(code() for code in codes)


def test_a_grammar_is_compiled_once_and_one_of_equal_text_for_itself():
    """Equal texts may be of different files: messages name their own."""
    text = "Lot --> comp(x) { all : A }"
    grammars = [Grammar.parse(text, file) for file in ("one.cga", "other.cga")]
    assert grammars[0] == grammars[1]
    assert compile_grammar(grammars[0]) is compile_grammar(grammars[0])
    for grammar in (*grammars, grammars[0]):
        with pytest.raises(DerivationError, match=grammar.file):
            derive(grammar, 1, seed=1)
