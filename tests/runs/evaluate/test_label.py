"""Label files of simulated persons: they are on disk after every round."""

from pathlib import Path

import pytest

from grammarlab.preference.label_files import read_labels
from grammarlab.runs.evaluate.simulated_labels import label_models_of
from tests.runs.evaluate.test_samples import RULES, SCENARIO


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    (tmp_path / "boxes.cga").write_text(RULES)
    path = tmp_path / "boxes.toml"
    path.write_text(SCENARIO)
    return path


def test_what_was_scored_before_an_interruption_is_the_beginning_of_all(scenario, tmp_path):
    whole = label_models_of(scenario, tmp_path / "whole.csv", 24, person="sd10")
    part, seen = tmp_path / "part.csv", []

    def interrupt(what, done, total):
        seen.append((what, done, total, len(read_labels(part))))
        if done == 16:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        label_models_of(scenario, part, 24, person="sd10", on_progress=interrupt)
    assert seen == [("scores", 8, 24, 8), ("scores", 16, 24, 16)]
    assert read_labels(part).rows == read_labels(tmp_path / "whole.csv").rows[:16]
    assert len(whole.labels) == 24


def test_an_interruption_leaves_an_earlier_file_as_it_was(scenario, tmp_path):
    file = tmp_path / "labels.csv"
    label_models_of(scenario, file, 16)
    before = file.read_bytes()

    def interrupt(_what, _done, _total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        label_models_of(scenario, file, 24, person="sd10", on_progress=interrupt)
    assert file.read_bytes() == before
    assert len(label_models_of(scenario, file, 24).labels) == len(read_labels(file)) == 24
