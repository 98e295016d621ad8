"""Corrections bind a match: they hold in its result."""

import json

import numpy as np
import pytest

from grammarlab.arrays import offsets_from_counts
from grammarlab.errors import FacadeError
from grammarlab.matching.corrections import (
    LEFT_OUT,
    Correction,
    as_dict,
    check_corrections,
    load_corrections,
    save_corrections,
)
from grammarlab.matching.coupled import couple
from grammarlab.matching.elements import Elements
from grammarlab.matching.library import templates_by_name
from tests.cases import takes_turns

SAID = (
    Correction("template", (0,), "diamond"),
    Correction("same", (2, 3)),
    Correction("ignore", (4,)),
    Correction("share", (5, 6), "width", 1.1),
    Correction("share", (1, 2), "height"),
)


def outlines():
    """Seven rectangles without hidden parts, whose sizes differ by 5 cm or more."""
    random = np.random.default_rng(0)
    sizes = [(1.0, 1.5), (0.8, 1.5), (1.3, 1.2), (1.36, 1.26), (0.7, 2.0), (1.06, 1.8), (1.14, 1.8)]
    clouds = []
    for place, (width, height) in enumerate(sizes):
        corners = np.array([[0, 0], [width, 0], [width, height], [0, height]])
        part = random.uniform(size=(4, 16, 1))
        cloud = (corners[:, None] * part + np.roll(corners, -1, axis=0)[:, None] * (1 - part)).reshape(-1, 2)
        clouds.append(cloud + random.normal(0, 0.01, cloud.shape) + [3 * place, 0])
    low = np.array([each.min(axis=0) for each in clouds]) - 0.1
    high = np.array([each.max(axis=0) for each in clouds]) + 0.1
    none = np.full(len(clouds), -1)
    return Elements(offsets_from_counts(np.full(7, 64)), np.vstack(clouds), low, high, row=none, column=none)


@takes_turns
def test_what_a_person_says_holds_in_the_match():
    bound = couple(outlines(), templates_by_name("rectangle,diamond"), 0, SAID)
    assert bound.template_of(bound.kind[1]).name == "rectangle"
    assert bound.template_of(bound.kind[0]).name == "diamond"
    assert bound.kind[2] == bound.kind[3] >= 0
    assert bound.kind[4] == -1
    assert bound.reasons[4] == LEFT_OUT
    assert [round(float(bound.parameters[each][0]), 2) for each in (5, 6)] == [1.1, 1.1]


def test_corrections_are_read_as_they_were_written(tmp_path):
    path = save_corrections(SAID, tmp_path / "said.json")
    assert load_corrections(path) == SAID
    assert load_corrections(save_corrections((), path)) == ()


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ([{"elements": [0]}], "Correction 0: expected elements and one of"),
        ([{"elements": [0], "same": True, "ignore": True}], "one of"),
        ([{"elements": [], "same": True}], "one of"),
        ([{"elements": [-1], "same": True}], "whole number"),
        ([{"elements": [0], "same": False}], "expected true"),
        ([{"elements": [0], "share": "rise"}], "width or height"),
        ([{"elements": [0], "share": "width", "value": -1}], "above 0"),
        ({}, "list"),
    ],
)
def test_mistakes_in_a_file_are_said_with_their_place(tmp_path, said, message):
    path = tmp_path / "said.json"
    path.write_text(json.dumps({"format": "grammarlab corrections", "version": 1, "corrections": said}))
    with pytest.raises(FacadeError, match=f"said.json.*{message}"):
        load_corrections(path)


@pytest.mark.parametrize(
    "said",
    [
        (Correction("ignore", (9,)),),
        (Correction("template", (0,), "door"),),
        (Correction("template", (0,), "diamond"), Correction("template", (0, 1), "rectangle")),
    ],
)
def test_corrections_about_what_is_not_there_are_refused(said):
    with pytest.raises(FacadeError, match="Corrections"):
        check_corrections(said, 7, templates_by_name("rectangle,diamond"))
    assert as_dict(said[0])["elements"]
