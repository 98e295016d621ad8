"""What all commands share."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import trimesh

import grammarlab
from grammarlab.cli import app
from grammarlab.runs import read_manifest
from tests.runs.grammars import TOWER

COMMANDS = [command.name for command in app.registered_commands]
HEAVY = {"numpy", "scipy", "lark", "pyarrow", "trimesh", "shapely", "PIL", "rich", "embreex"}


def test_the_version_is_that_of_the_package(run):
    assert run("--version").stdout == f"grammarlab {grammarlab.__version__}\n"


def test_help_imports_nothing_heavy():
    code = "import sys, grammarlab.cli; print(*{name.partition('.')[0] for name in sys.modules})"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not HEAVY & set(loaded)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_and_option_has_help(run, command):
    text = run(command, "--help").stdout
    function = next(c.callback for c in app.registered_commands if c.name == command)
    assert function is not None
    assert (function.__doc__ or "").splitlines()[0].split(";")[0][:40] in " ".join(text.split())


@pytest.mark.parametrize("arguments", [["nonsense"], ["list", "--nonsense"], ["sample", "toy", "-n", "x"], ["check"]])
def test_wrong_usage_exits_with_2(run, arguments):
    assert "Usage:" in run(*arguments, code=2).stderr


def test_completion_knows_commands_and_shipped_grammars():
    words = {"": "sample", "sample b": "building"}
    for typed, expected in words.items():
        environment = {**os.environ, "_GRAMMARLAB_COMPLETE": "complete_bash", "COMP_WORDS": f"grammarlab {typed}"}
        environment["COMP_CWORD"] = str(len(f"grammarlab {typed}".split(" ")) - 1)
        result = subprocess.run(
            [Path(sys.executable).parent / "grammarlab"], env=environment, capture_output=True, text=True, check=False
        )
        assert expected in result.stdout.split(), result.stderr


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_ctrl_c_in_the_middle_leaves_whole_files(tmp_path, jobs):
    rules = tmp_path / "tower.cga"
    rules.write_text(TOWER)
    out = tmp_path / "out"
    command = [sys.executable, "-c", "from grammarlab.cli import main; main()", "sample", str(rules)]
    options = ["-n", "2000", "-o", str(out), "--no-image", "--jobs", jobs]
    with subprocess.Popen([*command, *options], stderr=subprocess.PIPE, text=True) as process:
        records = out / "derivations" / "00000" / "models.json"
        deadline = time.monotonic() + 60
        while not records.exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, messages = process.communicate(timeout=60)
    assert process.returncode == 130, messages
    assert "stays valid" in messages
    assert "Traceback" not in messages
    assert not read_manifest(out).complete
    finished = sorted(out.glob("*.glb"))
    assert 0 < len(finished) < 2000
    for path in (finished[0], finished[-1]):
        assert isinstance(trimesh.load(path, force="mesh"), trimesh.Trimesh)
    assert not list(out.rglob(".part*"))
    assert not list(out.rglob("*.part"))
