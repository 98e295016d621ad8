"""Examples of label grids, and a slow computation of their energy."""

import numpy as np

from grammarlab.synthesis.label_grid import LabelGrid

BEYOND = -7
"""The border label of the oracle."""
NAMES = ("window", "corner", "shop", "door", "quoin", "window-2", "roof")


def shop_house() -> LabelGrid:
    """Corners, a ground floor with one door, alternating windows, a roof line: 7 labels."""
    return LabelGrid.from_labels(
        [
            [1, 2, 3, 2, 2, 1],
            [4, 0, 5, 5, 0, 4],
            [4, 5, 0, 0, 5, 4],
            [4, 0, 5, 5, 0, 4],
            [4, 5, 0, 0, 5, 4],
            [4, 6, 6, 6, 6, 4],
        ],
        NAMES,
    )


def plain_house() -> LabelGrid:
    """The same ground floor below rows of equal windows."""
    labels = shop_house().labels.copy()
    labels[1:5, 1:5] = 0
    return LabelGrid.from_labels(labels, NAMES)


def checker(rows: int = 6, columns: int = 6) -> LabelGrid:
    return LabelGrid.from_labels(np.indices((rows, columns)).sum(axis=0) % 2)


def drawn(rows: int, columns: int, labels: int, seed: int) -> LabelGrid:
    """A grid of random labels."""
    found = np.random.default_rng(seed).integers(0, labels, (rows, columns))
    return LabelGrid.from_labels(np.unique(found, return_inverse=True)[1].reshape(rows, columns))


def slow_energies(example: np.ndarray, grids: np.ndarray) -> np.ndarray:
    """[N] the energy with borders of grids [N, rows, columns] by its definition, from padded arrays.

    Both arrays get a ring of a border label; a window is compared with those of the example with the same border cells;
    plus 9 for each cell whose label the example does not have at the same border. At least 3 rows and columns each.
    """
    padded = np.pad(example, 1, constant_values=BEYOND)
    new = np.pad(grids, ((0, 0), (1, 1), (1, 1)), constant_values=BEYOND)
    total = np.zeros(len(grids), dtype=np.int64)
    for row, column in np.ndindex(grids.shape[1:]):
        window = new[:, row : row + 3, column : column + 3]
        distances, centres = [], []
        for there in np.ndindex(example.shape):
            patch = padded[there[0] : there[0] + 3, there[1] : there[1] + 3]
            if np.array_equal(patch == BEYOND, window[0] == BEYOND):
                distances.append((window != patch).sum(axis=(1, 2)))
                centres.append(example[there])
        total += np.min(distances, axis=0) + 9 * ~np.isin(grids[:, row, column], centres)
    return total


def all_grids(rows: int, columns: int, labels: int) -> np.ndarray:
    """[labels ** (rows * columns), rows, columns] every grid."""
    count = labels ** (rows * columns)
    digits = np.arange(count)[:, None] // labels ** np.arange(rows * columns)
    return (digits % labels).reshape(-1, rows, columns)
