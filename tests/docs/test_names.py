"""Files and modules that documents, comments and docstrings name are there."""

import ast
import io
import posixpath
import re
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MADE = {"out", "build", "dist", "node_modules", "__pycache__"}
"""Folders that are not in the repository."""
TOPS = sorted(path.name for path in ROOT.iterdir() if path.is_dir() and path.name[0] != "." and path.name not in MADE)
SUFFIXES = {".py", ".md", ".yml", ".toml", ".js", ".css", ".cga", ".lark", ".template", ".ipynb", ".html"}

PATH = re.compile(rf"(?<![\w/.$)-])(?:\.?/)?((?:{'|'.join(TOPS)})/[\w./*-]*[\w*/])(?![\w$])")
"""A path from the top of the repository, such as `docs/gen/`."""
DOTTED = re.compile(r"(?<![\w./-])grammarlab(?:\.[A-Za-z_]\w*)+(?![\w/-])")
"""A module, or a name inside one."""
SHORT = re.compile(r"`([\w./-]+\.(?:py|js|css|lark))`")
"""The last part of the path of a file, in code font."""
LINK = re.compile(r"\]\((?!https?:)([^()#\s]+)(?:#[^()\s]*)?\)")
GENERATED = re.compile(r"^<!-- generated: .*?^<!-- end of generated -->$", re.MULTILINE | re.DOTALL)


def texts() -> Iterator[Path]:
    """Files of text in the repository, by their paths."""
    folders = [ROOT / name for name in [*TOPS, ".github", ".ci"]]
    found = [path for folder in folders for path in folder.rglob("*") if path.suffix in SUFFIXES]
    found += [path for path in ROOT.iterdir() if path.suffix in SUFFIXES or path.name == "Makefile"]
    return (path for path in sorted(found) if not MADE & set(path.relative_to(ROOT).parts))


FILES = tuple(texts())


@cache
def paths() -> tuple[str, ...]:
    """Paths of all files, each after a slash."""
    found = [path for name in TOPS for path in (ROOT / name).rglob("*") if path.is_file()]
    return tuple(f"/{path.relative_to(ROOT).as_posix()}" for path in found)


def is_path(name: str, folder: Path = ROOT) -> bool:
    """Whether a file or folder, or one of those that an asterisk stands for, is there."""
    name = name.rstrip("/")
    return any(folder.glob(name)) if "*" in name else (folder / name).exists()


@cache
def names_in(path: Path, inside: str = "") -> frozenset[str]:
    """Names that a module, or a class in it, defines or imports."""
    nodes: list[ast.AST] = list(ast.parse(path.read_text(encoding="utf-8")).body)
    if inside:
        nodes = [part for node in nodes if isinstance(node, ast.ClassDef) and node.name == inside for part in node.body]
    found: set[str] = set()
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            found |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.Name):
            found.add(node.id)
        else:
            nodes += ast.iter_child_nodes(node)
    return frozenset(found)


@cache
def is_dotted(name: str) -> bool:
    """Whether a module, or a name inside one, is there."""
    parts = name.split(".")
    for end in range(len(parts), 0, -1):
        module = ROOT.joinpath(*parts[:end])
        file = module.with_suffix(".py") if module.with_suffix(".py").exists() else module / "__init__.py"
        if file.exists():
            rest = parts[end:]
            return (not rest or rest[0] in names_in(file)) and (
                len(rest) < 2 or rest[0] not in classes(file) or rest[1] in names_in(file, rest[0])
            )
    return False


def classes(path: Path) -> set[str]:
    body = ast.parse(path.read_text(encoding="utf-8")).body
    return {node.name for node in body if isinstance(node, ast.ClassDef)}


def prose(path: Path, text: str) -> str:
    """What a file says: of Python comments and docstrings, of TOML comments, of Markdown all but targets of links."""
    if path.suffix == ".md":
        return LINK.sub("](", text)
    if path.suffix == ".toml":
        return "\n".join(re.findall(r"#.*", text))
    if path.suffix != ".py":
        return text
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    comments = [token.string for token in tokens if token.type == tokenize.COMMENT]
    values = [node.value for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Expr)]
    return "\n".join(comments + [str(value.value) for value in values if isinstance(value, ast.Constant)])


def missing(path: Path) -> set[str]:
    """Names in a file of what is not there."""
    text = path.read_text(encoding="utf-8")
    bases = (ROOT, ROOT / "docs") if path.name == "mkdocs.yml" else (ROOT,)
    short = SHORT.findall(GENERATED.sub("", text)) if path.suffix in {".md", ".py"} else []
    gone = {name for name in PATH.findall(text) if not any(is_path(name, base) for base in bases)}
    gone |= {name for name in DOTTED.findall(text) if not is_dotted(name)}
    gone |= {name for name in short if not any(file.endswith(f"/{posixpath.normpath(name)}") for file in paths())}
    return {name for name in gone if name in prose(path, text)}  # few files have any, and only these are read closely


@pytest.mark.parametrize("top", ["", *TOPS, ".github", ".ci"])
def test_what_texts_name_is_there(top: str) -> None:
    files = [path for path in FILES if path.relative_to(ROOT).parts[0] == top or (not top and path.parent == ROOT)]
    assert {f"{path.relative_to(ROOT)}: {name}" for path in files for name in missing(path)} == set()


def test_links_of_documents_lead_to_files() -> None:
    documents = [path for path in FILES if path.suffix == ".md"]
    links = [(path, target) for path in documents for target in LINK.findall(path.read_text(encoding="utf-8"))]
    assert {
        f"{path.relative_to(ROOT)}: {target}" for path, target in links if not is_path(target, path.parent)
    } == set()


def test_names_that_are_gone_are_found(tmp_path: Path) -> None:
    package = "grammarlab"
    there = next(path for path in sorted((ROOT / package).glob("*.py")) if classes(path))
    assert is_path(f"{package}/{there.name}")
    assert is_dotted(f"{package}.{there.stem}")
    assert all(is_dotted(f"{package}.{there.stem}.{name}") for name in classes(there))
    assert not is_dotted(f"{package}.{there.stem}.NoSuchName")
    assert not is_dotted(f"{package}.nowhere")
    assert is_path("docs/*/limits.md")
    assert not is_path("docs/*/nowhere.md")
    module = tmp_path / "module.py"
    module.write_text(f'"""See {package}/gone.py."""\ntext = "{package}.gone.too"\n# as {package}.gone does\n')
    assert missing(module) == {f"{package}/gone.py", f"{package}.gone"}
