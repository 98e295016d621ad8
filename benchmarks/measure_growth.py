"""CPU time of derivations and how it grows: ``python -m benchmarks.measure_growth [--against CHECKOUT]``.

The cases have the shapes of packages that cannot be shipped: walls of thousands of leaves from a few meshes, and
thousands of mirrored inserts. Time is the least of several derivations, in CPU seconds of one core. With another
checkout, both are measured in turn, each in a process of its own, and the ratios are those of this run; `bench_derive`
has the ratio to the interpreter that derives shape by shape. The exponent of growth is that of the line through the
logarithms of number and time: 1 is linear.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from benchmarks.grammars import DRESSED, MIRRORED, SMALL
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
_BATCHES = (1, 16, 64, 256)
_POOL = 20_000
"""Designs of a pool: four times the usual number."""


def cpu_seconds(job: Callable[[], object]) -> float:
    """Least CPU seconds of a job, after a first one that loads what it needs."""
    job()
    times: list[float] = []
    while len(times) < _REPEATS and sum(times) < _SECONDS:
        start = time.process_time()
        job()
        times.append(time.process_time() - start)
    return min(times)


def exponent(numbers: Sequence[float], seconds: Sequence[float]) -> float:
    """Exponent of the growth of time with a number."""
    return float(np.polyfit(np.log(numbers), np.log(seconds), 1)[0])


def of_text(text: str, num_models: int, storeys: int | None = None) -> Callable[[], Forest]:
    """Derivations of a benchmark's grammar."""
    program = compile_grammar(Grammar.parse(text))
    attributes = None if storeys is None else {"storeys": float(storeys)}
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


def measured() -> dict[str, float]:
    """Milliseconds a model of each case."""
    cases: dict[str, tuple[Callable[[], Forest], int]] = {}
    for name, text in (("4,700 leaves of few meshes", DRESSED), ("3,000 mirrored inserts", MIRRORED)):
        cases |= {f"{name}, batch of {number}": (of_text(text, number), number) for number in (1, 16)}
    cases["75 leaves, one model"] = (of_text(SMALL, 1), 1)
    for name in ("building", "skyscraper", "toy"):
        cases |= {
            f"{name}, batch of {number:,}": (of_shipped(name, number), number) for number in (1, 64, 1000, 10_000)
        }
    cases["building, batch of 1,000, no leaves"] = (of_shipped("building", 1000, leaves=False), 1000)
    result = {name: 1e3 * cpu_seconds(job) / number for name, (job, number) in cases.items()}
    dressed = of_text(DRESSED, 16)
    result["4,700 leaves of few meshes, batch of 16, triangles"] = (
        1e3 * cpu_seconds(lambda: triangles(realize(dressed()))) / 16
    )
    return result | of_pool("building")


def growth() -> dict[str, float]:
    """Exponents of the growth with leaves of one model, with inserts that are mirrored, and with the batch."""
    result: dict[str, float] = {}
    for name, text in (("leaves", DRESSED), ("mirrored inserts", MIRRORED)):
        jobs = [of_text(text, 4, storeys) for storeys in _STOREYS]
        result[name] = exponent([len(job().leaves) for job in jobs], [cpu_seconds(job) for job in jobs])
    for name, text in (("models of a batch, leaves", DRESSED), ("models of a batch, inserts", MIRRORED)):
        result[name] = exponent(_BATCHES[1:], [cpu_seconds(of_text(text, number)) for number in _BATCHES[1:]])
    return result


def measured_in(checkout: Path) -> dict[str, float]:
    """`measured` by the package of a checkout, in a process of its own."""
    here = Path(__file__).parent.parent
    code = (
        f"import json, sys, grammarlab; sys.path.insert(0, {str(here)!r});"
        "from benchmarks import measure_growth; print(json.dumps(measure_growth.measured()))"
    )
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    command = [sys.executable, "-P", "-c", code]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return json.loads(ended.stdout)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--against", type=Path, help="another checkout")
    other = parser.parse_args().against
    if other is None:
        for name, milliseconds in measured().items():
            print(f"{name:52} {milliseconds:9.3f} ms a model")
    else:
        here = Path(__file__).parent.parent
        turns = [(measured_in(other), measured_in(here)) for _ in range(_ROUNDS)]
        for name in turns[0][0]:
            before, after = (min(turn[side][name] for turn in turns) for side in (0, 1))
            print(f"{name:52} {before:9.3f} -> {after:9.3f} ms a model, {before / after:6.2f} times as fast")
    for name, power in growth().items():
        print(f"exponent of time over {name:30} {power:5.2f}")


if __name__ == "__main__":
    main()
