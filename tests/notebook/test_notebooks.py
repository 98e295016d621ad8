"""All notebooks run, at a small size."""

import ast
import re
from pathlib import Path

import pytest

import grammarlab as gl
from tests.cases import some
from tests.waiting import PATIENCE

FOLDER = Path(__file__).parents[2] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
SMALL = {
    "GRAMMAR": '"toy"',
    "NUM_MODELS": "4",
    "NUM_TOWERS": "100",
    "NUM_LABELS": "32",
    "SCORE": '"100 * ({MESH2:0} > 0)"',
    "SIDE": "2",
    "NUM_SEEDS": "1",
    "BUDGETS": "(8, 16)",
}
"""Values for the cells that are marked as parameters."""
ALIVE = """
import gc
import grammarlab as gl
for widget in [each for each in gc.get_objects() if isinstance(each, gl.ScoringSession)]:
    print(widget.do("score", models=list(widget.state["models"])[:1], score=50)["saved"])
"""
"""What a person at the page of each session would do next."""


def opened(path):
    """The notebook of a file."""
    import nbformat  # takes seconds, which tests of other files do not wait for

    return nbformat.read(path, as_version=4)


def small(notebook):
    """The notebook with small parameters; each that it has must be known here."""
    for cell in notebook.cells:
        if "parameters" in cell.metadata.get("tags", ()):
            names = re.findall(r"^(\w+) = ", cell.source, re.MULTILINE)
            cell.source = "\n".join(f"{name} = {SMALL[name]}" for name in names)
    return notebook


@pytest.mark.parametrize("path", some(NOTEBOOKS), ids=lambda path: path.stem)
def test_every_notebook_runs(path, tmp_path, monkeypatch):
    from nbclient import NotebookClient
    from nbformat.v4 import new_code_cell

    monkeypatch.setenv("PYTHONWARNINGS", "default")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    notebook = small(opened(path))
    shows_page = any("ScoringSession" in cell.source for cell in notebook.cells)
    notebook.cells.append(new_code_cell(ALIVE))
    NotebookClient(notebook, timeout=int(PATIENCE), resources={"metadata": {"path": str(tmp_path)}}).execute()
    printed = "".join(output.text for output in notebook.cells[-1].outputs)
    assert printed == "True\n" * shows_page


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_imports_the_public_names_and_nothing_private(path):
    source = "\n".join(cell.source for cell in opened(path).cells if cell.cell_type == "code")
    nodes = list(ast.walk(ast.parse(source)))
    modules = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    modules += [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    assert [name for name in modules if name.startswith("grammarlab")] == ["grammarlab"]
    names = {node.attr for node in nodes if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "gl"}
    assert names
    assert names <= set(gl.__all__)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_are_kept_without_outputs(path):
    for cell in opened(path).cells:
        assert not cell.get("outputs")
        assert cell.get("execution_count") is None
