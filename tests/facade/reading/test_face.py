import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.forest import Forest
from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.grammar.exact_grammar import write_exact
from grammarlab.facade.reading.assembling import assemble
from grammarlab.facade.reading.derived_face import FACES, face_of
from grammarlab.language.grammar import Grammar
from tests.facade.grammar.houses import house

# A house whose four sides have different widths and windows, not rotated; a round window on the front.
HOUSE = """
@StartRule
Lot --> s(12, 0, 8) extrude(6) comp(f) {
    front : split(x) { 3 : Wall. | 2 : Bay | ~1 : Wall. | 1.5 : Door. | 2 : Wall. }
  | left : split(x) { ~1 : Wall. | 4 : Gate. | 1 : Wall. }
  | right : split(y) { 2 : Wall. | 1 : Sign. | ~1 : Wall. }
  | back : Wall. | top : Roof. }
Bay --> split(y) { 1 : Wall. | 3 : Window | ~1 : Wall. }
Window --> [ s('1, scope.sy - scope.sx / 2, 0.1) t(0, 0, -0.2) primitiveCube() Glass. ]
           t(0, scope.sy, -0.2) r(90, 0, 0) s('1, 0.1, scope.sx) primitiveCylinder(64) Round.
"""


def forest_of(text: str) -> Forest:
    return derive(Grammar.parse(text), 1, seed=0)


def test_each_side_has_its_own_boxes_from_the_left_as_it_is_seen() -> None:
    expected = {
        "front": ("door", [8.5, 0, 10, 6], [12, 6]),
        "left": ("gate", [3, 0, 7, 6], [8, 6]),
        "right": ("sign", [0, 2, 8, 3], [8, 6]),
        "back": ("wall", [0, 0, 12, 6], [12, 6]),
    }
    for face in FACES:
        found = face_of(forest_of(HOUSE), face, ()).annotation
        name, box, size = expected[face]
        at = found.names.index(name)
        assert np.allclose(np.concatenate([found.low[at], found.high[at]]) - np.tile(found.frame[0], 2), box, atol=1e-4)
        assert np.allclose(np.diff(found.frame, axis=0), size, atol=1e-4)
        assert "roof" not in found.names


def test_parts_are_boxes_with_all_that_is_in_them_and_the_outline_that_is_seen() -> None:
    found = face_of(forest_of(HOUSE), "front", ["Window", "Door"]).annotation
    assert sorted(found.names) == ["door", "window"]
    window = found.names.index("window")
    assert np.allclose(np.concatenate([found.low[window], found.high[window]]), [3, 1, 5, 4], atol=1e-4)
    x, y = found.outlines[window].T
    area = 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert area == pytest.approx(2 * 2 + np.pi / 2, rel=2e-3)
    assert not len(found.outlines[found.names.index("door")])


def test_a_facade_that_was_written_as_rules_is_read_back() -> None:
    facade = house(columns=4, rows=3)
    found = assemble(face_of(forest_of(write_exact(facade).text), "front", ()).annotation).facade
    assert np.allclose(found.size[0], facade.size[0], atol=1e-4)

    def things(of) -> np.ndarray:
        kept = [leaf for leaf in of.leaves.tolist() if of.name_of(leaf) != "wall"]
        rows = np.concatenate([of.position, of.size], axis=1)[kept]
        return rows[np.lexsort(rows.round(3).T)]

    assert np.allclose(things(found), things(facade), atol=1e-4)


def test_of_several_planes_the_one_with_most_on_it_comes_first() -> None:
    text = """
    @StartRule
    Lot -->
        [ s(6, 4, 1) primitiveCube() comp(f) { front : Near. } ]
        t(0, 0, -9) s(9, 4, 1) primitiveCube() comp(f) { front : Far. }
    """
    assert face_of(forest_of(text), "front", ()).annotation.names == ("far",)
    assert face_of(forest_of(text), "front:1", ()).annotation.names == ("near",)
    with pytest.raises(FacadeError, match="this building has no shapes on its side front:2"):
        face_of(forest_of(text), "front:2", ())


def test_what_stands_beside_with_a_gap_is_another_wall_and_a_gable_has_an_outline() -> None:
    text = """
    @StartRule
    Lot --> Pair t(9, 0, 0) s(5, 4, 1) primitiveCube() comp(f) { front : Other. }
    Pair --> s(6, 4, 1) primitiveCube() comp(f) { front : split(y) { 2 : Whole. | ~1 : Gable } }
    Gable --> split(x) { ~1 : NIL | 2 : Top. | ~1 : NIL }
    """
    found = face_of(forest_of(text), "front", ()).annotation
    assert sorted(found.names) == ["other"]
    found = face_of(forest_of(text), "front:1", ()).annotation
    assert sorted(found.names) == ["top", "whole"]
    facade = assemble(found).facade
    outside = [leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) == "outside"]
    assert np.isclose(facade.size[outside].prod(axis=1).sum(), 2 * 2 * 2)


def test_unknown_sides_and_symbols_are_explained() -> None:
    forest = forest_of(HOUSE)
    for face in ("north", "front:x", "front:-1", "front:٣", "front:" + "9" * 5_000, ""):
        with pytest.raises(UsageError, match="unknown side"):
            face_of(forest, face, ())
    with pytest.raises(FacadeError, match=r"no shape of Gate; its leaves are Door\., Glass\., Wall\."):
        face_of(forest, "front", ["Gate"])
    with pytest.raises(FacadeError, match="this building has no shapes"):
        face_of(derive(Grammar.parse("Lot --> NIL"), 1, seed=0), "front", ())
