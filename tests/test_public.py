"""The names of `import grammarlab as gl`: all there, each with an example, and nothing is loaded early."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import grammarlab as gl

SOURCE = Path(gl.__file__).read_text(encoding="utf-8")


def test_the_names_are_those_that_type_checkers_see_and_in_order():
    (block,) = [node for node in ast.parse(SOURCE).body if isinstance(node, ast.If)]
    seen = [alias.asname or alias.name for node in block.body for alias in node.names]  # pyright: ignore[reportAttributeAccessIssue]  # imports
    assert sorted(seen) == gl.__all__
    assert set(gl.__all__) < set(dir(gl))


@pytest.mark.parametrize("name", gl.__all__)
def test_every_public_name_is_documented_with_an_example(name):
    public = getattr(gl, name)
    assert public.__module__.startswith("grammarlab.")
    assert ">>> " in (inspect.getdoc(public) or "")


@pytest.mark.parametrize("name", ["nonsense", "numpy"])
def test_other_names_are_refused(name):
    with pytest.raises(AttributeError, match=f"no attribute '{name}'"):
        getattr(gl, name)


def test_a_public_name_is_no_package():
    code = (
        "import grammarlab as gl, pkgutil; print({m.name for m in pkgutil.iter_modules(gl.__path__)} & {*gl.__all__})"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "set()\n"


@pytest.mark.parametrize(
    "code", ["import grammarlab", "from grammarlab.runs.requests.examples import shipped_examples"]
)
def test_importing_does_not_load_the_engine(code):
    code += "; import sys; print('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
