"""The names of `import grammarlab as gl`: all there, each with an example, and nothing is loaded early."""

import ast
import builtins
import doctest
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import grammarlab as gl

RETURNED = {"Facade", "Forest", "LearnedDensity", "Scene", "Skeleton"}
"""Names of values that functions return; their examples make one."""
SOURCE = Path(gl.__file__).read_text(encoding="utf-8")


def test_the_names_are_those_that_type_checkers_see_and_in_order():
    (block,) = [node for node in ast.parse(SOURCE).body if isinstance(node, ast.If)]
    seen = [alias.asname or alias.name for node in block.body for alias in node.names]  # ty: ignore[missing-attribute]  # pyright: ignore[reportAttributeAccessIssue]  # imports
    assert sorted(seen) == gl.__all__
    assert set(gl.__all__) < set(dir(gl))


@pytest.mark.parametrize("name", gl.__all__)
def test_every_public_name_is_documented_with_an_example(name):
    public = getattr(gl, name)
    assert public.__module__.startswith("grammarlab.")
    assert ">>> " in (inspect.getdoc(public) or "")


@pytest.mark.parametrize("name", gl.__all__)
def test_the_example_of_a_public_name_can_be_pasted(name):
    """It imports what it uses, and of this package only the public names; that it runs is tested with all examples."""
    found = doctest.DocTestParser().get_examples(inspect.getdoc(getattr(gl, name)) or "")
    nodes = [node for each in found for node in ast.walk(ast.parse(each.source))]
    used = [node for node in nodes if isinstance(node, ast.Name)]
    imported = [alias for node in nodes if isinstance(node, ast.Import | ast.ImportFrom) for alias in node.names]
    given = {alias.asname or alias.name for alias in imported}
    given |= {node.id for node in used if isinstance(node.ctx, ast.Store)}
    given |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    given |= {node.name for node in nodes if isinstance(node, ast.ExceptHandler) and node.name}
    assert {node.id for node in used} <= given | set(dir(builtins))
    assert not any("from grammarlab" in each.source for each in found)
    assert any(isinstance(node, ast.Attribute) and node.attr == name for node in nodes) or name in RETURNED


@pytest.mark.parametrize("name", ["nonsense", "numpy"])
def test_other_names_are_refused(name):
    with pytest.raises(AttributeError, match=f"no attribute '{name}'"):
        getattr(gl, name)


def test_a_public_name_is_no_package():
    code = (
        "import grammarlab as gl, pkgutil; print({m.name for m in pkgutil.iter_modules(gl.__path__)} & {*gl.__all__})"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "set()\n"


@pytest.mark.parametrize("code", ["import grammarlab", "from grammarlab.runs.sample.shipped import shipped_examples"])
def test_importing_does_not_load_the_engine(code):
    code += "; import sys; print('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


def test_the_first_model_loads_the_engine_and_nothing_else():
    code = (
        "import grammarlab as gl, sys; gl.derive(gl.load('toy'), 1, 1);"
        "print(*{'.'.join(name.split('.')[:parts]) for name in sys.modules for parts in (1, 2)})"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    libraries = {"jax", "optax", "sklearn", "scipy", "pandas", "pyarrow", "trimesh", "PIL", "matplotlib", "shapely"}
    names = ("density", "evaluation", "export", "facade", "learning", "preference", "rendering", "tastes")
    rooms = {f"grammarlab.{name}" for name in names}
    assert not {*loaded} & (libraries | rooms)
