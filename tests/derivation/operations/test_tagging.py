"""Names of faces: what the runtime of CityEngine prints for the same rules, and laws of queries."""

from __future__ import annotations

import re
from collections import Counter
from itertools import product

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.state.tag_table import matches
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import L_SHAPE, sampled, symbols

SIDES = ("extrude.side.outer",)
FACES = "comp(f) { all : print(geometry.tags) A. }"


def printed(rule: str) -> Counter[tuple[str, ...]]:
    """The tags of each printed shape, and how often."""
    texts = sampled(f"Lot --> {rule}", L_SHAPE).prints
    return Counter(tuple(filter(None, text.partition("[")[2][:-1].split(","))) for text in texts)


@pytest.mark.parametrize(
    ("rule", "tags"),
    [
        ('tag("x") extrude(5) F', {("extrude.bottom", "x"): 1, ("extrude.top", "x"): 1, (*SIDES, "x"): 6}),
        ("extrude(5) extrude(1) F", {("extrude.bottom",): 8, ("extrude.top",): 8, SIDES: 36}),
        ("roofHip(30, 1) F", {("roof.bottom",): 1, ("roof.top",): 6}),
        ('tag("q") taper(4) F', {("q", "taper.bottom"): 1, ("q", "taper.side"): 6}),
        ("roofShed(30) F", {("roof.bottom",): 1, ("roof.top",): 1, ("roof.side.outer",): 5}),
        ("extrude(5) split(x) { 8 : F | ~1 : NIL }", {("extrude.bottom",): 1, ("extrude.top",): 1, SIDES: 3, (): 1}),
        ('tag("x") offset(-2) F', {("x",): 7}),
        ('tag("x") setback(2) { front : P | remainder : P }', {("x",): 3}),
        ('tag("x") primitiveCube() P', {(): 1}),
        ('tag("x") splitArea(x) { 100 : P | ~1 : P }', {(): 2}),
        ('tag("x.y") tag("x") tag("z.y.w") deleteTags("x.*") P deleteTags("?.y") P', {("x", "z.y.w"): 1, ("x",): 1}),
        ('tag("x") comp(e) { all : tag("y") P }', {("y",): 6}),
        (
            "shapeO(4, 4, 4, 4) { shape : extrude(3) F }",
            {("extrude.bottom",): 1, ("extrude.top",): 1, SIDES: 6, ("extrude.side.inner",): 6},
        ),
    ],
)
def test_tags_are_those_of_the_runtime(rule: str, tags: dict[tuple[str, ...], int]) -> None:
    rule = rule.replace("F", FACES).replace(" P", " print(geometry.tags) A.")
    assert printed(rule) == tags


def test_queries_match_as_regular_expressions() -> None:
    words = ["a", "b", "?", "*"]
    parts = {"?": r"[^.]+", "*": r"[^.]+(\.[^.]+)*", "a": "a", "b": "b"}
    queries = [query for length in (1, 2, 3) for query in product(words, repeat=length)]
    tags = [".".join(tag) for length in (1, 2, 3, 4) for tag in product("ab", repeat=length)]
    for query in queries:
        pattern = re.compile(r"\.".join(parts[word] for word in query) + r"(\..*)?$")
        assert [matches(".".join(query), tag) for tag in tags] == [bool(pattern.match(tag)) for tag in tags]


def test_a_query_of_many_wildcards_is_quick() -> None:
    assert not matches(".".join(["*"] * 1000 + ["b"]), ".".join(["a"] * 1500))


def test_what_is_tagged_and_what_is_not_are_all_components() -> None:
    for part, count in (("f", 8), ("e", 18), ("v", 12), ("fe", 36), ("fv", 36)):
        forest = sampled(
            f'Lot --> extrude(4) comp({part}) {{ isTagged("extrude.top") : T. | !isTagged("extrude.top") : R. }}',
            L_SHAPE,
        )
        found = Counter(symbols(forest))
        assert found["T."] == {"f": 1, "e": 6, "v": 6, "fe": 6, "fv": 6}[part]
        assert found["T."] + found["R."] == count


def test_faces_and_edges_are_tagged_by_their_edges_and_corners() -> None:
    rule = 'Lot --> extrude(4) comp({}) {{ isTagged("extrude.top", {}) : T. }}'
    counts = [len(symbols(sampled(rule.format(*words), L_SHAPE))) for words in ("fe", "fv", "ev")]
    assert counts == [7, 7, 12]  # the top and its walls; the top's edges, and one down from each of its corners


def test_a_selector_by_tag_is_a_condition_with_others() -> None:
    forest = sampled('Lot --> extrude(4) comp(f) { isTagged("extrude.side") && front : A. | isTagged("extrude") = B. }')
    assert Counter(symbols(forest)) == {"A.": 1, "B.": 1}


def test_comp_as_a_value_and_has_tags_read_tags() -> None:
    rule = (
        'Lot --> extrude(4) print(comp(f) { isTagged("extrude.side") : 1 })'
        ' print(geometry.hasTags("*.top")) print(geometry.hasTags("roof")) print(geometry.tags("?.side")) A.'
    )
    assert sampled(rule).prints == ("(6)[0,0,1,1,1,1]", "true", "false", "(1)[extrude.side.outer]")


def test_tags_that_nobody_reads_change_nothing() -> None:
    rule = (
        "Lot --> {} extrude(5) comp(f) {{ top : roofHip(30) split(x) {{ ~3 : A }}* | side : split(y) {{ ~2 : B }}* }}"
    )
    plain, tagged = (sampled(rule.format(words)) for words in ("", 'tag("a.b")'))
    for name in ("position", "size", "frame", "mesh"):
        assert np.array_equal(getattr(plain.leaves, name), getattr(tagged.leaves, name))


def test_a_model_with_tags_is_the_same_in_a_batch() -> None:
    lot = 'Lot --> tag(50% : "a" else : "b") extrude(rand(2, 9))'
    faces = 'comp(f) { isTagged("a") : A. | all : tag("c" + comp.index) P }'
    grammar = Grammar.parse(f"{lot} {faces}\nP --> print(geometry.tags) B.")
    batch, last = derive(grammar, 6, seed=2), derive(grammar, 1, seed=2, first_model=5)
    own = batch.nodes.model[batch.leaves.node] == 5
    assert np.array_equal(batch.leaves.size[own], last.leaves.size)
    assert batch.prints[len(batch.prints) - len(last.prints) :] == last.prints
    assert batch.meshes.tags.dtype == last.meshes.tags.dtype == np.int8  # numbers of tags hold in one derivation only


def test_a_wildcard_in_a_tag_is_left_out_with_a_warning() -> None:
    forest = sampled('Lot --> tag("a?*b") print(geometry.tags) A.')
    assert forest.prints == ("(1)[ab]",)
    assert "wildcards" in forest.warnings[0].message
