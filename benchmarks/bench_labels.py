"""Labels of a facade of 8 x 15 units after one of 6 x 6, beside 100 runs of the paper's method.

Target: less than 1 s on one core; an energy that is never above the best of 100 runs. The energies are in the column of
extra information (`--benchmark-json`, or run this file).
"""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest

from grammarlab.synthesis.label_grid import LabelGrid
from grammarlab.synthesis.label_synthesis import synthesize
from tests.synthesis.grids import checker, drawn, plain_house, shop_house

ROWS, COLUMNS = 8, 15
EXAMPLES = {
    "checker": checker(),
    "plain house": plain_house(),
    "shop house": shop_house(),
    "4 labels at random": drawn(6, 6, 4, seed=0),
    "7 labels at random": drawn(6, 6, 7, seed=1),
}


@pytest.mark.parametrize("example", EXAMPLES.values(), ids=EXAMPLES)
def test_exact(benchmark, example: LabelGrid):
    found = benchmark(synthesize, [example], ROWS, COLUMNS)[0]
    runs = synthesize([example], ROWS, COLUMNS, method="em", count=100)
    assert found.energy <= min(run.energy for run in runs)
    benchmark.extra_info.update(energies(example))


@pytest.mark.parametrize("example", EXAMPLES.values(), ids=EXAMPLES)
def test_the_papers_method(benchmark, example: LabelGrid):
    benchmark(synthesize, [example], ROWS, COLUMNS, method="em")


def energies(example: LabelGrid) -> dict[str, float]:
    """Energies with borders and without, of both methods."""
    start = process_time()
    found = synthesize([example], ROWS, COLUMNS)[0]
    seconds = process_time() - start
    runs = synthesize([example], ROWS, COLUMNS, method="em", count=100)
    return {
        "energy": found.energy,
        "bound": found.bound,
        "seconds": round(seconds, 2),
        "em best": min(run.energy for run in runs),
        "em median": float(np.median([run.energy for run in runs])),
        "paper's E": found.paper_energy,
        "em best paper's E": min(run.paper_energy for run in runs),
        "em median paper's E": float(np.median([run.paper_energy for run in runs])),
    }


if __name__ == "__main__":
    for name, each in EXAMPLES.items():
        print(name, energies(each))
