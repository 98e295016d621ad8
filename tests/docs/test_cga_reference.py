"""The reference of CGA has an entry for all that is supported, its examples run, and its pictures are theirs."""

from __future__ import annotations

import re

import numpy as np
import pytest
from PIL import Image

from docs.gen import cga_pictures, cga_reference
from grammarlab.derivation import derive
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED

OPERATIONS = tuple(cga_reference.all_operations())
WORD = re.compile(r"[A-Za-z]\w*")


def test_every_supported_word_has_one_entry() -> None:
    names = [operation.name for operation in OPERATIONS]
    assert sorted(names) == sorted(SUPPORTED.operations or ())
    functions = [name for group in cga_reference.all_functions().values() for name in group]
    assert sorted(functions) == sorted(SUPPORTED.functions or ())


def test_examples_have_nothing_to_complain_about_and_give_something() -> None:
    for operation in OPERATIONS:
        findings = check_text(operation.example, operation.name, SUPPORTED)
        assert [finding for finding in findings if finding.severity == "error"] == []
        assert re.search(rf"\b{operation.name}\b", operation.example), operation.name
        forest = derive(Grammar.parse(operation.example), 1, 1, footprint=cga_reference.LOT)
        assert len(forest.leaves) > 0, operation.name
        assert forest.warnings == ()


def test_arguments_are_described_where_they_first_occur() -> None:
    described = {"y", "z", "green", "blue", "opacity"}  # likewise x and red
    for operation in OPERATIONS:
        assert all(form.startswith(operation.name) for form in operation.forms)
        forms = [re.sub(r"^[^(]*\(?|\).*|\".*?\"", "", form) for form in operation.forms]
        names = {word for form in forms for word in WORD.findall(form)}
        assert operation.arguments.keys() <= names | {"selector"}, operation.name
        described |= operation.arguments.keys()
        assert names <= described, (operation.name, names - described)


def test_every_shape_making_operation_has_a_small_picture() -> None:
    expected = {operation.name for operation in OPERATIONS if operation.has_picture}
    files = {path.stem: path for path in cga_pictures.FOLDER.glob("*.png")}
    assert files.keys() == expected
    assert max(path.stat().st_size for path in files.values()) < 16_000


@pytest.mark.parametrize("name", ["extrude", "subtract"])
def test_pictures_are_those_of_the_examples(name: str) -> None:
    operation = next(operation for operation in OPERATIONS if operation.name == name)
    drawn = np.asarray(cga_pictures.picture(operation).convert("RGB"), dtype=int)
    kept = np.asarray(Image.open(cga_pictures.FOLDER / f"{name}.png").convert("RGB"), dtype=int)
    assert drawn.shape == kept.shape
    assert np.abs(drawn - kept).mean() < 1.0
