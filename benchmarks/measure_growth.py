"""CPU time and memory of derivations and how they grow: ``python -m benchmarks.measure_growth [--against CHECKOUT]``.

The cases have the shapes of packages that cannot be shipped: walls of thousands of leaves from a few meshes, with and
without textures, thousands of mirrored inserts, and a temple of round stones. Time is the least of several
derivations, in CPU seconds of one core; memory is the most that arrays and objects take at once, the forest included,
without the interpreter and the libraries. With another checkout, both are measured in turn, each in a process of its
own, and the ratios are those of this run; `bench_derive` has the ratio to the interpreter that derives shape by
shape. The exponent of growth is that of the line through the logarithms of number and time, or memory: 1 is linear.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

import grammarlab
from benchmarks.grammars import DRESSED, MIRRORED, SMALL, TEMPLE, TEXTURED, VARIED
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import compile_grammar, derive
from grammarlab.derivation.forest import Forest
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.learning.designs.design_tables import DesignTables
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool, PoolDesigns
from grammarlab.learning.round import Study, init
from grammarlab.scene import realize
from grammarlab.scene.triangles import triangles

_GRAMMARS = Path(__file__).parent.parent / "grammars"
_LOT = (30.0, 20.0)
_REPEATS, _SECONDS = 9, 2.0
"""Largest number of derivations of one measurement, and CPU seconds after which none begins."""
_ROUNDS = 3
"""Turns of two checkouts."""
_STOREYS = (6, 12, 24, 48, 96)
_BATCHES = (16, 64, 256)
_LARGE_BATCHES = (1_000, 3_000, 10_000)
_KINDS = (75, 150, 300, 600)
"""Numbers of different bays among 600."""
_POOL = 20_000
"""Designs of a pool: four times the usual number."""
_STAND_INS = {
    "4,700 leaves of few meshes": DRESSED,
    "3,000 mirrored inserts": MIRRORED,
    "3,400 leaves with textures": TEXTURED,
    "a temple of 81,000 vertices": TEMPLE,
}
"""Rules with the shapes of large packages."""


def cpu_seconds(job: Callable[[], object]) -> float:
    """Least CPU seconds of a job, after a first one that loads what it needs."""
    job()
    times: list[float] = []
    while len(times) < _REPEATS and sum(times) < _SECONDS:
        start = time.process_time()
        job()
        times.append(time.process_time() - start)
    return min(times)


def megabytes(job: Callable[[], object]) -> float:
    """Most memory that a job takes at once, after a first one that loads what it needs."""
    job()
    tracemalloc.start()
    try:
        job()
        return tracemalloc.get_traced_memory()[1] / 1e6
    finally:
        tracemalloc.stop()


def exponent(numbers: Sequence[float], seconds: Sequence[float]) -> float:
    """Exponent of the growth of time with a number."""
    return float(np.polyfit(np.log(numbers), np.log(seconds), 1)[0])


def of_text(text: str, num_models: int, **attributes: float) -> Callable[[], Forest]:
    """Derivations of a benchmark's grammar."""
    program = compile_grammar(Grammar.parse(text))
    lot = (10.0, 10.0) if text == SMALL else _LOT
    return lambda: derive(program, num_models, 1, footprint=lot, attributes=attributes)


def of_shipped(name: str, num_models: int, *, leaves: bool = True) -> Callable[[], Forest]:
    """Derivations of a shipped grammar whose assets are read once."""
    program, assets = compile_grammar(load(_GRAMMARS / f"{name}.cga")), AssetFolder(_GRAMMARS / "assets")
    return lambda: derive(program, num_models, 1, assets=assets, leaves=leaves)


def of_pool(name: str) -> dict[str, float]:
    """Milliseconds a design of a pool of a shipped grammar: made, and its features counted."""
    space, pool = GrammarSpace(load(_GRAMMARS / f"{name}.cga"), _GRAMMARS / "assets"), Pool(0, _POOL)
    study = Study(space, pool)
    designs, columns = study.tables().pool_designs, init(study).columns
    jobs: dict[str, Callable[[], object]] = {
        "made": lambda: PoolDesigns.of(space, pool),
        "counted": lambda: DesignTables(space, designs, study.settings.features).table(columns),
    }
    return {f"{name}, pool of {_POOL:,}, {what}": 1e3 * cpu_seconds(job) / _POOL for what, job in jobs.items()}


def first_model() -> float:
    """Least CPU seconds of a process that imports the package and derives one model of `toy`."""
    command = [sys.executable, "-P", "-c", "import grammarlab as gl; gl.derive(gl.load('toy'), 1, 1)"]
    environment = {**os.environ, "PYTHONPATH": str(Path(grammarlab.__file__).parent.parent)}
    times: list[float] = []
    for _ in range(_ROUNDS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, env=environment, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times)


