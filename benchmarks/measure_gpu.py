"""What a GPU gives: ``python -m benchmarks.measure_gpu``, with JAX for a GPU.

Three jobs, each on every device that JAX has, as wall seconds in one run:

- one sequence of operations of a derivation (draw a rule, split into four parts, place them, order them by rule), as
  NumPy does it today, array call by array call, and compiled as a whole;
- the evidence of a kernel with its gradient, the inner loop of learning;
- a whole fit of scores, `gl.fit`, which is what a person waits for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

import grammarlab as gl
from grammarlab.arrays import Floats
from grammarlab.preference.observations import observe
from grammarlab.preference.processes.evidence import loss, padded

_SHAPES = (1_000, 100_000, 4_000_000)
"""Numbers of shapes that are split."""
_LABELS = ((128, 256), (512, 256), (2048, 256))
"""Numbers of scores and of columns."""
_FITS = ((128, 200), (512, 200))
_PARTS = 4
"""Parts of a split."""
_RULES = np.array([0.1, 0.4, 0.7, 1.0])
"""Cumulative probabilities of the rules of a part."""


class Shapes(NamedTuple):
    """Columns of N shapes, as a forest has them."""

    keys: Any
    """[N] keys of draws; arrays are NumPy's or JAX's."""
    frames: Any
    """[N] index of the rotation."""
    origins: Any
    """[N, 3] in metres."""
    sizes: Any
    """[N, 3] in metres."""


def shapes(num: int) -> Shapes:
    """Boxes at random places."""
    randomness = np.random.default_rng(1)
    return Shapes(
        randomness.integers(0, 2**63, num, dtype=np.uint64),
        randomness.integers(0, len(rotations()), num),
        randomness.random((num, 3)) * 100.0,
        randomness.random((num, 3)) * 10.0 + 1.0,
    )


def rotations() -> Floats:
    """[64, 3, 3] rotations about the vertical axis."""
    angle = np.arange(64) * np.pi / 32.0
    sine, cosine, zero, one = np.sin(angle), np.cos(angle), np.zeros(64), np.ones(64)
    return np.stack([cosine, zero, sine, zero, one, zero, -sine, zero, cosine], axis=1).reshape(-1, 3, 3)


def derived(xp: Any, turns: Any, limits: Any, parents: Shapes) -> Shapes:
    """The parts of shapes that are split along x, a rule drawn for each and ordered by rule."""
    parent = xp.repeat(xp.arange(len(parents.keys)), _PARTS)
    part = xp.tile(xp.arange(_PARTS), len(parents.keys))
    keys = _mixed(xp, parents.keys[parent] + part.astype(np.uint64))
    rule = xp.searchsorted(limits, (keys >> np.uint64(11)).astype(np.float64) * 2.0**-53)
    # Two parts of one metre, or of less where there is less room, and two that share the rest.
    fixed = xp.minimum(1.0, parents.sizes[:, 0] / _PARTS)
    rest = (parents.sizes[:, 0] - 2.0 * fixed) / 2.0
    widths = xp.stack([fixed, rest, rest, fixed], axis=1)
    offset = (xp.cumsum(widths, axis=1) - widths).reshape(-1)
    frames = parents.frames[parent]
    origins = parents.origins[parent] + turns[frames][:, :, 0] * offset[:, None]
    sizes = xp.concatenate([widths.reshape(-1, 1), parents.sizes[parent][:, 1:]], axis=1)
    order = xp.argsort(rule, stable=True)
    return Shapes(keys[order], frames[order], origins[order], sizes[order])


def _mixed(xp: Any, keys: Any) -> Any:
    """Random 64-bit words from keys (SplitMix64)."""
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        keys = (keys ^ (keys >> np.uint64(shift))) * xp.asarray(factor, dtype=np.uint64)
    return keys ^ (keys >> np.uint64(31))


def seconds(run: Callable[[], object], repeats: int = 5) -> float:
    """Least wall seconds of some runs after a first one, which compiles."""
    run()
    times = list[float]()
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def derivation(device: Any) -> Iterator[str]:
    """Nanoseconds a shape of one sequence of operations."""
    compiled = jax.jit(lambda turns, limits, parents: derived(jnp, turns, limits, parents))
    for num in _SHAPES:
        parents = shapes(num)
        with np.errstate(over="ignore"):
            plain = seconds(lambda: derived(np, rotations(), _RULES, parents))  # noqa: B023 - runs at once
        there = jax.device_put((rotations(), _RULES, parents), device)
        inside = seconds(lambda: jax.block_until_ready(compiled(*there)))  # noqa: B023 - runs at once
        back = seconds(lambda: jax.device_get(compiled(*there)))  # noqa: B023 - runs at once
        per = 1e9 / (num * _PARTS)
        yield (
            f"split {num * _PARTS:>10,} parts   NumPy {plain * per:8.1f} ns a shape   compiled {inside * per:8.2f} ns"
            f"   with the way back {back * per:8.2f} ns"
        )


def evidence(device: Any) -> Iterator[str]:
    """Milliseconds of the evidence of a kernel and its gradient."""
    gradient = jax.jit(jax.value_and_grad(lambda weights, data: loss(1.0, weights, 0.01, data)))
    for num, width in _LABELS:
        rows, scores = _labels(num, width)
        data = jax.device_put(padded(observe(rows, scores / 100.0), width), device)
        weights = jax.device_put(np.full(width, 0.05), device)
        taken = seconds(lambda: jax.block_until_ready(gradient(weights, data)))  # noqa: B023 - runs at once
        yield f"evidence of {num:>5} scores x {width} columns   {taken * 1e3:8.2f} ms"


def fits(device: Any) -> Iterator[str]:
    """Seconds of a whole fit, compiled before."""
    for num, width in _FITS:
        rows, scores = _labels(num, width)
        with jax.default_device(device):
            taken = seconds(lambda: gl.fit(rows, scores), 2)  # noqa: B023 - runs at once
        yield f"gl.fit of {num:>5} scores x {width} columns   {taken:8.2f} s"


def _labels(num: int, width: int) -> tuple[Floats, Floats]:
    """Rows of small counts, and scores that two of them decide."""
    randomness = np.random.default_rng(2)
    rows = randomness.poisson(1.0, (num, width)).astype(np.float64)
    liked = (rows[:, 3] > 0.5) & (rows[:, 7] < 1.5)
    return rows, 80.0 * liked.astype(np.float64) + randomness.random(num) * 10.0


def main() -> None:
    devices = [jax.devices("cpu")[0]]
    if jax.default_backend() != "cpu":
        devices.append(jax.devices()[0])
    for device in devices:
        print(device.device_kind, flush=True)
        with jax.enable_x64(True):
            for line in (*derivation(device), *evidence(device)):
                print("  " + line, flush=True)
        for line in fits(device):
            print("  " + line, flush=True)


if __name__ == "__main__":
    main()
