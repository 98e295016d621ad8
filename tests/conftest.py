"""The same examples in every run, HYPOTHESIS_PROFILE=explore looks for new ones; and no core is wasted."""

from __future__ import annotations

import gc
import os
import sys
import tempfile
import time
from collections.abc import Generator, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from grammarlab.locks import try_lock
from grammarlab.runs.work.compiled import keep_compiled
from tests.cases import PART, is_due

# On a busy machine everything is slow, which is no fault of a test.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("repeatable", settings.get_profile("patient"), derandomize=True)
settings.register_profile("explore", settings.get_profile("patient"), max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

# Tests run side by side: idle threads of numerical libraries sleep instead of spinning on a core that others need.
# NumPy reads this when it is imported. Results do not depend on it.
os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "4")
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
# Tests start many processes, which would each translate hundreds of modules of ours to bytecode.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# What one test has compiled is not compiled again by another one, nor by the processes that it starts.
keep_compiled()
# A third of the seconds of tests of processes is optimisation of code that runs a few times on small inputs.
# `make test-all` compiles as for a user.
if PART is not None:
    os.environ.setdefault("JAX_DISABLE_MOST_OPTIMIZATIONS", "1")


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Generator[None, object, object]:
    """Nothing is garbage while tests are collected: millions of objects of modules are not looked through each time."""
    with _one_worker_at_a_time(session.config):
        gc.disable()
        try:
            return (yield)
        finally:
            gc.enable()
            gc.freeze()


@contextmanager
def _one_worker_at_a_time(config: pytest.Config) -> Iterator[None]:
    """In a new checkout the second worker finds the bytecode of the first, instead of making it beside it."""
    run = getattr(config, "workerinput", {}).get("testrunuid")
    if run is None:
        yield
        return
    path = Path(tempfile.gettempdir()) / f"grammarlab-tests-{run}"
    with path.open("wb") as file:
        while not try_lock(file.fileno()):
            time.sleep(0.1)
        yield
    with suppress(OSError):
        path.unlink()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out dear tests whose turn it is not, unless the files or tests to run were named."""
    if config.option.keyword or any(".py" in argument for argument in config.args):
        return
    waiting = [item for item in items if item.get_closest_marker("takes_turns") and not is_due(item.name)]
    if waiting:
        config.hook.pytest_deselected(items=waiting)
        items[:] = [item for item in items if item not in set(waiting)]


def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """What is still used after a file of tests is not looked through for garbage again and again.

    Compiled code and caches are millions of objects, and each full search through all of them takes a second.
    """
    if nextitem is None or nextitem.path != item.path:
        gc.collect()
        gc.freeze()
