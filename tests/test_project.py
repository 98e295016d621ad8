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


def test_pictures_and_links_of_the_documents_exist():
    for document in ROOT.glob("*.md"):  # those of the site are checked where it is built
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


def test_paths_that_the_documents_name_exist():
    """Paths in code font that begin with a top folder."""
    tops = "|".join(
        path.name for path in ROOT.iterdir() if path.is_dir() and path.name[0] != "." and path.name != "out"
    )
    documents = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("**/*.md"), *(ROOT / "grammarlab").glob("**/README.md")]
    for document in documents:
        text = document.read_text(encoding="utf-8")
        for path in re.findall(rf"`((?:{tops})/[\w./-]+)`", text):
            assert (ROOT / path).exists(), f"{document.name}: {path}"


def below(folder: Path, name: str) -> bool:
    """Whether a file or folder has this name, or path, at any depth below a folder."""
    return any(folder.rglob(name.rstrip("/")))


def test_files_and_rooms_that_the_documents_name_are_there():
    """Names in code font: below the folder of the README or of the row of the map; of files on pages, anywhere."""
    map_text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    texts = re.findall(r"^\| `(grammarlab/[a-z/]+/)` \| (.*) \|$", map_text, re.MULTILINE)
    readmes = (ROOT / "grammarlab").glob("**/README.md")
    texts += [(path.parent.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")) for path in readmes]
    named = [(folder, name) for folder, text in texts for name in re.findall(r"`([\w./-]+(?:\.py|/))`", text)]
    pages = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "docs").glob("**/*.md"))
    named += [(top, name) for name in set(re.findall(r"`([\w./-]+\.py)`", pages)) for top in ["grammarlab", "tests"]]
    there = {(folder, name) for folder, name in named if below(ROOT / folder, name) or (ROOT / name).exists()}
    found = {name for folder, name in there if folder in {"grammarlab", "tests"}}
    assert {f"{folder}: {name}" for folder, name in {*named} - there if name not in found} == set()


def test_contributors_are_told_where_twenty_things_are():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = re.search(r"## Where is …\?\n\n(.*?)\n\n", text, re.DOTALL)
    assert table
    rows = table[1].splitlines()[2:]
    assert len(rows) >= 20
    assert all(re.search(r"`\w+/", row) or "`grammarlab show" in row for row in rows)
