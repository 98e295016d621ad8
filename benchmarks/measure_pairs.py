"""Whether comparisons that agree give the learned density their direction, on random grammars, attributes and sets.

Prints one line per set: the grammar, the preferred attribute, the number of comparisons, and the change of the
attribute's mean by the density, in standard deviations. Run from the
repository: `python -m benchmarks.measure_pairs 200`.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.derivation.forest import Forest
from grammarlab.features.named_features import count
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.learning.answers import answers_of
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.round import Study, init, step
from grammarlab.preference.labels import SCORES, Kind, Label, Labels
from grammarlab.scene.instances import realize

GRAMMARS = Path(__file__).parent.parent / "grammars"
TOWER = """
attr height = rand(3, 9)
Lot --> extrude(height) split(y) { ~1 : Storey }*
Storey --> 60% : color("#bb8866") Brick. else : color("#8899aa") Glass.
"""
BOXES = """
attr width = rand(4, 16)
attr depth = rand(4, 16)
attr height = rand(3, 30)
Lot --> s(width, 0, depth) extrude(height) Mass
Mass --> 50% : split(y) { ~1 : Wall | 1 : Flat. } 30% : split(y) { ~1 : Wall | 2 : Gable. } else : Wall
Wall --> 50% : Brick. else : Glass.
"""
STOREYS = """
Lot --> s(8, 0, 6) extrude(3) Storey
Storey --> 70% : Body [ t(0, 3, 0) Storey ] else : Body
Body --> split(x) { ~2 : Window }*
Window --> 50% : Arched. 30% : Square. else : Blind.
"""
SEED = 3
NUM_MODELS = 200
"""Number of models that comparisons are about."""
NUM_MEASURED = 1_500
"""Number of models of the pool by which the density is measured."""
LEAST = 0.1
"""Least change in standard deviations that counts as the right direction."""


@dataclass(frozen=True)
class Subject:
    """A grammar with the symbols whose numbers may be preferred."""

    name: str
    grammar: Grammar
    symbols: tuple[str, ...] = ()

    @cached_property
    def study(self) -> Study[Forest]:
        return Study(GrammarSpace(self.grammar), Pool())

    @cached_property
    def compared(self) -> dict[str, Floats]:
        """[models] each attribute that varies, of the models that comparisons are about."""
        values = self._measured([Address(False, SEED, model) for model in range(NUM_MODELS)])
        return {name: column for name, column in values.items() if np.ptp(column) > 1e-6}

    @cached_property
    def measured(self) -> dict[str, Floats]:
        """[models] each attribute of the first models of the pool."""
        return self._measured(list(self.study.tables().addresses[:NUM_MEASURED]))

    def _measured(self, addresses: list[Address]) -> dict[str, Floats]:
        forest = self.study.space.derive(addresses)  # ty: ignore[missing-attribute]  # pyright: ignore[reportAttributeAccessIssue]  # of grammars
        counts = count(forest, list(self.symbols))
        return extents(forest) | dict(zip(self.symbols, counts.T, strict=True))


def extents(forest: Forest) -> dict[str, Floats]:
    """[models] width, height and depth of the models, metres."""
    scene = realize(forest)
    corners = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    frames = scene.frames[scene.frame].reshape(-1, 3, 3)
    points = scene.position[:, None] + np.einsum("nij,nkj->nki", frames, scene.size[:, None] * corners)
    low, high = np.full((scene.num_models, 3), np.inf), np.full((scene.num_models, 3), -np.inf)
    np.minimum.at(low, scene.model, points.min(axis=1))
    np.maximum.at(high, scene.model, points.max(axis=1))
    return dict(zip(("width", "height", "depth"), (high - low).T, strict=True))


def comparisons(values: Floats, text_hash: str, num: int, num_ties: int, randomness: np.random.Generator) -> Labels:
    """Comparisons of random pairs, all decided for the higher value; the last ones are ties of nearly equal models."""
    labels = list[Label]()
    while len(labels) < num:
        first, second = randomness.choice(len(values), 2, replace=False).tolist()
        near = abs(values[first] - values[second]) <= 0.1 * values.std()
        if near != (len(labels) >= num - num_ties):
            continue
        if values[first] < values[second]:
            first, second = second, first
        kind: Kind = "tie" if near else "rather"
        other = f'{{"seed":{SEED},"model":{second}}}'
        labels.append(Label(SEED, first, "overall", SCORES[kind][0], text_hash, kind=kind, other=other))
    return Labels(tuple(labels))


def change(subject: Subject, labels: Labels, name: str, sign: float) -> float:
    """Change of the mean of an attribute by the learned density, in standard deviations."""
    study = subject.study
    state = step(study, init(study), answers_of(labels, study.space.hashes))
    assert state.product is not None
    rows = study.table(state).rows[:NUM_MEASURED]
    base = study.tables(state.wide).pool_designs.weights[:NUM_MEASURED]
    density = base * np.maximum(state.product.predict(rows).mean, 0.0)
    values = sign * subject.measured[name]
    mean = float(np.average(values, weights=base))
    deviation = float(np.sqrt(np.average((values - mean) ** 2, weights=base)))
    return (float(np.average(values, weights=density)) - mean) / deviation if density.any() else 0.0


def main() -> None:
    num_sets = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    subjects = (
        Subject("tower", Grammar.parse(TOWER), ("Storey", "Brick.", "Glass.")),
        Subject("boxes", Grammar.parse(BOXES), ("Brick.", "Flat.", "Gable.")),
        Subject("storeys", Grammar.parse(STOREYS), ("Storey", "Arched.", "Blind.")),
        Subject("toy", load(GRAMMARS / "toy.cga")),
        Subject("limits_discrete", load(GRAMMARS / "limits_discrete.cga")),
    )
    right = 0
    for number in range(num_sets):
        randomness, subject = np.random.default_rng(number), subjects[number % len(subjects)]
        name, sign = str(randomness.choice(list(subject.compared))), float(randomness.choice([-1.0, 1.0]))
        num, share = int(randomness.integers(12, 61)), float(randomness.choice([0.0, 0.1]))
        values = sign * subject.compared[name]
        labels = comparisons(values, subject.grammar.hash, num, round(share * num), randomness)
        found = change(subject, labels, name, sign)
        right += found > LEAST
        print(
            f"{number} {subject.name}: {'more' if sign > 0 else 'less'} {name}, {num} comparisons: {found:.2f}",
            flush=True,
        )
    print(f"right direction: {right} of {num_sets}")


if __name__ == "__main__":
    main()
