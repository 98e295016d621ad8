"""What the project says about itself is true."""

import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

import grammarlab
from tests.cli.commands import COMMANDS

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
MAIN = "from grammarlab.cli import main; main()"


def run_python(*arguments, cwd=ROOT):
    """What Python prints on stdout; an exit code other than 0 fails the test."""
    return subprocess.run([sys.executable, *arguments], cwd=cwd, check=True, stdout=subprocess.PIPE, text=True).stdout


def section(command):
    """What the README says about a command."""
    match = re.search(rf"### `grammarlab {command}\b.*?(?=\n##|\Z)", README, re.DOTALL)
    assert match, f"the README has no section about {command}"
    return match[0]


@pytest.mark.parametrize("command", COMMANDS)
def test_the_readme_documents_every_option_of_every_command(command):
    help_text = run_python("-c", MAIN, *command.split(), "--help")
    options = set(re.findall(r"--[a-z][a-z-]+", help_text)) - {"--help"}
    missing = {option for option in options if f"`{option}" not in section(command)}
    assert not missing


def test_the_readme_documents_no_command_or_option_that_does_not_exist():
    assert set(re.findall(r"### `grammarlab ([a-z]+(?: [a-z]+)*)", README)) == set(COMMANDS)
    told = set(re.findall(r"grammarlab (\w+)(?: (\w+))? (?:\S+ )*?(--[a-z-]+)", README))
    for first, second, option in told:
        command = [first, second] if f"{first} {second}" in COMMANDS else [first]
        assert option in run_python("-c", MAIN, *command, "--help")


@pytest.mark.parametrize("block", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_the_python_in_the_readme_runs_and_stays_short(block, tmp_path):
    assert len([line for line in block.splitlines() if line.strip()]) < 10
    (tmp_path / "out").mkdir()
    run_python("-W", "error", "-c", block, cwd=tmp_path)
    assert any(tmp_path.rglob("*.glb"))


def test_the_grammar_in_the_readme_has_nothing_to_complain_about():
    from grammarlab.language.checking.check import check_text
    from grammarlab.runs.requests.checks import SUPPORTED

    (block,) = re.findall(r"```cga\n(.*?)```", README, re.DOTALL)
    assert check_text(block, "README.md", SUPPORTED) == ()


def test_pictures_and_links_of_the_documents_exist():
    for document in ROOT.glob("*.md"):
        for target in re.findall(r"\]\((?!http)([^)#]+)\)", document.read_text(encoding="utf-8")):
            assert (ROOT / target).exists(), f"{document.name}: {target}"


def test_ci_runs_the_test_command_of_the_readme():
    commands = [
        line for line in (ROOT / ".ci" / "run").read_text().splitlines() if not line.startswith(("#", "set", "cd"))
    ]
    assert commands == ["make test </dev/null"]
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"make (\w+)  ", README + (ROOT / "CONTRIBUTING.md").read_text())) <= targets


def test_the_map_has_a_line_for_every_package_and_top_folder():
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    for path in (ROOT / "grammarlab").iterdir():
        if path.name[0] not in "_." and (path.is_dir() or path.suffix == ".py"):
            assert f"`grammarlab/{path.name}{'/' * path.is_dir()}`" in text
    order = re.search(r"```\n(cli \|.*?)```", text, re.DOTALL)
    assert order
    contract = PROJECT["tool"]["importlinter"]["contracts"][0]
    assert order[1].split("\n")[:-1] == contract["layers"]


def test_constraints_are_exact_and_within_the_ranges_of_the_project():
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    assert all(re.fullmatch(r"[A-Za-z0-9_.-]+==[0-9][A-Za-z0-9.]*", line) for line in lines)
    pinned = {re.sub(r"[-_.]+", "-", name).lower(): Version(v) for name, v in (line.split("==") for line in lines)}
    extras = PROJECT["project"]["optional-dependencies"]
    for text in [*PROJECT["project"]["dependencies"], *extras["gl"], *extras["dev"]]:
        requirement = Requirement(text)
        if requirement.name != "grammarlab":
            assert pinned[re.sub(r"[-_.]+", "-", requirement.name).lower()] in requirement.specifier, text


def test_the_changelog_begins_with_the_current_version():
    first = re.search(r"^## (\S+?),? ", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert first
    assert first[1] == grammarlab.__version__


def test_a_wheel_carries_the_grammars_and_works_from_any_folder(tmp_path):
    build = f"from hatchling.build import build_wheel; print(build_wheel({str(tmp_path)!r}))"
    name = run_python("-c", build).split()[-1]
    with zipfile.ZipFile(tmp_path / name) as wheel:
        wheel.extractall(tmp_path / "installed")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    command = ("-I", "-c", f"import sys; sys.path.insert(0, sys.argv.pop(1)); {MAIN}", str(tmp_path / "installed"))
    listed = run_python(*command, "list", cwd=elsewhere)
    assert {"toy", "building"} <= {line.split()[0] for line in listed.splitlines()}
    run_python(*command, "sample", "building", "-n", "1", "--no-image", cwd=elsewhere)
    assert (elsewhere / "out" / "building" / "building-00000.glb").stat().st_size > 10_000
