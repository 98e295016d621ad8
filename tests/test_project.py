"""What the project says about itself is true."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.version import Version

import grammarlab

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


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
    order = re.search(r"```\n(__main__\n.*?)```", text, re.DOTALL)
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


def test_the_changelog_has_what_is_unreleased_and_then_the_current_version():
    unreleased, released = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[:2]
    assert (unreleased, released.rstrip(",")) == ("Unreleased", grammarlab.__version__)


def below(folder: Path, name: str) -> bool:
    """Whether a file or folder has this name, or path, at any depth below a folder."""
    return any(folder.rglob(name.rstrip("/")))


def test_files_and_folders_that_a_readme_or_the_map_names_are_there():
    """Names in code font, below the folder of the README or of the row of the map."""
    map_text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    texts = re.findall(r"^\| `(grammarlab/[a-z/]+/)` \| (.*) \|$", map_text, re.MULTILINE)
    readmes = (ROOT / "grammarlab").glob("**/README.md")
    texts += [(path.parent.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")) for path in readmes]
    named = {(folder, name) for folder, text in texts for name in re.findall(r"`([\w./-]+(?:\.py|/))`", text)}
    gone = {(folder, name) for folder, name in named if not below(ROOT / folder, name) and not (ROOT / name).exists()}
    assert gone == set()


def test_contributors_are_told_where_twenty_things_are():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = re.search(r"## Where is …\?\n\n(.*?)\n\n", text, re.DOTALL)
    assert table
    rows = table[1].splitlines()[2:]
    assert len(rows) >= 20
    assert all(re.search(r"`\w+/", row) or "`grammarlab show" in row for row in rows)