def measured() -> dict[str, float]:
    """Milliseconds a model of each case."""
    cases: dict[str, tuple[Callable[[], Forest], int]] = {
        f"{name}, batch of {number}": (of_text(text, number), number)
        for name, text in _STAND_INS.items()
        for number in (1, 16, 64)
    }
    cases["75 leaves, one model"] = (of_text(SMALL, 1), 1)
    for name in ("building", "skyscraper", "toy"):
        cases |= {
            f"{name}, batch of {number:,}": (of_shipped(name, number), number) for number in (1, 64, 1000, 10_000)
        }
    cases["building, batch of 1,000, no leaves"] = (of_shipped("building", 1000, leaves=False), 1000)
    result = {name: 1e3 * cpu_seconds(job) / number for name, (job, number) in cases.items()}
    for name, text in _STAND_INS.items():
        job = of_text(text, 64)
        result[f"{name}, batch of 64, triangles"] = 1e3 * cpu_seconds(partial(_triangles, job)) / 64
    result["toy, first model with the import"] = 1e3 * first_model()
    return result | of_pool("building")


def _triangles(job: Callable[[], Forest]) -> object:
    return triangles(realize(job()))


def rates() -> dict[str, float]:
    """Models, nodes and leaves of a batch of 1,000 `building` in one second."""
    job = of_shipped("building", 1000)
    forest, seconds = job(), cpu_seconds(job)
    return {
        "models of building": 1000 / seconds,
        "nodes of building": len(forest.nodes.model) / seconds,
        "leaves of building": len(forest.leaves) / seconds,
    }


def memory() -> dict[str, float]:
    """Megabytes of batches with leaves."""
    cases = {
        "building, batch of 64": of_shipped("building", 64),
        "building, batch of 1,000": of_shipped("building", 1000),
        "building, batch of 1,000, no leaves": of_shipped("building", 1000, leaves=False),
        "skyscraper, batch of 1,000": of_shipped("skyscraper", 1000),
        "4,700 leaves of few meshes, batch of 16": of_text(DRESSED, 16),
        "3,000 mirrored inserts, batch of 16": of_text(MIRRORED, 16),
        "3,400 leaves with textures, batch of 64": of_text(TEXTURED, 64),
    }
    return {name: megabytes(job) for name, job in cases.items()}


def growth() -> dict[str, float]:
    """Exponents of the growth with leaves, mirrored inserts and different meshes of a model, and with the batch."""
    result: dict[str, float] = {}
    for name, text in (("leaves", DRESSED), ("mirrored inserts", MIRRORED)):
        jobs = [of_text(text, 4, storeys=storeys) for storeys in _STOREYS]
        result[name] = exponent([len(job().leaves) for job in jobs], [cpu_seconds(job) for job in jobs])
    jobs = [of_text(VARIED, 4, kinds=kinds) for kinds in _KINDS]
    result["different meshes"] = exponent(_KINDS, [cpu_seconds(job) for job in jobs])
    batches = [of_shipped("building", number) for number in _LARGE_BATCHES]
    result["models of a batch, building"] = exponent(_LARGE_BATCHES, [cpu_seconds(job) for job in batches])
    result["models of a batch, building, memory"] = exponent(_LARGE_BATCHES, [megabytes(job) for job in batches])
    for name, text in _STAND_INS.items():
        times = [cpu_seconds(of_text(text, number)) for number in _BATCHES]
        result[f"models of a batch, {name}"] = exponent(_BATCHES, times)
    return result


_UNITS = {"measured": "ms a model", "memory": "MB"}


def measured_in(checkout: Path, what: str) -> dict[str, float]:
    """`measured` or `memory` by the package of a checkout, in a process of its own."""
    here = Path(__file__).parent.parent
    code = (
        f"import json, sys, grammarlab; sys.path.insert(0, {str(here)!r});"
        f"from benchmarks import measure_growth; print(json.dumps(measure_growth.{what}()))"
    )
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    command = [sys.executable, "-P", "-c", code]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return json.loads(ended.stdout)


def compare(other: Path) -> None:
    """Print time and memory of another checkout and of this one."""
    here = Path(__file__).parent.parent
    for what, unit in _UNITS.items():
        turns = [
            (measured_in(other, what), measured_in(here, what)) for _ in range(_ROUNDS if what == "measured" else 1)
        ]
        for name in turns[0][0]:
            before, after = (min(turn[side][name] for turn in turns) for side in (0, 1))
            print(f"{name:52} {before:9.3f} -> {after:9.3f} {unit}, {before / after:6.2f} times less")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--against", type=Path, help="another checkout")
    other = parser.parse_args().against
    if other is None:
        for cases, unit in ((measured(), _UNITS["measured"]), (memory(), _UNITS["memory"])):
            for name, value in cases.items():
                print(f"{name:52} {value:9.3f} {unit}")
        for name, value in rates().items():
            print(f"{name:52} {value:9,.0f} a second")
    else:
        compare(other)
    for name, power in growth().items():
        print(f"exponent over {name:50} {power:5.2f}")


if __name__ == "__main__":
    main()
