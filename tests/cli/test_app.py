"""What all commands share."""

import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest
import trimesh
import typer

import grammarlab
from grammarlab import cli
from grammarlab.cli.console import friendly_errors
from grammarlab.cli.interruptions import interruptions_come_again
from grammarlab.runs.sample.manifest import read_manifest
from tests.cli.commands import COMMANDS
from tests.runs.grammars import TOWER
from tests.signals import with_sigint
from tests.waiting import PATIENCE, wait_until

MORE_THAN_ARE_MADE = 200_000
"""Models until a run is interrupted, on any machine."""
MOST_IMPORTED = 201
"""Modules of grammarlab that a plain grammar is sampled with."""
HEAVY = {"numpy", "scipy", "lark", "pyarrow", "trimesh", "shapely", "PIL", "rich", "embreex"}


def test_the_version_is_that_of_the_package(run):
    assert run("--version").stdout == f"grammarlab {grammarlab.__version__}\n"


def test_the_package_can_be_run_as_a_module():
    told = subprocess.run([sys.executable, "-m", "grammarlab", "--version"], capture_output=True, text=True, check=True)
    assert told.stdout == f"grammarlab {grammarlab.__version__}\n"


def test_help_imports_nothing_heavy():
    code = "import sys; from grammarlab.cli import app; print(*{name.partition('.')[0] for name in sys.modules})"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not HEAVY & set(loaded)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_and_option_has_help(run, command):
    text = run(*command.split(), "--help").stdout
    function = COMMANDS[command]
    assert (function.__doc__ or "").splitlines()[0].split(";")[0][:40] in " ".join(text.split())


@pytest.mark.parametrize("arguments", [["nonsense"], ["list", "--nonsense"], ["sample", "toy", "-n", "x"], ["check"]])
def test_wrong_usage_exits_with_2(run, arguments):
    assert "Usage:" in run(*arguments, code=2).stderr


@pytest.mark.parametrize(("command", "value"), [("score", "20x12"), ("learn", ""), ("evaluate", "20x12")])
def test_who_asks_for_a_footprint_where_there_is_none_learns_what_to_do(run, command, value):
    result = run(command, "toy", f"--footprint={value}", code=2)
    assert "Lot --> s(12, 0, 8)" in " ".join(result.stderr.split())
    assert "--footprint" not in run(command, "--help").stdout


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
    arguments = ["sample", rules, "-n", MORE_THAN_ARE_MADE, "-o", out, "--no-image", "--jobs", jobs]
    command = with_sigint("SIG_DFL", [sys.executable, "-c", "from grammarlab.cli import main; main()", *arguments])
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        records = out / "derivations" / "00000" / "models.json"
        wait_until(lambda: records.exists() or process.poll() is not None)
        process.send_signal(signal.SIGINT)
        messages = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == 130, messages
    assert "stay valid" in messages
    go_on = " ".join(map(str, ["grammarlab", *arguments, "--resume"]))
    assert messages.rstrip().endswith(f"go on with: {go_on}")
    assert "Traceback" not in messages
    assert not read_manifest(out).complete
    finished = sorted(out.glob("*.glb"))
    assert 0 < len(finished) < MORE_THAN_ARE_MADE
    for path in (finished[0], finished[-1]):
        assert isinstance(trimesh.load(path, force="mesh"), trimesh.Trimesh)
    assert not list(out.rglob(".part*"))
    assert not list(out.rglob("*.part"))


def test_ctrl_c_before_the_command_begins_is_no_traceback(monkeypatch, capsys):
    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "keep_compiled", interrupted)
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 130
    assert "interrupted" in capsys.readouterr().err


