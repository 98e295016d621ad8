"""What JAX has compiled is kept where the person has not said otherwise."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from grammarlab.runs.work import compiled

SCRIPT = """
from grammarlab.runs.work.compiled import keep_compiled
keep_compiled()
import jax, jax.numpy as jnp
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0)
print(jax.jit(lambda x: jnp.sin(x) @ x)(jnp.arange(9.0)))
"""


def test_what_is_compiled_is_found_again(tmp_path: Path) -> None:
    environment = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path), "PATH": "", "JAX_PLATFORMS": "cpu"}
    outputs = [
        subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    kept = [path for path in tmp_path.rglob("*-cache") if path.is_file()]
    assert kept
    assert outputs[0].stdout == outputs[1].stdout
    assert not any(output.stderr for output in outputs)


def test_a_folder_of_the_person_stays(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", "elsewhere")
    monkeypatch.setattr(compiled, "user_cache_path", lambda _name: tmp_path)
    compiled.keep_compiled()
    assert compiled.os.environ["JAX_COMPILATION_CACHE_DIR"] == "elsewhere"


def test_nothing_is_said_where_no_folder_can_be_made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("JAX_COMPILATION_CACHE_DIR", raising=False)
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(compiled, "user_cache_path", lambda _name: tmp_path / "file")
    compiled.keep_compiled()
    assert "JAX_COMPILATION_CACHE_DIR" not in compiled.os.environ
