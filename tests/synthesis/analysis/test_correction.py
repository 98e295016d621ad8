"""Corrections of the analysis of an example."""

import json
from pathlib import Path

import numpy as np
import pytest

from grammarlab.errors import FacadeError
from grammarlab.synthesis.analysis.correction import corrected, dumps
from grammarlab.synthesis.analysis.example import Example, analyse
from grammarlab.synthesis.mesh.building_files import read_mesh
from tests.synthesis.houses import house


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> Example:
    path = tmp_path_factory.mktemp("house") / "house.obj"
    return analyse(read_mesh(house(5, 3, 2, door=2).write(path)))


def written(example: Example, path: Path, **changes: object) -> Path:
    document = json.loads(dumps(example))
    document["walls"][0].update(changes)
    path.write_text(json.dumps(document))
    return path


def test_a_file_that_nobody_changed_changes_nothing(example: Example, tmp_path: Path) -> None:
    again = corrected(example, written(example, tmp_path / "e.json"))
    assert dumps(again) == dumps(example)
    for one, other in zip(again.regions, example.regions, strict=True):
        assert (one.columns.line == other.columns.line).all()
        assert (one.rows.member == other.rows.member).all()


def test_labels_and_lines_are_those_of_the_file(example: Example, tmp_path: Path) -> None:
    main = example.main
    names = [["ground"] * 5, ["window"] * 5, ["window"] * 5]
    line = main.columns.line.tolist()
    again = corrected(example, written(example, tmp_path / "e.json", labels=names)).main
    assert again.grid.names == ("ground", "window")
    assert again.grid.labels.tolist() == [[0] * 5, [1] * 5, [1] * 5]
    merged = [line[0], *line[2:]]
    again = corrected(
        example, written(example, tmp_path / "e.json", columns=merged, labels=[["a", "b", "b", "b"]] * 3)
    ).main
    assert np.allclose(again.columns.line, merged, atol=1e-4)
    assert len(again.elements_in(1, 0)) == 2


def test_walls_that_are_left_out_belong_to_the_rest(example: Example, tmp_path: Path) -> None:
    path = tmp_path / "e.json"
    document = json.loads(dumps(example))
    path.write_text(json.dumps({**document, "walls": document["walls"][:1]}))
    assert [region.name for region in corrected(example, path).regions] == ["front"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "attic"}, "unknown wall 'attic'"),
        ({"columns": [0.0]}, "2 or more positions"),
        ({"columns": [0.0, 1.0, 0.5]}, "2 or more positions"),
        ({"labels": [["a"]]}, "3 rows of 5 names"),
        ({"labels": "a"}, "labels"),
    ],
)
def test_what_does_not_fit_is_refused_in_words(
    example: Example, changes: dict[str, object], message: str, tmp_path: Path
) -> None:
    with pytest.raises(FacadeError, match=message):
        corrected(example, written(example, tmp_path / "e.json", **changes))