def test_ctrl_c_that_python_ignores_interrupts_all_the_same(tmp_path):
    """As where it falls into the clean-up after an import, which was seen once in a thousand runs."""
    code = """
import time
from grammarlab import cli

class Final:
    def __del__(self):
        raise KeyboardInterrupt

def interrupted():
    Final()
    time.sleep(1000)

cli.keep_compiled = interrupted
cli.main()
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=PATIENCE)
    assert (ended.returncode, ended.stderr) == (130, "interrupted.\n")


@friendly_errors()
def interrupted_between_a_lock_and_the_note_of_it():
    try:
        raise KeyboardInterrupt
    finally:
        threading.Lock().release()


@friendly_errors()
def interrupted_before_a_file_that_is_gone_is_closed():
    try:
        raise KeyboardInterrupt
    finally:
        Path("/none/x").unlink()


@friendly_errors()
def failing_after_an_interruption_that_was_answered():
    with suppress(KeyboardInterrupt):
        raise KeyboardInterrupt
    raise ZeroDivisionError


@pytest.mark.parametrize(
    ("command", "error"),
    [
        (interrupted_between_a_lock_and_the_note_of_it, "RuntimeError"),
        (interrupted_before_a_file_that_is_gone_is_closed, "FileNotFoundError"),
    ],
)
def test_an_error_that_comes_of_ctrl_c_is_no_traceback(capsys, command, error):
    with pytest.raises(typer.Exit) as end:
        command()
    assert end.value.exit_code == 130
    assert capsys.readouterr().err.startswith(f"interrupted: finished files stay valid. ({error}: ")


def test_an_error_after_ctrl_c_was_answered_is_told():
    with pytest.raises(ZeroDivisionError):
        failing_after_an_interruption_that_was_answered()


class Failing:
    def __del__(self):
        raise ValueError


def test_what_else_python_ignores_is_told_to_the_hook_before(monkeypatch):
    ignored = []
    monkeypatch.setattr(sys, "unraisablehook", lambda what: ignored.append(what.exc_type))
    before = sys.unraisablehook
    with interruptions_come_again():
        Failing()
    assert ignored == [ValueError]
    assert sys.unraisablehook is before


def test_a_run_in_the_background_of_a_shell_does_not_hear_ctrl_c(tmp_path):
    """It is meant for what runs in the foreground."""
    rules, out = tmp_path / "tower.cga", tmp_path / "out"
    rules.write_text(TOWER)
    command = [sys.executable, "-c", "from grammarlab.cli import main; main()", "sample", rules]
    options = ["-n", 130, "-o", out, "--no-image", "--jobs", 1]
    with subprocess.Popen(with_sigint("SIG_IGN", [*command, *options]), stderr=subprocess.DEVNULL) as process:
        records = out / "derivations" / "00000" / "models.json"
        wait_until(lambda: records.exists() or process.poll() is not None)
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 0
    assert read_manifest(out).complete


def test_sampling_imports_only_what_it_needs(tmp_path: Path) -> None:
    arguments = ["sample", "toy", "-n", "1", "--no-image", "--jobs", "1", "-o", str(tmp_path / "out")]
    code = f"""
import sys
sys.argv[1:] = {arguments}
from grammarlab.cli import main
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
print(*(name for name in sys.modules if name.startswith("grammarlab.")))
"""
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = told.stdout.splitlines()[-1].split()
    rooms = {name.split(".")[1] for name in loaded}
    assert not rooms & {"learning", "preference", "density", "evaluation", "facade", "scoring", "notebook"}
    assert len(loaded) <= MOST_IMPORTED


def test_what_a_library_has_is_shown_with_it(run, tmp_path):
    rules = tmp_path / "lot.cga"
    rules.write_text('import walls : "/City.lib/rules/walls.cga"\nLot --> extrude(3) walls.Brick')
    (tmp_path / "lib" / "City.lib" / "rules").mkdir(parents=True)
    (tmp_path / "lib" / "City.lib" / "rules" / "walls.cga").write_text("Brick --> Stone. Stone.")
    library = ("--library", tmp_path / "lib")
    assert "Stone" in run("show", rules, "--model", 0, *library).stdout
    assert "Stone" in run("show", rules, *library).stdout
    for options in ((), ("--model", 0)):
        without = run("show", rules, *options)
        assert "Stone" not in without.stdout
        assert "which cannot be read" in without.stderr
