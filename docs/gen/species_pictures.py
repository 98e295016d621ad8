"""Pictures of bark, leaves and blossoms for `grammars/species`, made from noise: ``make species-pictures``.

They are tints, bright on average, since the colours of a species are multiplied by them. Bark repeats in both
directions; a leaf has its midrib upright in the middle, its stalk below.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Plane = NDArray[np.float64]
SIZE = 256
"""Pixels along the sides of bark; of leaves half as many across."""
QUALITY = 78


def noise(seed: int, across: float, up: float, shape: tuple[int, int] = (SIZE, SIZE)) -> Plane:
    """Periodic noise of about `across` and `up` waves along the sides, mean 0 and standard deviation 1."""
    rng = np.random.default_rng(seed)
    height, width = shape
    fy, fx = np.fft.fftfreq(height, 1 / height)[:, None], np.fft.fftfreq(width, 1 / width)[None]
    window = np.exp(-((fx / across) ** 2) - (fy / up) ** 2)
    values = np.fft.ifft2(np.fft.fft2(rng.standard_normal(shape)) * window).real
    return (values - values.mean()) / values.std()


def warped(plane: Plane, across: Plane, up: Plane) -> Plane:
    """A periodic plane whose pixels are fetched from some pixels away."""
    rows, columns = np.indices(plane.shape)
    height, width = plane.shape
    return plane[(rows + np.rint(up).astype(int)) % height, (columns + np.rint(across).astype(int)) % width]


def tinted(light: Plane, dark: tuple[float, float, float], bright: tuple[float, float, float]) -> Plane:
    """[H, W, 3] between two colours by a plane of light in 0..1."""
    share = np.clip(light, 0.0, 1.0)[:, :, None]
    return np.array(dark) + share * (np.array(bright) - np.array(dark))


def furrowed() -> Plane:
    """Bark of oaks and poplars: long ridges that split and join, cracked across."""
    ridges = warped(noise(1, 11, 2.2), 7 * noise(2, 3, 3), 10 * noise(3, 2, 2))
    crack = warped(noise(4, 7, 9), 5 * noise(5, 4, 4), 4 * noise(6, 4, 4))
    light = np.clip(np.abs(ridges) * 1.5, 0, 1) ** 0.7 * (0.75 + 0.25 * np.clip(np.abs(crack) * 3, 0, 1))
    return tinted(light + 0.08 * noise(7, 60, 60), (0.42, 0.38, 0.35), (1.0, 0.98, 0.95))


def white() -> Plane:
    """Bark of birches: pale, with dark lenticels across and a few rough scars."""
    light = 0.93 + 0.03 * noise(11, 3, 40) + 0.015 * noise(12, 60, 60)
    rows, columns = np.indices((SIZE, SIZE))
    rng = np.random.default_rng(13)
    for size, number in (((0.035, 0.006), 90), ((0.09, 0.008), 26), ((0.1, 0.05), 5)):
        for _ in range(number):
            x, y = rng.uniform(0, SIZE, 2)
            width, height = (SIZE * side * rng.uniform(0.6, 1.3) for side in size)
            dx = (columns - x + SIZE / 2) % SIZE - SIZE / 2
            dy = (rows - y + SIZE / 2) % SIZE - SIZE / 2
            light -= 0.75 * np.clip(1.6 - 1.6 * ((dx / width) ** 2 + (dy / max(height, 1.2)) ** 2), 0, 1)
    return tinted(light, (0.12, 0.1, 0.1), (1.0, 1.0, 1.0))


def scaly() -> Plane:
    """Bark of spruces and pines: plates with dark seams."""
    rng = np.random.default_rng(21)
    seeds = (np.indices((10, 14)).reshape(2, -1).T + rng.uniform(0, 1, (140, 2))) / (10, 14)
    rows, columns = (np.indices((SIZE, SIZE)) + 0.5) / SIZE
    bend = 0.012 * noise(22, 8, 8), 0.012 * noise(23, 8, 8)
    nearest = np.full((2, SIZE, SIZE), 9.0)
    plate = np.zeros((SIZE, SIZE))
    for y, x in seeds:
        dx = (columns + bend[0] - x + 0.5) % 1.0 - 0.5
        dy = (rows + bend[1] - y + 0.5) % 1.0 - 0.5
        distance = np.hypot(1.35 * dx, dy)
        closer = distance < nearest[0]
        plate[closer] = rng.uniform()
        nearest[1] = np.where(closer, nearest[0], np.minimum(nearest[1], distance))
        nearest[0] = np.minimum(nearest[0], distance)
    seam = np.clip((nearest[1] - nearest[0]) * 40.0, 0.0, 1.0)
    light = seam * (0.72 + 0.25 * plate) + 0.06 * noise(24, 50, 50)
    return tinted(light, (0.38, 0.33, 0.32), (1.0, 0.96, 0.93))


def smooth() -> Plane:
    """Bark of apples, beeches and shrubs: smooth and grey, with blotches and fine lines across."""
    light = 0.8 + 0.07 * noise(31, 5, 4) + 0.04 * noise(32, 10, 60) + 0.03 * noise(33, 60, 60)
    light -= 0.35 * np.clip(noise(34, 16, 60) - 2.1, 0, 1)
    return tinted(light, (0.45, 0.43, 0.42), (1.0, 1.0, 0.98))


def ringed() -> Plane:
    """Bark of palms: scars of leaves as rings, and fibres between them."""
    rows = np.indices((SIZE, SIZE))[0] / SIZE
    ring = (10 * rows + 0.12 * noise(41, 3, 2)) % 1.0
    light = (
        0.95 - 0.3 * ring - 0.4 * np.exp(-(((ring - 0.5) / 0.08) ** 2)) * (0.6 + 0.4 * np.clip(noise(42, 6, 3), -1, 1))
    )
    light += 0.06 * noise(43, 50, 5) + 0.03 * noise(44, 60, 60)
    return tinted(light, (0.4, 0.36, 0.33), (1.0, 0.98, 0.95))


def leaf(seed: int, pairs: int, rise: float, contrast: float = 1.0) -> Plane:
    """A blade with a midrib, pairs of side veins that rise outwards, and finer veins between them."""
    shape = (SIZE, SIZE // 2)
    rows, columns = np.indices(shape)
    x, v = np.abs(2 * (columns + 0.5) / shape[1] - 1), 1 - (rows + 0.5) / shape[0]
    phase = (v - rise * x) * pairs
    vein = np.exp(-((((phase + 0.5) % 1.0 - 0.5) * 9) ** 2)) * np.clip(1.2 - x, 0, 1)
    bulge = np.cos(2 * np.pi * phase)
    rib = np.exp(-((x * shape[1] / 2 / (2.6 - 1.8 * v)) ** 2))
    light = 0.86 - 0.05 * contrast * bulge + 0.03 * noise(seed, 6, 8, shape) + 0.02 * noise(seed + 1, 40, 60, shape)
    light += 0.16 * contrast * vein + 0.3 * rib - 0.06 * x
    return tinted(light, (0.48, 0.5, 0.36), (1.0, 1.0, 0.92))


def striped(seed: int, stripes: int) -> Plane:
    """A blade with veins along it: leaflets of palms, and needles."""
    shape = (SIZE, SIZE // 4)
    rows, columns = np.indices(shape)
    x, v = 2 * (columns + 0.5) / shape[1] - 1, 1 - (rows + 0.5) / shape[0]
    light = (
        0.88 + 0.06 * np.cos(np.pi * stripes * x) + 0.14 * np.exp(-((x / 0.08) ** 2)) + 0.04 * noise(seed, 12, 3, shape)
    )
    return tinted(light - 0.1 * (1 - v), (0.48, 0.5, 0.36), (1.0, 1.0, 0.92))


def blossom(seed: int) -> Plane:
    """A petal: yellowish where it begins, then pink, pale towards its tip, with fine veins."""
    shape = (SIZE // 2, SIZE // 2)
    rows, columns = np.indices(shape)
    x, v = 2 * (columns + 0.5) / shape[1] - 1, 1 - (rows + 0.5) / shape[0]
    veins = np.cos(14 * np.arctan2(x, v + 0.15)) * 0.02 + 0.015 * noise(seed, 8, 8, shape)
    pink = np.exp(-(((v - 0.45) / 0.3) ** 2)) * 0.06 + 0.04 * np.abs(x)
    colors = np.stack([np.ones(shape), 0.97 - pink + veins, 0.97 - 0.7 * pink + veins], axis=2)
    heart = np.clip(1 - v / 0.16, 0, 1)[:, :, None]
    return colors * (1 - heart) + heart * np.array([0.85, 0.85, 0.45])


PICTURES: dict[str, Callable[[], Plane]] = {
    "bark_furrowed": furrowed,
    "bark_white": white,
    "bark_scaly": scaly,
    "bark_smooth": smooth,
    "bark_ringed": ringed,
    "leaf": lambda: leaf(51, 7, 0.3),
    "leaf_oak": lambda: leaf(53, 5, 0.22, 1.2),
    "leaf_birch": lambda: leaf(55, 9, 0.26),
    "leaf_willow": lambda: leaf(57, 16, 0.12, 0.7),
    "leaf_apple": lambda: leaf(59, 6, 0.4, 1.1),
    "leaf_needles": lambda: striped(61, 2),
    "leaf_palm": lambda: striped(63, 9),
    "blossom": lambda: blossom(65),
}


def main(folder: Path) -> None:
    """Write all pictures into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in PICTURES.items():
        pixels = np.rint(np.clip(make(), 0.0, 1.0) * 255).astype(np.uint8)
        Image.fromarray(pixels).save(folder / f"{name}.jpg", quality=QUALITY, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
