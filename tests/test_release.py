"""What a release consists of: an sdist and a wheel that are what they should be, and work in a fresh environment."""

import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

import grammarlab
from tests.cases import takes_turns

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
BUILD = "import sys; from hatchling import build; print(build.build_{}(sys.argv[1]))"


def run(*command, cwd=ROOT):
    """What a program prints on stdout; an exit code other than 0 fails the test."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(command, cwd=cwd, env=environment, check=True, stdout=subprocess.PIPE, text=True).stdout


def built(kind, folder, source=ROOT):
    return folder / run(sys.executable, "-c", BUILD.format(kind), str(folder), cwd=source).split()[-1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return built("wheel", tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def sdist(tmp_path_factory):
    return built("sdist", tmp_path_factory.mktemp("sdist"))


@pytest.fixture(scope="module")
def program(wheel, tmp_path_factory):
    """The command in a fresh environment with the wheel; what the wheel needs comes from this environment."""
    folder = tmp_path_factory.mktemp("fresh")
    venv.create(folder, with_pip=False)
    fresh = folder / ("Scripts" if os.name == "nt" else "bin")
    pip = (sys.executable, "-m", "pip", "--python", str(fresh / "python"), "--disable-pip-version-check", "--quiet")
    run(*pip, "install", "--no-deps", "--no-index", str(wheel))
    (site,) = (path.parent for path in folder.glob("**/site-packages/grammarlab"))
    (site / "needs.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return fresh / "grammarlab"


@takes_turns
def test_both_files_pass_the_checks_of_an_index(wheel, sdist):
    run(sys.executable, "-m", "twine", "check", "--strict", str(wheel), str(sdist))
    run(sys.executable, "-m", "check_wheel_contents", str(wheel))


def test_the_wheel_is_typed_and_carries_all_modules_and_all_content(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    assert "Typing :: Typed" in PROJECT["project"]["classifiers"]
    assert "grammarlab/py.typed" in names
    modules = {path.relative_to(ROOT).as_posix() for path in (ROOT / "grammarlab").rglob("*.py")}
    content = [path for folder in ("grammars", "scenarios") for path in (ROOT / folder).rglob("*") if path.is_file()]
    assert modules | {f"grammarlab/{path.relative_to(ROOT).as_posix()}" for path in content} <= names
    assert not [name for name in names if name.startswith(("tests", "docs")) or "node_modules" in name]


def test_the_sdist_makes_the_same_wheel(wheel, sdist, tmp_path):
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    (source,) = tmp_path.iterdir()
    again = built("wheel", tmp_path, source)
    assert zipfile.ZipFile(again).namelist() == zipfile.ZipFile(wheel).namelist()
    for needed in ("mkdocs.yml", "constraints.txt", "Makefile", "CITATION.cff", "docs", "tests"):
        assert (source / needed).exists()


def test_the_wheel_works_in_a_fresh_environment_from_any_folder(program, tmp_path):
    assert run(program, "--version", cwd=tmp_path) == f"grammarlab {grammarlab.__version__}\n"
    listed = run(program, "list", cwd=tmp_path)
    assert {"toy", "building"} <= {line.split()[0] for line in listed.splitlines()}
    run(program, "sample", "building", "-n", "1", "--no-image", cwd=tmp_path)
    assert (tmp_path / "out" / "building" / "building-00000.glb").stat().st_size > 10_000
    where = run(program.parent / "python", "-c", "import grammarlab; print(grammarlab.__file__)", cwd=tmp_path)
    assert Path(where).is_relative_to(program.parent.parent)


def test_the_citation_is_of_this_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (\S+)$", citation, re.MULTILINE) == [grammarlab.__version__]
    assert re.findall(r"^license: (\S+)$", citation, re.MULTILINE) == [PROJECT["project"]["license"]]


def test_nothing_is_published_before_the_tests_and_the_wheel_have_run():
    text = (ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
    jobs = dict(re.findall(r"^  (\w+):\n((?:    .*\n)+)", text.split("jobs:\n")[1], re.MULTILINE))
    assert [name for name, job in jobs.items() if "twine upload" in job] == ["publish"]
    (needs,) = re.findall(r"needs: \[(.*)\]", jobs["publish"])
    assert set(needs.split(", ")) == set(jobs) - {"publish"}
    assert "run: .ci/run" in jobs["tests"]
    assert "checkout" not in jobs["install"]
    commands = re.findall(r"^      - run: (.*)", jobs["install"], re.MULTILINE)
    assert commands[0] == "python -m pip install dist/*.whl"
    assert any(command.startswith("grammarlab sample toy -n 1") for command in commands)


def test_workflows_test_the_versions_that_are_promised():
    told = [text.rsplit(" ", 1)[-1] for text in PROJECT["project"]["classifiers"] if re.search(r":: 3\.\d+$", text)]
    for name in ("tests.yml", "release.yml"):
        workflow = (ROOT / ".github" / "workflows" / name).read_text(encoding="utf-8")
        assert re.findall(r"python: \[(.*)\]", workflow) == [", ".join(f'"{version}"' for version in told)]
        assert all(f"{system}-latest" in workflow for system in ("ubuntu", "macos", "windows"))
