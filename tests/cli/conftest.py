from dataclasses import replace

import pytest

from grammarlab.rendering.raycast import RaycastRenderer
from tests.command_line import invoke


@pytest.fixture
def one_process(monkeypatch):
    """Commands start no other processes unless ``--jobs`` says so, which takes longer than what they would do.

    Their pictures have all of their pixels, each of one sample in full light: tests of pictures are elsewhere.
    """
    monkeypatch.setattr("grammarlab.runs.work.executor_choice.available_cores", lambda: 1)
    drawn = RaycastRenderer.render

    def rough(renderer, batch, camera, options):
        return drawn(renderer, batch, camera, replace(options, samples=1, openness_rays=0))

    monkeypatch.setattr(RaycastRenderer, "render", rough)


@pytest.fixture
def run(one_process):
    """Runs a command line in this process: ``run("list", "--json")``; errors of ours that escape fail the test."""

    def call(*arguments, code=0):
        result = invoke(*arguments)
        assert result.exit_code == code, result.output
        assert "Traceback" not in result.output
        return result

    return call


@pytest.fixture
def rules(tmp_path):
    """Writes a rule file and gives its path."""

    def write(text, name="house.cga"):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    return write


@pytest.fixture
def run_any(one_process):
    """Runs a command line in this process with any exit code; errors of ours that escape fail the test."""
    return invoke
