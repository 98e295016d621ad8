"""Without its extra a command says which one to install."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

from grammarlab.errors import UsageError
from grammarlab.extras import EXTRAS, named_extras, require

RUN = """
import json, sys
from typer.testing import CliRunner

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in packages:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

packages, commands = json.loads(sys.argv[1])
sys.meta_path.insert(0, Missing())
from grammarlab.cli.commands import app_for
results = [CliRunner().invoke(app_for(command), command, catch_exceptions=False) for command in commands]
print(json.dumps([[result.exit_code, result.stderr] for result in results]))
"""
ROOT = Path(__file__).parents[2]


def without(packages: list[str], commands: list[str], folder: Path) -> list[tuple[int, str]]:
    """Exit codes and messages of commands where packages are not installed."""
    arguments = json.dumps([packages, [command.split() for command in commands]])
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(ROOT)!r})\n{RUN}", arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("package", "extra", "commands"),
    [
        (
            "jax",
            "learn",
            [
                "learn toy --labels a.csv",
                "learn toy --examples a",
                "learn building --scenario B1",
                "label B1",
                "evaluate B1 --seeds 1",
                "score toy --no-browser",
            ],
        ),
        ("matplotlib", "learn", ["evaluate B1 --seeds 1", "evaluate B1 --figures all"]),
        ("tornado", "score", ["score toy --no-browser"]),
    ],
)
def test_commands_name_the_extra_that_they_need(tmp_path, package, extra, commands):
    for command, (code, said) in zip(commands, without([package], commands, tmp_path), strict=True):
        assert code == 2, command
        assert said.splitlines() == [
            f"error: this needs the package {package}, which is not installed: pip install 'grammarlab[{extra}]'."
        ], command
    assert not list(tmp_path.iterdir())


def test_all_other_commands_need_no_extra(tmp_path):
    commands = ["list", "check toy", "show toy", "compare toy toy -n 5", "sample toy -n 1 -o out", "learn --help"]
    assert [code for code, _ in without(list(EXTRAS), commands, tmp_path)] == [0] * len(commands)


def test_the_widget_names_its_extra(tmp_path):
    code = "import sys; sys.modules['anywidget'] = None; import grammarlab.notebook"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert "pip install 'grammarlab[notebook]'" in done.stderr.splitlines()[-1]


def test_only_packages_of_extras_are_explained():
    with pytest.raises(ModuleNotFoundError, match="no_such_package"), named_extras():
        import_module("no_such_package")
    require("matplotlib")
    with pytest.raises(UsageError, match="learn"), named_extras():
        raise ModuleNotFoundError(name="jax.numpy")


def test_extras_install_what_is_said():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    installed = {
        "jaxlib": "jax",
        "sklearn": "scikit-learn",
        "traitlets": "anywidget",
        "dask": "distributed",
        "pxr": "usd-core",
    }
    for package, extra in EXTRAS.items():
        names = [re.split(r"[>\[]", requirement)[0] for requirement in extras[extra]]
        assert installed.get(package, package) in names


@pytest.mark.parametrize(
    ("system", "machine", "advice"),
    [
        ("darwin", "x86_64", "Intel Macs"),
        ("darwin", "arm64", "pip install"),
        ("linux", "x86_64", "pip install"),
        ("win32", "ARM64", "Windows on ARM"),
        ("win32", "AMD64", "pip install"),
    ],
)
def test_nobody_is_sent_to_packages_that_do_not_exist_for_the_machine(
    monkeypatch: pytest.MonkeyPatch, system: str, machine: str, advice: str
):
    monkeypatch.setattr("sys.platform", system)
    monkeypatch.setattr("platform.machine", lambda: machine)
    with pytest.raises(UsageError, match=advice), named_extras():
        raise ModuleNotFoundError(name="jax.numpy")


def test_models_are_drawn_without_embree_and_a_note_says_that_it_takes_longer(tmp_path: Path):
    (tmp_path / "box.cga").write_text("@StartRule\nLot --> extrude(3)\n", encoding="utf-8")
    ((code, message),) = without(["embreex"], ["sample box.cga -n 1 -o boxes --jobs 1"], tmp_path)
    assert code == 0
    assert "ten times longer" in message
    assert "embreex" in message
    assert (tmp_path / "boxes" / "box.png").stat().st_size > 1000
