import pytest
from typer.testing import CliRunner

from grammarlab.cli import app


@pytest.fixture
def run(monkeypatch):
    """Runs a command line in this process: ``run("list", "--json")``; errors of ours that escape fail the test.

    Unless ``--jobs`` says otherwise it starts no others, which takes longer than what they would do.
    """
    monkeypatch.setattr("grammarlab.runs.work.executor_choice.available_cores", lambda: 1)

    def call(*arguments, code=0):
        result = CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)
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
def run_any(monkeypatch):
    """Runs a command line in this process with any exit code; errors of ours that escape fail the test."""
    monkeypatch.setattr("grammarlab.runs.work.executor_choice.available_cores", lambda: 1)
    return lambda *arguments: CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)
